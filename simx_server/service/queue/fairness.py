"""Decide which queue is served next: clients share the time of the physics thread by the cost of their messages there.

This is start-time fair queueing. A client that uses less than its share is served in the order of arrival, as with one
queue for all; a client that floods the server waits behind its own messages.
"""

from __future__ import annotations

import contextlib
import heapq
import queue
from collections.abc import Callable, Generator
from contextlib import contextmanager

from .box import Box, Item

CREDIT = 0.001
"""Seconds of the physics thread that a client may use at once before it has to take turns. Within this time, calls are
executed in the order of arrival, so that programs with several clients keep the order in which they sent.
"""

AFTERMATH = 5.0
"""Seconds of the physics thread for the remaining messages of clients that have left, shared among them: a flooding
client leaves minutes of work.
"""


class Fairness:
    """The line of the queues that are not empty. Physics thread, except where a method says otherwise.

    No lock guards it: other threads only append to a queue of announcements.
    """

    def __init__(self, count_leaving: Callable[[], int]) -> None:
        """Make it empty.

        Args:
            count_leaving: returns how many clients have left while messages of them wait.
        """
        self._count_leaving = count_leaving
        self.virtual = 0.0
        """The virtual time of the service: the start of the newest item taken, in seconds of each client's share. Any
        thread may read it.
        """

        self._ready: queue.SimpleQueue[Box] = queue.SimpleQueue()
        """Queues that were empty and now are not; a new entry wakes the physics thread up."""

        self._line: list[tuple[float, int, Box]] = []
        """Queues that are not empty, as a heap: by the start of their first item, then by its number."""

        self._serving: Box | None = None
        """The queue of the last item taken, until `served`."""

    def announce(self, box: Box) -> None:
        """Have a queue take its turn: something waits in it now. Any thread."""
        self._ready.put(box)

    def wait(self, seconds: float) -> None:
        """Wait until a queue is announced, or the time is over. Any thread, but one at a time."""
        with contextlib.suppress(queue.Empty):
            self._ready.put(self._ready.get(timeout=seconds))

    def has_more(self) -> bool:
        """Return whether anything waits apart from the last item taken."""
        return bool(self._line) or self._ready.qsize() > 0

    def first(self) -> Box | None:
        """Take the queue with the next turn out of the line; None if the line is empty."""
        if self._serving is not None:
            self.served(0.0)
        while count := self._ready.qsize():
            box = self._ready.get_nowait()
            if count == 1 and not self._line and box.items and not box.park():
                return box  # it is alone
            self.line_up(box)
        if not self._line:
            return None
        box = heapq.heappop(self._line)[2]
        box.is_in_line = False
        return box

    def line_up(self, box: Box) -> None:
        """Put a queue into the line, if it is not empty."""
        if box.is_in_line or box.park():
            return
        while (first := box.first()) is None:
            box.is_known = False
            if not box.items:
                return
            box.is_known = True  # something came just now
        box.is_in_line = True
        heapq.heappush(self._line, (self._start(box, first), first.number, box))

    def took(self, box: Box, item: Item) -> None:
        """Start the service of an item that was taken out of a queue."""
        start = self._start(box, item)
        box.finish = max(box.finish, start)
        self.virtual = max(self.virtual, start)
        if box.is_charged:
            self._serving = box
        # Events and questions are also served while a script runs that one of them has started.
        if not box.client:
            self.line_up(box)

    def served(self, seconds: float) -> None:
        """Record that the last item taken has been served, and how many seconds it kept the thread."""
        box, self._serving = self._serving, None
        if box is not None:
            box.finish += seconds
            if box.is_leaving:
                self._hasten(box, seconds)
            if box.client:
                self.line_up(box)

    @contextmanager
    def inside(self) -> Generator[None]:
        """Serve other items within the service of the last one taken."""
        outer, self._serving = self._serving, None
        try:
            yield
        finally:
            self.served(0.0)
            self._serving = outer

    def _start(self, box: Box, item: Item) -> float:
        """Return the virtual time at which an item is served.

        An item that had to wait, for a script or until its client had read, gets no earlier start for it: otherwise the
        others would wait for everything that has accumulated.
        """
        return max(item.virtual, box.finish - CREDIT, self.virtual - CREDIT)

    def _hasten(self, box: Box, seconds: float) -> None:
        """Remove the remaining messages of a client that has left, if it has had its time."""
        box.aftermath += seconds
        if box.aftermath > AFTERMATH / max(1, self._count_leaving()):
            with box.lock:
                while len(box.items) > 1:
                    box.forget(box.items.popleft())
