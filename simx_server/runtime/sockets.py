"""Sockets that the physics thread reads itself, while it waits for the next thing to do.

A thread of a gateway that reads a socket and wakes the physics thread costs as much as the call itself. Here the
physics thread waits for the sockets, and other threads wake it with a byte.
"""

from __future__ import annotations

import contextlib
import selectors
import socket
from collections.abc import Callable, Iterable
from typing import Any

Fetch = Callable[[bool], object]
"""Reads what has arrived at some sockets, and queues it; does not wait. With False, the first message is enough: the
physics thread comes back before it waits.
"""


class Sockets:
    """The sockets of one server loop. Physics thread, except `wake`."""

    def __init__(self) -> None:
        self._selector = selectors.DefaultSelector()
        self._wake, self._waker = socket.socketpair()
        for end in (self._wake, self._waker):
            end.setblocking(False)
        self._selector.register(self._wake, selectors.EVENT_READ, self._empty)
        self._fetches: list[Fetch] = []
        self._is_asleep = False

    def add(self, files: Iterable[tuple[Any, Callable[[], object]]], fetch: Fetch) -> None:
        """Wait for these files as well, and call a function whenever they may have something.

        Args:
            files: each with a function to call when a wait ends because of it.
        """
        for file, arrived in files:
            self._selector.register(file, selectors.EVENT_READ, arrived)
        self._fetches.append(fetch)

    def remove(self, files: Iterable[Any], fetch: Fetch) -> None:
        """Wait for these files no more."""
        for file in files:
            self._selector.unregister(file)
        self._fetches.remove(fetch)

    def fetch(self, everything: bool = False) -> None:
        """Read what has arrived; the first message is enough, unless `everything` is wanted."""
        for fetch in self._fetches:
            fetch(everything)

    def sleep(self, seconds: float, has_work: Callable[[], object]) -> None:
        """Wait until something arrives, `wake` is called, or the time is over; at once if there is work already.

        Call `fetch` before and after.
        """
        self._is_asleep = True
        try:
            if not has_work():
                for key, _ in self._selector.select(max(0.0, seconds)):
                    key.data()
        finally:
            self._is_asleep = False

    def _empty(self) -> None:
        with contextlib.suppress(BlockingIOError):
            self._wake.recv(4096)

    def wake(self) -> None:
        """End the sleep of the physics thread. Any thread; call it after there is work."""
        if self._is_asleep:
            with contextlib.suppress(OSError):  # closed, or full of wakes
                self._waker.send(b"x")

    def close(self) -> None:
        """Close everything; sockets that were added stay as they are."""
        self._selector.close()
        self._wake.close()
        self._waker.close()
