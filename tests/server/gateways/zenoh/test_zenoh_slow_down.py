"""Threads of Zenoh wait for clients that send too much, and send to those that read slowly."""

from __future__ import annotations

import threading
import time

import pytest

from simx_server.gateways.zenoh.posting import MUCH_UNSENT, Care, Postman
from simx_server.gateways.zenoh.throttle import KEPT_FREE, LONGEST, PAUSE, Throttle

TIMEOUT = 20.0


def test_a_throttle_never_keeps_all_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    slept: list[float] = []
    throttle = Throttle(KEPT_FREE + 1)

    def sleep(seconds: float) -> None:
        slept.append(seconds)
        throttle.slow_down(0)  # another thread: none is free for it, so it does not wait

    monkeypatch.setattr(time, "sleep", sleep)
    Throttle(0).slow_down(0)
    assert slept == []
    throttle.slow_down(1 << 30)
    assert slept == [LONGEST]


def test_the_more_links_are_slowed_down_the_longer_each_waits(monkeypatch: pytest.MonkeyPatch) -> None:
    slept: list[float] = []
    throttle = Throttle(100)

    def sleep(seconds: float) -> None:
        slept.append(seconds)
        if len(slept) < 5:
            throttle.slow_down(0)

    monkeypatch.setattr(time, "sleep", sleep)
    throttle.slow_down(0)
    assert slept == [pytest.approx(PAUSE * n) for n in range(1, 6)]


def test_the_physics_thread_waits_for_one_client_once_and_threads_send_from_then_on() -> None:
    care, sent, behind = Care(), [], []
    slow, other = Postman(care, behind.append), Postman(care, behind.append)
    reads_again, done = threading.Event(), threading.Event()
    care.sent(time.monotonic() - 1.0)  # it was waited for somebody
    slow.send(lambda: (reads_again.wait(TIMEOUT), sent.append(0)), MUCH_UNSENT + 1)
    slow.send(lambda: (sent.append(1), done.set()), 1)
    other_done = threading.Event()
    other.send(other_done.set, 1)
    assert other_done.wait(TIMEOUT)
    assert sent == []
    assert behind == [True]
    reads_again.set()
    assert done.wait(TIMEOUT)
    assert sent == [0, 1]
    assert behind == [True, False]


def test_while_all_read_nothing_is_handed_to_a_thread() -> None:
    sent: list[str] = []
    postman = Postman(Care(), lambda is_behind: pytest.fail(f"fell behind: {is_behind}"))
    postman.send(lambda: sent.append(threading.current_thread().name), 1 << 30)
    assert sent == [threading.current_thread().name]
