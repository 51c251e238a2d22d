"""Sockets that the physics thread reads while it waits."""

from __future__ import annotations

import socket
import threading
from types import SimpleNamespace

import pytest

from simx_server.service.queue import sockets as module
from simx_server.service.queue.inbox import Inbox
from simx_server.service.queue.sockets import Sockets


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


class Look:
    """Sockets whose looks are counted; another program takes as long as the test says, by a clock of the test's."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now, self.looks, self.other_takes = 100.0, 0, 0.0
        self.near, self.far = socket.socketpair()
        self.sockets = Sockets()
        self.heard: list[bytes] = []
        self.sockets.add(self.near, lambda: self.heard.append(self.near.recv(10)))
        monkeypatch.setattr(module, "time", SimpleNamespace(perf_counter=lambda: self.now))
        monkeypatch.setattr(module, "_let_others", self._let_others)

    def _let_others(self) -> None:
        self.looks += 1
        self.now += module.LOOK / 4 + self.other_takes
        if self.looks == 3:
            self.far.send(b"x")

    def close(self) -> None:
        self.sockets.close()
        self.near.close()
        self.far.close()


def test_a_client_that_is_expected_is_looked_for_before_the_wait(monkeypatch: pytest.MonkeyPatch) -> None:
    look = Look(monkeypatch)
    look.sockets.poll(0.001)
    assert not look.looks
    look.sockets.expect()
    look.sockets.poll(20)
    assert (look.looks, look.heard) == (3, [b"x"])
    look.sockets.expect()
    look.sockets.poll(0.001)
    assert look.looks > 3, "a look ends when nothing comes"
    look.close()


def test_no_look_is_made_for_a_while_after_another_program_took_the_core(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    look = Look(monkeypatch)
    look.other_takes = 2 * module.LATE
    for _ in range(3):
        look.sockets.expect()
        look.sockets.poll(0.001)
    assert look.looks == 1
    look.now += module.PAUSE
    look.sockets.expect()
    look.sockets.poll(0.001)
    assert look.looks == 2
    look.close()
