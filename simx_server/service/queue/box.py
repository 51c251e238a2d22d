"""One queue of the inbox: the messages of a client, the server's own events, or the questions of a kind."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from typing import NamedTuple

from simx_server.service.calls.demands import Demands, demands_of_batch

Event = Callable[[], object]


class Arrival(NamedTuple):
    """A batch of calls as it came."""

    client: str
    payload: bytes


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
    """One queue: of a client, of the server's own events, or of questions of a kind."""

    __slots__ = (
        "aftermath", "client", "demands", "finish", "is_in_line", "is_kept_back", "is_known", "is_leaving",
        "is_parked", "is_suspended", "items", "lock", "recent", "size_put", "size_taken", "stop", "tick", "waits",
    )  # fmt: skip

    def __init__(self, client: str = "", demands: Callable[[bytes], Demands] = demands_of_batch) -> None:
        self.client = client
        self.demands = demands
        """Reads what a message would do to a script that runs."""

        self.items: deque[Item] = deque()
        self.lock = threading.RLock()
        """Lock of the threads that put something in; a signal handler may do so while its own thread does. The physics
        thread takes without it, because the holder of the lock may be waiting for the interpreter.
        """

        self.size_put = 0
        """Bytes that were put in, under the lock, less those that were dropped."""

        self.size_taken = 0
        """Bytes of them that the physics thread took out."""

        self.is_in_line = False
        """For the physics thread: the queue waits for its turn."""

        self.is_known = False
        """The physics thread has been notified that something waits here."""

        self.is_leaving = False
        """The queue accepts nothing any more: the last item makes the client leave."""

        self.aftermath = 0.0
        """Seconds of service since then."""

        self.is_suspended = False
        """The queue is not served until its client has read its answers."""

        self.is_kept_back = False
        """The queue is not served until a step of its client's call is done."""

        self.is_parked = False
        """Its turn has come while it was not to be served."""

        self.finish = 0.0
        """The virtual time of the service at which this queue has had its share."""

        self.tick = 0
        """The moment of its newest message, as `Inbox.put` counts them."""

        self.recent = 0
        """Messages of that moment."""

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
