"""What has arrived for the physics thread, in order; and which of it may be dealt with while a script runs.

A script that runs long holds the thread. Meanwhile others are answered what only reads, or sets what a script may find
changed between two of its own calls: signals, targets, poses. A batch with anything else, and all later ones of its
client, wait until the script is over.
"""

from __future__ import annotations

import queue
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator
from typing import Any, NamedTuple

from simx_client.protocol.codec import CodecError, decode_batch
from simx_client.protocol.commands import ANSWERED
from simx_client.protocol.messages import Call

Event = Callable[[], object]


class Arrival(NamedTuple):
    """A batch of calls as it came."""

    client: str
    payload: bytes


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
        self._held: deque[Event | Arrival] = deque()
        """What had to wait for a script's end; it comes before all that is in the queue."""

        self._held_of: Counter[str] = Counter()
        """Batches among them, by client."""

        self.dropped: Counter[str] = Counter()
        """Batches that were thrown away, by client; whoever tells of them clears it."""

    def __len__(self) -> int:
        return len(self._held) + self._queue.qsize()

    def read_by(self, kind: type, read: Read) -> None:
        """Things of this kind may be `put` as they came, and are read when it is their turn."""
        self._readers[kind] = read

    def _read(self, item: Any) -> Event | Arrival:
        read = self._readers.get(item.__class__)
        return item if read is None else read(item)

    def hold(self, event: Event | Arrival) -> None:
        """Keep something until no script runs."""
        self._held.append(event)
        if isinstance(event, Arrival):
            self._held_of[event.client] += 1

    def _first_held(self) -> Event | Arrival:
        event = self._held.popleft()
        if isinstance(event, Arrival):
            self._held_of[event.client] -= 1
            if not self._held_of[event.client]:
                del self._held_of[event.client]
        return event

    def _queued(self) -> Iterator[Event | Arrival]:
        """All that nobody has dealt with or held so far; what comes meanwhile is left."""
        for _ in range(self._queue.qsize()):
            yield self._read(self._queue.get_nowait())

    def shed(self, most: int) -> None:
        """Throw away what a client has sent beyond so many batches that wait."""
        if self._queue.qsize() <= most:
            return
        for event in self._queued():
            if isinstance(event, Arrival) and self._held_of[event.client] >= most:
                self.dropped[event.client] += 1
            else:
                self.hold(event)

    def wait(self, seconds: float) -> Event | Arrival | None:
        """The next one, as soon as there is one; None when the time is over."""
        if self._held:
            return self._first_held()
        try:
            return self._read(self._queue.get(timeout=seconds))
        except queue.Empty:
            return None

    def at_hand(self) -> Iterator[Event | Arrival]:
        """All that is there now. What comes while these are dealt with is left for the next time."""
        for _ in range(len(self)):
            if self._held:
                yield self._first_held()
            elif not self._queue.empty():
                yield self._read(self._queue.get_nowait())

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
