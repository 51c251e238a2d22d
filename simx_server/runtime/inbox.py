"""What has arrived for the physics thread: a queue per client, bounded where messages arrive, and served in turn.

Clients share the time of the physics thread by what their messages cost there (start-time fair queueing). Whoever uses
less than its share is served in the order of arrival, as with one queue for all; whoever floods the server waits behind
its own messages. The messages of one client stay in their order.

A script that runs long holds the thread. Meanwhile others are answered what only reads, or sets what a script may find
changed between two of its own calls: signals, targets, poses. A batch with anything else, and all later ones of its
client, wait until the script is over.
"""

from __future__ import annotations

import heapq
import itertools
import math
import queue
import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator
from typing import Any, NamedTuple

from simx_client.protocol.codec import MAX_MESSAGE, CodecError, decode_batch
from simx_client.protocol.commands import ANSWERED
from simx_client.protocol.messages import Call
from simx_server.limits import Limits

from .awaited import divide

Event = Callable[[], object]

CREDIT = 0.001
"""Seconds of the physics thread that a client may use at once before it has to take turns. Within it the order is that
of arrival, so that programs of several clients meet no other order than they sent in."""

MUCH, MUCH_BYTES = 300, 32 << 20
"""Messages and bytes of a client that wait, from which on it should be slowed down. A client of this project has 200
messages on the way at most."""

AFTERMATH = 5.0
"""Seconds of the physics thread for what clients have sent before they left, shared among them: who floods leaves
minutes of work."""

MOMENT = 0.01
"""Seconds over which messages are counted as they arrive: each takes the interpreter from the physics thread."""

BUSY, GREEDY = 150, 25
"""Messages of a moment, counting a large one as several: with so many of all clients, those should be slowed down that
sent so many of them. A program alone makes at most 100 blocking calls in a moment."""

LARGE = 1 << 17
"""Bytes that count as one more message."""

RESERVED = 1 << 20
"""Bytes that every client may have waiting, also while others fill the room that there is for all."""

_MOST_READ = 1 << 18
"""Bytes of batches that `take_overdue` reads at a time, which takes the interpreter from the physics thread."""

_COST = 1000
"""Bytes that a batch counts for beside its own."""

MOST_QUESTIONS = 100
"""Questions of a kind that wait for their answers; whoever asks beyond that gets none, and may ask again."""


class Arrival(NamedTuple):
    """A batch of calls as it came."""

    client: str
    payload: bytes


class _Item(NamedTuple):
    """What waits in a queue."""

    what: Event | Arrival
    virtual: float
    """How far the service had come when it arrived."""

    number: int
    arrived: float
    """On the monotonic clock, seconds."""

    waits_for_scripts: bool | None
    """None: it depends on the calls."""


class Box:
    """One queue: of a client, of the server's own events, or of questions of a kind."""

    __slots__ = (
        "aftermath", "client", "finish", "is_in_line", "is_kept_back", "is_known", "is_leaving", "is_parked",
        "is_suspended",
        "items", "lock", "recent", "size_put", "size_taken", "tick", "waits",
    )  # fmt: skip

    def __init__(self, client: str = "") -> None:
        self.client = client
        self.items: deque[_Item] = deque()
        self.lock = threading.RLock()
        """Of those who put something in; a signal handler may do so while its own thread does. The physics thread takes
        without it: whoever has it may be without the interpreter just then."""

        self.size_put = 0
        """Bytes that were put in, under the lock, and are not forgotten."""

        self.size_taken = 0
        """Bytes of them that the physics thread took out."""

        self.is_in_line = False
        """For the physics thread: it waits for its turn."""

        self.is_known = False
        """The physics thread has been told that something waits here."""

        self.is_leaving = False
        """Nothing is taken any more: the last item has the client leave."""

        self.aftermath = 0.0
        """Seconds that it has had since then."""

        self.is_suspended = False
        """Nothing is taken out, until its client has read its answers."""

        self.is_kept_back = False
        """Nothing is taken out, until a step of its client's call is done."""

        self.is_parked = False
        """Its turn has come while nothing was to be taken out."""

        self.finish = 0.0
        """How far the service will have come when this queue has had its share."""

        self.tick = 0
        """The moment of its newest message, as `Inbox.put` counts them."""

        self.recent = 0
        """Messages of that moment."""

        self.waits: tuple[int, bool] | None = None
        """Number of an item, and whether it has to wait for scripts."""

    @property
    def is_waiting(self) -> bool:
        """Nothing may be taken out."""
        return self.is_suspended or self.is_kept_back

    @property
    def size(self) -> int:
        """Bytes that wait."""
        return self.size_put - self.size_taken


class Inbox:
    """Events and batches. Any thread may put them in; the physics thread takes them out."""

    def __init__(self, limits: Callable[[], Limits] = Limits) -> None:
        """Begin empty.

        Args:
            limits: the limits that hold now.
        """
        self._limits = limits
        self._lock = threading.Lock()
        """Of the clients that are known, and of what was dropped."""

        self._taking = threading.Lock()
        """Between the physics thread and `take_overdue`."""

        self._boxes: dict[str, Box] = {}
        self._events = Box()
        self._questions: dict[str, Box] = {}
        self._ready: queue.SimpleQueue[Box] = queue.SimpleQueue()
        """Queues in which something waits now and nothing did before; it wakes the physics thread up."""

        self._numbers = itertools.count(1)
        self._virtual = 0.0
        """How far the service has come: the start of the newest item taken, in seconds of everybody's share."""

        self._turns: list[tuple[float, int, Box]] = []
        """Queues in which something waits, as a heap: by the start of their first item, then by its number."""

        self._serving: Box | None = None
        """The queue of what was taken last, until `served`."""

        self._held: deque[Event] = deque()
        """Events that had to wait for a script's end; they come before all else."""

        self._tick = 0
        """The moment of the newest message."""

        self._recent = 0
        """Messages of that moment, of all clients."""

        self.had_much = False
        """Many bytes of a client have waited; whoever gives their memory back clears it."""

        self.dropped: Counter[tuple[str, str]] = Counter()
        """Messages that were thrown away, by client and limit; whoever tells of them takes them by `take_dropped`."""

    def __len__(self) -> int:
        """How much waits."""
        boxes = [self._events, *self._questions.copy().values(), *self._boxes.copy().values()]
        return len(self._held) + sum(len(box.items) for box in boxes)

    # --- any thread ------------------------------------------------------------------------------

    def open(self, client: str) -> None:
        """Take messages of a client from now on; those of others are thrown away."""
        with self._lock:
            if client not in self._boxes:
                self._boxes[client] = Box(client)

    def close(self, client: str) -> None:
        """Take no messages of a client any more, and throw away those that wait."""
        with self._lock:
            if (box := self._boxes.pop(client, None)) is not None:
                box.is_leaving = True
                box.items.clear()

    def put(self, client: str, payload: Any, size: int, read: Callable[[Any], bytes] = bytes) -> bool:
        """Have a batch executed, if its client is known and has not too much waiting.

        Args:
            payload: what arrived.
            size: its bytes.
            read: makes bytes of it; called only if there is room.

        Returns:
            Whether the client may go on like this. If not, slow it down; the message may be taken all the same.
        """
        box = self._boxes.get(client)
        if box is None:
            return False
        with box.lock:
            if box.is_leaving:
                return False
            if reached := self._limit_reached(box, size):
                with self._lock:
                    self.dropped[client, reached] += 1
                return False
            box.size_put += size
            if box.size > RESERVED:
                self.had_much = True
            is_flood = self._is_flood(box, size)
            # Last, as it wakes the physics thread up, which needs the interpreter.
            self._add(box, Arrival(client, read(payload)), None)
            return not is_flood

    def _is_flood(self, box: Box, size: int) -> bool:
        """Whether a client should be slowed down that sends one more message, whose bytes are counted already."""
        tick, weight = int(time.monotonic() / MOMENT), 1 + size // LARGE
        if tick != self._tick:
            self._tick, self._recent = tick, 0
        if tick != box.tick:
            box.tick, box.recent = tick, 0
        self._recent += weight
        box.recent += weight
        if self._recent > BUSY and box.recent > GREEDY:
            return True
        return len(box.items) >= MUCH or box.size > MUCH_BYTES

    def _limit_reached(self, box: Box, size: int) -> str:
        """The limit that one more message would go beyond; empty if there is room for it."""
        limits, of_client = self._limits(), box.size + size
        if size > MAX_MESSAGE:
            return "message"
        if len(box.items) >= limits.waiting:
            return "waiting"
        if box.size and of_client > limits.waiting_bytes:
            return "waiting_bytes"
        if of_client > RESERVED and self.size + size > limits.all_waiting_bytes:
            return "all_waiting_bytes"
        return ""

    def _add(self, box: Box, what: Event | Arrival, waits_for_scripts: bool | None) -> None:
        box.items.append(_Item(what, self._virtual, next(self._numbers), time.monotonic(), waits_for_scripts))
        self._announce(box)

    def _announce(self, box: Box) -> None:
        if not box.is_known:
            box.is_known = True
            self._ready.put(box)

    def post(self, event: Event) -> None:
        """Have an event of the server's own dealt with; there is always room for it."""
        with self._events.lock:
            self._add(self._events, event, False)

    def ask(self, kind: str, question: Event) -> int:
        """Have a question dealt with; return how many of this kind wait now, 0 if too many did already."""
        box = self._questions.get(kind) or self._questions.setdefault(kind, Box())
        with box.lock:
            if len(box.items) >= MOST_QUESTIONS:
                return 0
            self._add(box, question, False)
            return len(box.items)

    def leave(self, client: str, leaving: Event) -> None:
        """Have an event dealt with behind what a client has sent last; nothing of it is taken any more."""
        if (box := self._boxes.get(client)) is None:
            return
        with box.lock:
            if not box.is_leaving:
                while len(box.items) > MUCH:
                    self._forget(box, box.items.pop())
                self._add(box, leaving, False)
                box.is_leaving, box.is_suspended = True, False
                self._unpark(box)

    def suspend(self, kind: str, is_behind: bool) -> None:
        """Serve a client, or questions of a kind, not before it is suspended no more."""
        box = self._boxes.get(kind) or self._questions.get(kind)
        if box is None:
            return
        with box.lock:
            if not box.is_leaving:
                box.is_suspended = is_behind
                if not is_behind:
                    self._unpark(box)

    def keep_back(self, client: str, is_kept: bool) -> None:
        """Serve a client, also one that is leaving, not before a step of its call is done, see `background.py`."""
        box = self._boxes.get(client)
        if box is None:
            return
        with box.lock:
            box.is_kept_back = is_kept
            if not is_kept:
                self._unpark(box)

    def _unpark(self, box: Box) -> None:
        if box.is_parked and not box.is_waiting:
            box.is_parked = False
            self._ready.put(box)

    def _forget(self, box: Box, item: _Item) -> None:
        """An item was taken out of a queue, by somebody who has its lock."""
        if isinstance(item.what, Arrival):
            box.size_put -= len(item.what.payload)

    def is_leaving(self, client: str) -> bool:
        """Whether a client is about to leave."""
        box = self._boxes.get(client)
        return box is not None and box.is_leaving

    def put_first(self, client: str, event: Event) -> None:
        """Have an event dealt with when it is this client's turn again, in front of its messages, and after scripts."""
        if (box := self._boxes.get(client)) is None:
            return
        with box.lock:
            box.items.appendleft(_Item(event, self._virtual, next(self._numbers), time.monotonic(), True))
            self._announce(box)

    def take_overdue(
        self,
        older_than: float,
        except_client: str | None = None,
        is_still_busy: Callable[[], bool] = lambda: True,
    ) -> Iterator[Arrival]:
        """Take the blocking calls of batches that have waited for long, one by one; they will not be executed.

        What else is in these batches stays, in its place. For another thread, while the physics thread is busy.

        Args:
            older_than: seconds since they arrived.
            except_client: a client whose calls stay.
            is_still_busy: whether the physics thread does what it did; else nothing is taken.
        """
        before, left_to_read = time.monotonic() - older_than, _MOST_READ
        # Whoever has little waiting comes first: the batches of those that flood take long to read.
        boxes = sorted(self._boxes.copy().items(), key=lambda each: each[1].size_put - each[1].size_taken)
        for client, box in boxes:
            if client == except_client or box.is_leaving or box.is_waiting:
                continue
            for item in box.items.copy():  # at once, as the physics thread takes some out meanwhile
                if item.arrived > before:
                    continue
                if left_to_read < 0:
                    return
                batch = item.what
                if isinstance(batch, Arrival):
                    left_to_read -= len(batch.payload) + _COST
                    awaited, rest = divide(batch.payload)
                    with self._taking, box.lock:
                        if not is_still_busy():
                            return
                        is_taken = self._replace(box, item, batch, rest)
                    if is_taken and awaited is not None:
                        yield Arrival(client, awaited)

    def _replace(self, box: Box, item: _Item, batch: Arrival, rest: bytes | None) -> bool:
        """Leave of a batch only the rest, which nobody waits for, and which is not looked at again.

        Returns False if it is not there any more.
        """
        try:
            if rest is None:
                box.items.remove(item)
            else:
                kept = item._replace(what=Arrival(batch.client, rest), arrived=math.inf)
                box.items[box.items.index(item)] = kept
        except (ValueError, IndexError):
            return False
        box.size_put -= len(batch.payload) - len(rest or b"")
        return True

    def take_dropped(self) -> Counter[tuple[str, str]]:
        """How many messages of which client were thrown away since the last time, and for which limit."""
        with self._lock:
            dropped, self.dropped = self.dropped, Counter()
        return dropped

    @property
    def size(self) -> int:
        """Bytes that wait, of all clients."""
        return sum(box.size for box in self._boxes.copy().values())

    # --- the physics thread ----------------------------------------------------------------------

    def hold(self, event: Event) -> None:
        """Keep an event until no script runs."""
        self._held.append(event)

    def served(self, seconds: float) -> None:
        """What was taken last is dealt with, and has kept the thread for so long."""
        box, self._serving = self._serving, None
        if box is not None:
            box.finish += seconds
            if box.is_leaving:
                self._hasten(box, seconds)
            if box.client:
                self._line_up(box)

    def _hasten(self, box: Box, seconds: float) -> None:
        """Have a client that has left be gone now, if it has had its time."""
        box.aftermath += seconds
        sharing = sum(each.is_leaving for each in self._boxes.copy().values())
        if box.aftermath > AFTERMATH / max(1, sharing):
            with box.lock:
                while len(box.items) > 1:
                    self._forget(box, box.items.popleft())

    def others_wait(self) -> bool:
        """Whether anything waits but what was taken last."""
        return bool(self._turns) or self._ready.qsize() > 0

    def wait(self, seconds: float) -> Event | Arrival | None:
        """The next one, as soon as there is one; None when the time is over."""
        taken = self._next()
        if taken is None:
            try:
                box = self._ready.get(timeout=seconds)
            except queue.Empty:
                return None
            self._line_up(box)
            taken = self._next()
        return taken

    def at_hand(self, seconds: float = float("inf")) -> Iterator[Event | Arrival]:
        """All that is there now, at most for so long. What comes meanwhile is left for the next time."""
        until = time.perf_counter() + seconds
        for _ in range(len(self)):
            if (taken := self._next()) is None:
                return
            yield taken
            if time.perf_counter() >= until:
                return

    def meanwhile(
        self,
        executing: str,
        waits: Callable[[str], bool] = lambda _: False,
        seconds: float = float("inf"),
    ) -> Iterator[Event | Arrival]:
        """What is there now and may be dealt with while a script runs, at most for so long; the rest stays.

        Args:
            executing: the client whose batch runs the script; its other batches come after that one.
            waits: whether anything of this client has to wait.
        """
        until = time.perf_counter() + seconds
        outer, self._serving = self._serving, None
        staying: list[Box] = []
        try:
            for _ in range(len(self)):
                box = self._first()
                if box is None or time.perf_counter() >= until:
                    if box is not None:
                        staying.append(box)
                    return
                is_to_stay = box.client and (box.client == executing or waits(box.client))
                if is_to_stay or self._must_wait(box):
                    staying.append(box)
                elif (taken := self._take(box)) is not None:
                    yield taken
        finally:
            self.served(0.0)
            self._serving = outer
            for box in staying:
                self._line_up(box)

    def _next(self) -> Event | Arrival | None:
        """The next one, if there is one."""
        self.served(0.0)  # unless it was said already
        if self._held:
            return self._held.popleft()
        while (box := self._first()) is not None:
            if (taken := self._take(box)) is not None:
                return taken
        return None

    def _first(self) -> Box | None:
        """Whose turn it is; it is in the line no more."""
        if self._serving is not None:
            self.served(0.0)
        while self._ready.qsize():
            self._line_up(self._ready.get_nowait())
        if not self._turns:
            return None
        box = heapq.heappop(self._turns)[2]
        box.is_in_line = False
        return box

    def _line_up(self, box: Box) -> None:
        """Have a queue wait for its turn, if anything waits in it."""
        if box.is_in_line or self._is_parked(box):
            return
        while True:
            try:
                first = box.items[0]
                break
            except IndexError:
                box.is_known = False
                if not box.items:
                    return
                box.is_known = True  # something came just now
        box.is_in_line = True
        heapq.heappush(self._turns, (self._start(box, first), first.number, box))

    def _start(self, box: Box, item: _Item) -> float:
        """How far the service has to come before it is an item's turn.

        One that had to wait, for a script or until its client had read, has no more of a right to be served for it:
        others would wait for all that has come together.
        """
        return max(item.virtual, box.finish - CREDIT, self._virtual - CREDIT)

    def _is_parked(self, box: Box) -> bool:
        """Whether nothing may be taken out now. It stays known, and is announced again when something may be."""
        if box.is_waiting:
            box.is_parked = True
            if box.is_waiting:
                return True
        box.is_parked = False
        return False

    def _take(self, box: Box) -> Event | Arrival | None:
        if self._is_parked(box):
            return None
        with self._taking:
            try:
                item = box.items.popleft()
            except IndexError:  # they were taken out meanwhile
                item = None
        if item is None:
            self._line_up(box)
            return None
        if isinstance(item.what, Arrival):
            box.size_taken += len(item.what.payload)
        start = self._start(box, item)
        box.finish = max(box.finish, start)
        self._virtual = max(self._virtual, start)
        if box is not self._events:
            self._serving = box
        if (
            not box.client
        ):  # events and questions are dealt with also while a script runs that one of them has started
            self._line_up(box)
        return item.what

    def _must_wait(self, box: Box) -> bool:
        """Whether the first item of a queue has to wait for scripts."""
        try:
            item = box.items[0]
        except IndexError:
            return False
        if item.waits_for_scripts is not None:
            return item.waits_for_scripts
        if box.waits is None or box.waits[0] != item.number:
            assert isinstance(item.what, Arrival)
            box.waits = item.number, _interferes(item.what.payload)
        return box.waits[1]


def _interferes(payload: bytes) -> bool:
    try:
        return interfere(decode_batch(payload).calls)
    except CodecError:
        return False


def interfere(calls: Iterable[Call]) -> bool:
    """Whether any of these must not be executed while a script runs."""
    commands = (ANSWERED.get(call.command) for call in calls)
    return any(command is not None and command.waits_for_scripts for command in commands)
