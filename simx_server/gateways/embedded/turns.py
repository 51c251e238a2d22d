"""Decide which thread is the physics thread of an embedded server: one after the other, each for one piece of work.

A server in its own process has one thread that alone touches the simulation. Here the thread of each call takes its
turn instead. A pacing thread takes turns too while something happens without a call: simulation steps in real time,
regular work of the scene's scripts, calls of clients that come through a gateway. In stepped mode it sleeps.
"""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Any

from simx_server.service.loop import LOOK, ServerLoop
from simx_server.simulation.interruptions import nothing

GIVE_WAY = 0.01
"""Most seconds that the pacing thread waits for a caller to take its turn."""

_ASLEEP = 3600.0
"""Seconds that the pacing thread waits at most while calls alone change something."""


class Turns:
    """The lock of a world, and its pacing thread."""

    def __init__(self, loop: ServerLoop, *, has_gateways: bool = False) -> None:
        """Make it without a pacing thread; the first need for one starts it.

        Args:
            has_gateways: clients of other processes can come.
        """
        self._loop = loop
        self.lock = threading.RLock()
        """Held during a turn, once by a thread. A caller that acquires it without waiting sets `owner` itself."""

        lock: Any = self.lock
        self.is_held_here: Callable[[], bool] = lock._is_owned
        """Returns whether this thread holds the lock: within its turn, or because Ctrl-C came just before that."""

        self.owner = 0
        """The thread that has the turn, 0 for none."""

        self._callers: deque[None] = deque()
        """An entry for each caller that waits for its turn; a deque counts atomically."""

        self._entered = threading.Event()
        self.has_gateways = has_gateways
        self._thread: threading.Thread | None = None
        self._is_ending = False
        self._next_look = 0.0
        self._take_back: Callable[[], object] | None = None
        """While compiled steps of a crew have the world: brings it up to date for the turn that starts."""

    def begin(self, deadline: float = math.inf) -> bool:
        """Take a turn; return False if the deadline (monotonic clock) passed, or this thread has a turn already.

        The second happens when Python collects garbage, and so closes a client, in the middle of a step.
        """
        if (self.is_held_here() or not self.lock.acquire(blocking=False)) and not self.wait(deadline):
            return False
        self.owner = threading.get_ident()
        if self._take_back is not None:
            self._take_back()
        return True

    def lend(self, take_back: Callable[[], object]) -> None:
        """Let a crew step the world without turns, until one starts: its owner calls `take_back`. Within a turn."""
        self._take_back = take_back

    def returned(self) -> None:
        """Note that the world steps in turns again."""
        self._take_back = None

    def wait(self, deadline: float) -> bool:
        """Acquire the lock when another thread ends its turn; return False as ``begin`` does.

        A thread that holds it without a turn keeps it: Ctrl-C came in between.
        """
        if self.is_held_here():
            return self.owner != threading.get_ident()
        self._callers.append(None)
        try:
            wait = -1.0 if deadline == math.inf else max(0.0, deadline - time.monotonic())
            return self.lock.acquire(timeout=wait)
        finally:
            self._callers.pop()
            self._entered.set()

    def end(self) -> None:
        """End the turn of this thread."""
        self.owner = 0
        self.lock.release()

    def note_change(self) -> None:
        """Start or wake the pacing thread if it is needed now. Call this within a turn that may have changed that."""
        if self.has_gateways or self._loop.advances_alone:
            if self._thread is None:
                self._thread = threading.Thread(target=self._run, name="simx-pacing", daemon=True)
                self._thread.start()
            else:
                self._loop.service.queue.post(nothing)

    def close(self) -> None:
        """Stop the pacing thread."""
        self._is_ending = True
        if self._thread is not None:
            self._loop.service.queue.post(nothing)
            self._thread.join()

    def _run(self) -> None:
        loop = self._loop
        while not self._is_ending:
            self.begin()
            try:
                loop.turn()
                if (now := time.monotonic()) >= self._next_look:
                    self._next_look = now + LOOK
                    loop.look()
                is_needed = self.has_gateways or loop.advances_alone
                seconds = min(1.0, loop.service.due.seconds_until_round()) if is_needed else _ASLEEP
            finally:
                self.end()
            if self._callers:
                # A lock is not fair: without this wait, the pacing thread would take it again at once.
                self._entered.clear()
                if self._callers:
                    self._entered.wait(GIVE_WAY)
            elif seconds > 0.0 and not self._is_ending:
                loop.service.queue.wait_for_work(seconds)
