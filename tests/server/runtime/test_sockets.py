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
    near.setblocking(False)
    heard: list[bytes] = []

    def fetch(_everything: bool) -> None:
        try:
            heard.append(near.recv(10))
        except BlockingIOError:
            return
        inbox.post(lambda: "served")

    sockets.add([(near, lambda: None)], fetch)
    threading.Thread(target=far.send, args=(b"x",)).start()
    event = inbox.wait(20)
    assert callable(event)
    assert (event(), heard) == ("served", [b"x"])
    sockets.remove([near], fetch)
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
