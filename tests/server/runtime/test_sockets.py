"""Sockets that the physics thread reads while it waits."""

from __future__ import annotations

import socket
import threading

from simx_server.runtime.inbox import Inbox
from simx_server.runtime.sockets import Sockets


def test_a_wait_ends_when_a_socket_has_something() -> None:
    inbox, sockets = Inbox(), Sockets()
    inbox.sockets = sockets
    near, far = socket.socketpair()
    heard: list[bytes] = []

    def read() -> None:
        heard.append(near.recv(10))
        inbox.post(lambda: "served")

    sockets.add(near, read)
    threading.Thread(target=far.send, args=(b"x",)).start()
    event = inbox.wait(20)
    assert callable(event)
    assert (event(), heard) == ("served", [b"x"])
    sockets.remove(near)
    sockets.close()
    near.close()
    far.close()


def test_a_socket_can_be_waited_for_until_it_takes_something() -> None:
    sockets = Sockets()
    near, far = socket.socketpair()
    near.setblocking(False)
    done: list[str] = []
    sockets.add(near, lambda: done.append("reads"))
    sockets.change(near, lambda: done.append("sends"), to_send=True)
    sockets.poll(20)
    sockets.change(near, lambda: done.append("reads"), to_send=False)
    sockets.poll()
    far.send(b"x")
    sockets.poll(20)
    assert done == ["sends", "reads"]
    sockets.close()
    near.close()
    far.close()


def test_a_post_of_another_thread_ends_the_wait() -> None:
    inbox, sockets = Inbox(), Sockets()
    inbox.sockets = sockets
    threading.Thread(target=inbox.post, args=(lambda: 7,)).start()
    event = inbox.wait(20)
    assert callable(event)
    assert event() == 7
    assert inbox.wait(0) is None
    sockets.close()
