"""Sockets that the physics thread uses itself, while it waits for the next thing to do.

A thread of a gateway that reads a socket and wakes the physics thread costs as much as the call itself. Here the
physics thread waits for the sockets, and other threads wake it with a byte.
"""

from __future__ import annotations

import contextlib
import math
import os
import select
import selectors
import socket
import time
from collections.abc import Callable

LOOK = 0.0002
"""Seconds to look before sleeping: twice as long as a client in a loop needs from an answer to its next call."""

LATE = 0.001
"""Seconds between two looks at the sockets from which other programs have had this core meanwhile."""

FEW = 3
"""Sockets of a server with one client: that of `wake`, one that listens, and the client's."""

SHORT = 0.002
"""Seconds below which a wait ends on time by another call of the system: epoll rounds up to milliseconds."""

PAUSE = 1.0
"""Seconds without a look from then on: a thread that looks loses its turn, and one that sleeps is woken early."""

_let_others: Callable[[], object] = getattr(os, "sched_yield", bool)

Ready = Callable[[], object]
"""Reads some of what has arrived at a socket, and queues it; or sends what was left. Does not wait."""


class Sockets:
    """The sockets of one server loop. Physics thread, except `wake`."""

    def __init__(self) -> None:
        self._selector = _Epoll() if hasattr(select, "epoll") else _Selector()
        self._wake, self._waker = socket.socketpair()
        for end in (self._wake, self._waker):
            end.setblocking(False)
        self.add(self._wake, self._empty)
        self._is_asleep = False
        self._look_until = 0.0
        """When a look ends that the next wait shall start with; 0 for none."""

        self._next_look = 0.0 if hasattr(os, "sched_yield") else math.inf

    def add(self, file: socket.socket, ready: Ready) -> None:
        """Call a function whenever a socket has something to read, until it is removed."""
        self._selector.register(file, ready)

    def change(self, file: socket.socket, ready: Ready, *, to_send: bool) -> None:
        """Call a function whenever a socket takes something to send, or whenever it has something to read again."""
        self._selector.modify(file, ready, to_send=to_send)

    def remove(self, file: socket.socket) -> None:
        """Wait for this socket no more; it is still open."""
        self._selector.unregister(file)

    def poll(self, seconds: float = 0.0, has_work: Callable[[], object] = bool) -> None:
        """Wait until a socket is ready, `wake` is called, or the time is over; then serve each socket that is ready.

        Args:
            has_work: whether there is something to do already; then it does not wait. Called after the last moment at
                which another thread need not call `wake`.
        """
        found = self.wait(seconds, has_work)
        for ready in found:
            ready()
        if found and self._selector.count > FEW:
            # The system's list keeps a socket that was served until it is asked again: what comes to that socket later
            # would stand in front of what came to others before.
            for ready in self._selector.select(0.0):
                ready()

    def wait(self, seconds: float, has_work: Callable[[], object]) -> list[Ready]:
        """Wait as ``poll`` does; return the functions of the sockets that are ready until these are called."""
        if seconds <= 0.0:
            return self._selector.select(0.0)
        ready = self._look(seconds, has_work) if self._look_until else None
        if not ready:
            self._is_asleep = True
            try:
                ready = self._selector.select(0.0 if has_work() else seconds)
            finally:
                self._is_asleep = False
        return ready

    def expect(self) -> None:
        """Have the next wait start with a look of `LOOK` seconds: a client has got its answer, and may call at once.

        To fall asleep and be woken up takes longer than most clients need for their next call.
        """
        if (now := time.perf_counter()) >= self._next_look:
            self._look_until = now + LOOK

    def _look(self, seconds: float, has_work: Callable[[], object]) -> list[Ready]:
        """Return the sockets that are ready within the look. Another program that wants this core gets it meanwhile."""
        now = time.perf_counter()
        until, self._look_until = max(now, min(self._look_until, now + seconds)), 0.0
        while not (ready := self._selector.select(0.0)) and not has_work():
            _let_others()
            before, now = now, time.perf_counter()
            if now - before > LATE:
                self._next_look = now + PAUSE
            if now >= until:
                break
        return ready

    def _empty(self) -> None:
        with contextlib.suppress(BlockingIOError):
            self._wake.recv(4096)

    def wake(self) -> None:
        """End the wait of the physics thread. Any thread; call it after there is work."""
        if self._is_asleep:
            with contextlib.suppress(OSError):  # closed, or full of wakes
                self._waker.send(b"x")

    def close(self) -> None:
        """Close everything; sockets that were added stay as they are."""
        self._selector.close()
        self._wake.close()
        self._waker.close()


class _Selector:
    """Waits for sockets on any system."""

    def __init__(self) -> None:
        self._selector = selectors.DefaultSelector()

    @property
    def count(self) -> int:
        return len(self._selector.get_map())

    def register(self, file: socket.socket, ready: Ready) -> None:
        self._selector.register(file, selectors.EVENT_READ, ready)

    def modify(self, file: socket.socket, ready: Ready, *, to_send: bool) -> None:
        self._selector.modify(file, selectors.EVENT_WRITE if to_send else selectors.EVENT_READ, ready)

    def unregister(self, file: socket.socket) -> None:
        self._selector.unregister(file)

    def select(self, seconds: float) -> list[Ready]:
        return [key.data for key, _ in self._selector.select(seconds)]

    def close(self) -> None:
        self._selector.close()


class _Epoll:
    """The same on Linux, without an object for each event, which would cost more than the system's call."""

    def __init__(self) -> None:
        self._epoll = select.epoll()
        self._ready: dict[int, Ready] = {}
        self._can_select = self._epoll.fileno() < _FD_SETSIZE

    @property
    def count(self) -> int:
        return len(self._ready)

    def register(self, file: socket.socket, ready: Ready) -> None:
        self._epoll.register(file, select.EPOLLIN)
        self._ready[file.fileno()] = ready

    def modify(self, file: socket.socket, ready: Ready, *, to_send: bool) -> None:
        self._epoll.modify(file, select.EPOLLOUT if to_send else select.EPOLLIN)
        self._ready[file.fileno()] = ready

    def unregister(self, file: socket.socket) -> None:
        del self._ready[file.fileno()]
        self._epoll.unregister(file)

    def select(self, seconds: float) -> list[Ready]:
        if 0.0 < seconds < SHORT and self._can_select:
            select.select([self._epoll], (), (), seconds)
            seconds = 0.0
        found = self._epoll.poll(seconds)
        return [self._ready[number] for number, _ in found] if found else []

    def close(self) -> None:
        self._epoll.close()


_FD_SETSIZE = 1024
"""File descriptors that ``select`` can wait for are below."""
