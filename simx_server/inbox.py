"""What has arrived for the physics thread, in order; and which of it may be dealt with while a script runs.

A script that runs long holds the thread. Meanwhile others are answered what only reads, or sets what a script may find
changed between two of its own calls: signals, targets, poses. A batch with anything else, and all later ones of its
client, wait until the script is over.
"""

from __future__ import annotations

import math
import queue
import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator
from typing import Any, NamedTuple

from simx_client.protocol.codec import CodecError, decode_batch
from simx_client.protocol.commands import ANSWERED
from simx_client.protocol.messages import Call

from .awaited import divide

Event = Callable[[], object]


class Arrival(NamedTuple):
    """A batch of calls as it came."""

    client: str
    payload: bytes


class _Waiting(NamedTuple):
    since: float
    """On the monotonic clock."""

    event: Event | Arrival


_MOST_READ = 4 << 20
"""Bytes of batches that `take_overdue` reads at a time; the physics thread may wait for it."""

_COST = 1000
"""Bytes that a batch counts for beside its own."""

Read = Callable[[Any], Arrival]
"""Makes a batch of what a gateway was handed."""


class Inbox:
    """Events and batches. Anyone may `put`; the rest is the physics thread's."""

    def __init__(self) -> None:
        self._queue: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self.put: Callable[[Any], None] = self._queue.put
        """The queue's own, without a detour through Python: a thread of Zenoh's needs the interpreter's lock for
        no longer than that, and the physics thread wakes up meanwhile."""

        self._readers: dict[type, Read] = {}
        self._held: deque[_Waiting] = deque()
        """What had to wait for a script's end; it comes before all that was seen or is in the queue."""

        self._seen: deque[_Waiting] = deque()
        """What `take_overdue` has seen in the queue; it comes before all that is still in it."""

        self._lock = threading.Lock()
        """Between the physics thread and `take_overdue`."""

        self._held_of: Counter[str] = Counter()
        """Batches among them, by client."""

        self.dropped: Counter[str] = Counter()
        """Batches that were thrown away, by client; whoever tells of them clears it."""

    def __len__(self) -> int:
        return len(self._held) + self._unheld()

    def _unheld(self) -> int:
        return len(self._seen) + self._queue.qsize()

    def read_by(self, kind: type, read: Read) -> None:
        """Things of this kind may be `put` as they came, and are read when it is their turn."""
        self._readers[kind] = read

    def _read(self, item: Any) -> Event | Arrival:
        read = self._readers.get(item.__class__)
        return item if read is None else read(item)

    def hold(self, event: Event | Arrival) -> None:
        """Keep something until no script runs."""
        with self._lock:
            self._held.append(_Waiting(time.monotonic(), event))
            if isinstance(event, Arrival):
                self._held_of[event.client] += 1

    def _first_held(self) -> Event | Arrival:
        event = self._held.popleft().event
        self._let_go(event)
        return event

    def _let_go(self, event: Event | Arrival) -> None:
        if isinstance(event, Arrival):
            self._held_of[event.client] -= 1
            if not self._held_of[event.client]:
                del self._held_of[event.client]

    def _first_of_queue(self) -> Event | Arrival:
        """Raises queue.Empty."""
        return self._seen.popleft().event if self._seen else self._read(self._queue.get_nowait())

    def _queued(self) -> Iterator[Event | Arrival]:
        """All that nobody has dealt with or held so far; what comes meanwhile is left."""
        for _ in range(self._unheld()):
            try:
                with self._lock:
                    event = self._first_of_queue()
            except queue.Empty:  # it was refused
                return
            yield event

    def shed(self, most: int) -> None:
        """Throw away what a client has sent beyond so many batches that wait."""
        if self._unheld() <= most:
            return
        for event in self._queued():
            if isinstance(event, Arrival) and self._held_of[event.client] >= most:
                self.dropped[event.client] += 1
            else:
                self.hold(event)

    def wait(self, seconds: float) -> Event | Arrival | None:
        """The next one, as soon as there is one; None when the time is over."""
        with self._lock:
            if self._held:
                return self._first_held()
            if self._seen:
                return self._first_of_queue()
        try:
            return self._read(self._queue.get(timeout=seconds))
        except queue.Empty:
            return None

    def at_hand(self) -> Iterator[Event | Arrival]:
        """All that is there now. What comes while these are dealt with is left for the next time."""
        for _ in range(len(self)):
            try:
                with self._lock:
                    event = self._first_held() if self._held else self._first_of_queue()
            except queue.Empty:  # it was refused
                return
            yield event

    def take_overdue(
        self, older_than: float, except_client: str, is_still_busy: Callable[[], bool]
    ) -> list[Arrival]:
        """Take the blocking calls of batches that have waited for so many seconds; they will not be executed.

        What else is in these batches stays, in its place. For another thread, while the physics thread is busy.

        Args:
            except_client: whose calls stay.
            is_still_busy: whether the physics thread does what it did; else nothing is taken.
        """
        taken: list[Arrival] = []
        with self._lock:
            if not is_still_busy():
                return taken
            now, left_to_read = time.monotonic(), _MOST_READ
            for _ in range(self._queue.qsize()):
                self._seen.append(_Waiting(now, self._read(self._queue.get_nowait())))
            for waiting in (self._held, self._seen):
                for _ in range(len(waiting)):
                    one = waiting.popleft()
                    event = one.event
                    if (
                        left_to_read > 0
                        and now - one.since >= older_than
                        and isinstance(event, Arrival)
                        and event.client != except_client
                    ):
                        left_to_read -= len(event.payload) + _COST
                        awaited, left = divide(event.payload)
                        if awaited is not None:
                            taken.append(Arrival(event.client, awaited))
                        if left is None:
                            if waiting is self._held:
                                self._let_go(event)
                            continue
                        one = _Waiting(math.inf, Arrival(event.client, left))  # nobody waits for what is left
                    waiting.append(one)
        return taken

    def meanwhile(self, executing: str, most: int) -> Iterator[Event | Arrival]:
        """What is there now and may be dealt with while a script runs; the rest is held.

        Args:
            executing: the client whose batch runs the script; its other batches come after that one.
            most: batches of a client that are held or dealt with; what it has sent beyond them is thrown away.
        """
        taken = self._held_of.copy()
        for event in self._queued():
            if not isinstance(event, Arrival):
                yield event
                continue
            taken[event.client] += 1
            if taken[event.client] > most:
                self.dropped[event.client] += 1
            elif self._must_wait(event, executing):
                self.hold(event)
            else:
                yield event

    def _must_wait(self, arrival: Arrival, executing: str) -> bool:
        if arrival.client == executing or arrival.client in self._held_of:
            return True
        try:
            calls = decode_batch(arrival.payload).calls
        except CodecError:
            return False
        return interfere(calls)


def interfere(calls: Iterable[Call]) -> bool:
    """Whether any of these must not be executed while a script runs."""
    commands = (ANSWERED.get(call.command) for call in calls)
    return any(command is not None and command.waits_for_scripts for command in commands)
