"""One queue of the inbox: the messages of a client, the server's own events, or the questions of a kind."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from typing import NamedTuple

from simx_client.protocol.zenoh.keys import VIEWER
from simx_server.service.calls.work import Work

Event = Callable[[], object]


class Arrival(NamedTuple):
    """A message of a client."""

    client: str
    work: Work


class Item(NamedTuple):
    """An entry in a queue."""

    what: Event | Arrival
    virtual: float
    """The virtual time of the service when it arrived."""

    number: int
    arrived: float
    """On the monotonic clock, seconds."""

    waits_for_scripts: bool | None
    """None: it depends on the calls."""

    stops: Callable[[], bool] | None = None
    """Returns whether an event would stop the simulation; None: it would not."""


class Box:
    """One queue: of a client, of the server's own events, or of questions of a kind.

    Threads that put something in hold `lock`. The physics thread takes without it, because the holder may be waiting
    for the interpreter.
    """

    __slots__ = (
        "aftermath", "client", "finish", "is_charged", "is_in_line", "is_kept_back", "is_known", "is_leaving",
        "is_parked", "is_suspended", "items", "lock", "recent", "size_put", "size_taken", "stop", "taking", "tick",
        "waits",
    )  # fmt: skip

    def __init__(self, client: str = "", *, is_charged: bool = True) -> None:
        """Make an empty queue.

        Args:
            is_charged: the time of its service counts, so that it takes turns with others.
        """
        self.client = client
        self.is_charged = is_charged
        self.items: deque[Item] = deque()
        self.lock = threading.RLock()
        """Lock of the threads that put something in; a signal handler may do so while its own thread does."""

        self.taking = threading.Lock()
        """Lock between the physics thread, which takes items, and the thread that refuses overdue calls."""

        self.size_put = 0
        """Bytes that were put in, under the lock, less those that were dropped."""

        self.size_taken = 0
        """Bytes of them that the physics thread took out."""

        self.is_known = False
        """The physics thread has been notified that something waits here."""

        self.is_leaving = False
        """The queue accepts nothing any more: the last item makes the client leave."""

        self.is_suspended = False
        """The queue is not served until its client has read its answers."""

        self.is_kept_back = False
        """The queue is not served until a step of its client's call is done."""

        self.is_parked = False
        """Its turn has come while it was not to be served."""

        # For `fairness.py`, on the physics thread.
        self.is_in_line = False
        """The queue waits for its turn."""

        self.finish = 0.0
        """The virtual time of the service at which this queue has had its share."""

        self.aftermath = 0.0
        """Seconds of service since its client has left."""

        # For `flood.py`, under the lock.
        self.tick = 0
        """The moment of its newest message."""

        self.recent = 0
        """Messages of that moment."""

        # For `must_wait` and `has_stop`, on the physics thread: results of reading items.
        self.waits: tuple[int, bool] | None = None
        """Number of an item, and whether it has to wait for scripts."""

        self.stop: tuple[int, int] = (0, 0)
        """Numbers of the newest item that was examined for a stop, and of the newest that has one."""

    @property
    def is_waiting(self) -> bool:
        """Return whether nothing may be taken out."""
        return self.is_suspended or self.is_kept_back

    @property
    def size(self) -> int:
        """Return the number of waiting bytes."""
        return self.size_put - self.size_taken

    # --- under the lock --------------------------------------------------------------------------

    def forget(self, item: Item) -> None:
        """Subtract the bytes of an item that was removed."""
        if isinstance(item.what, Arrival):
            self.size_put -= item.what.work.size

    def unpark(self) -> bool:
        """Return whether it must be announced, because its turn has come while it was not to be served."""
        if not self.is_parked or self.is_waiting:
            return False
        self.is_parked = False
        return True

    # --- the physics thread ----------------------------------------------------------------------

    def park(self) -> bool:
        """Return whether nothing may be taken out now. The queue stays known; a change announces it again."""
        if self.is_suspended or self.is_kept_back:
            self.is_parked = True
            if self.is_waiting:
                return True
        self.is_parked = False
        return False

    def first(self) -> Item | None:
        """Return the first item; None if there is none."""
        if not self.items:
            return None
        try:
            return self.items[0]
        except IndexError:  # it was taken out just now
            return None

    def pop(self) -> Item | None:
        """Take the first item out; None if there is none, as other threads take some out too."""
        with self.taking:
            try:
                item = self.items.popleft()
            except IndexError:
                return None
        if isinstance(item.what, Arrival):
            self.size_taken += item.what.work.size
        return item

    def must_wait(self) -> bool:
        """Return whether the first item has to wait for scripts."""
        item = self.first()
        if item is None:
            return False
        if item.waits_for_scripts is not None:
            return item.waits_for_scripts
        if self.waits is None or self.waits[0] != item.number:
            assert isinstance(item.what, Arrival)
            self.waits = item.number, item.what.work.waits_for_scripts()
        return self.waits[1]

    def has_stop(self) -> bool:
        """Return whether anything that waits stops the simulation. Each item is examined once."""
        items = self.items.copy()  # at once, as other threads add some meanwhile
        if not items or self.client.startswith(VIEWER):  # a viewer's is refused
            return False
        examined, stop = self.stop
        for item in reversed(items):
            if item.number <= examined:
                break
            if _stops(item):
                stop = max(stop, item.number)
        self.stop = max(examined, items[-1].number), stop
        return any(item.number == stop for item in items)


def _stops(item: Item) -> bool:
    """Return whether an item stops the simulation."""
    if isinstance(item.what, Arrival):
        return item.what.work.stops()
    return item.stops is not None and item.stops()
