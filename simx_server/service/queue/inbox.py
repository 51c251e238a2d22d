"""Queue what arrives for the physics thread: a bounded queue per client, served fairly.

Clients share the time of the physics thread by the cost of their messages there (start-time fair queueing). A client
that uses less than its share is served in the order of arrival, as with one queue for all; a client that floods the
server waits behind its own messages. The messages of one client stay in order.

A long-running script holds the thread. Meanwhile the server executes calls of others that only read, or that set what a
script may find changed between two of its calls: signals, targets, poses. A batch with anything else, and all later
batches of its client, wait until the script is over.
"""

from __future__ import annotations

import contextlib
import heapq
import itertools
import math
import queue
import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Iterator
from typing import Any

from simx_client.protocol.codec import MAX_BATCH
from simx_client.protocol.zenoh.keys import VIEWER
from simx_server.limits import Limits
from simx_server.service.calls.work import BatchWork, CallsWork, Work

from .box import Arrival, Box, Event, Item
from .sockets import Sockets

CREDIT = 0.001
"""Seconds of the physics thread that a client may use at once before it has to take turns. Within this time, calls are
executed in the order of arrival, so that programs with several clients keep the order in which they sent.
"""

MUCH, MUCH_BYTES = 300, 32 << 20
"""Waiting messages and bytes of a client above which it should be slowed down. A client of this project has at most 200
messages on the way.
"""

AFTERMATH = 5.0
"""Seconds of the physics thread for the remaining messages of clients that have left, shared among them: a flooding
client leaves minutes of work.
"""

MOMENT = 0.01
"""Seconds over which arriving messages are counted: each takes the interpreter from the physics thread."""

BUSY, GREEDY = 150, 25
"""Messages in a moment, where a large one counts as several: above the first number for all clients together, each
client above the second should be slowed down. One program makes at most 100 blocking calls in a moment.
"""

LARGE = 1 << 17
"""Bytes that count as one more message."""

RESERVED = 1 << 20
"""Waiting bytes that every client may have, even when others fill the space for all."""

_MOST_READ = 1 << 18
"""Bytes of batches that `take_overdue` reads at a time, because reading takes the interpreter from the physics thread.
"""

_COST = 1000
"""Bytes that a batch counts in addition to its own."""

MOST_QUESTIONS = 100
"""Waiting questions of one kind; further ones get no answer, and their senders may ask again."""


class Inbox:
    """Events and batches. Any thread may put them in; the physics thread takes them out."""

    def __init__(self, limits: Callable[[], Limits] = Limits) -> None:
        """Make an empty inbox.

        Args:
            limits: returns the present limits.
        """
        self._limits = limits
        self._lock = threading.Lock()
        """Lock of the known clients, and of the dropped messages."""

        self._taking = threading.Lock()
        """Lock between the physics thread and `take_overdue`."""

        self._boxes: dict[str, Box] = {}
        self._events = Box()
        self._questions: dict[str, Box] = {}
        self._ready: queue.SimpleQueue[Box] = queue.SimpleQueue()
        """Queues that were empty and now are not; a new entry wakes the physics thread up."""

        self.sockets: Sockets | None = None
        """Those that the physics thread reads; None: it waits for other threads only."""

        self._is_waiting = False
        """The physics thread waits for an item, which `hand_over` can give it."""

        self._numbers = itertools.count(1)
        self._virtual = 0.0
        """The virtual time of the service: the start of the newest item taken, in seconds of each client's share."""

        self._turns: list[tuple[float, int, Box]] = []
        """Queues that are not empty, as a heap: by the start of their first item, then by its number."""

        self._serving: Box | None = None
        """The queue of the last item taken, until `served`."""

        self._held: deque[Event | Arrival] = deque()
        """Events that had to wait for a script's end, or a batch that was handed over; they come before all others."""

        self._tick = 0
        """The moment of the newest message."""

        self._recent = 0
        """Messages of that moment, of all clients."""

        self.has_stop_waiting = False
        """A client waited for a stop of the simulation when items were last served during a script."""

        self.had_much = False
        """Many bytes of a client have waited; the code that returns their memory to the system clears it."""

        self.dropped: Counter[tuple[str, str]] = Counter()
        """Messages that were thrown away, by client and limit; the code that reports them takes them with
        `take_dropped`.
        """

    def __len__(self) -> int:
        """Return the number of waiting items."""
        boxes = [self._events, *self._questions.copy().values(), *self._boxes.copy().values()]
        return len(self._held) + sum(len(box.items) for box in boxes)

    # --- any thread ------------------------------------------------------------------------------

    def open(self, client: str) -> None:
        """Accept messages of a client from now on; those of unknown clients are thrown away."""
        with self._lock:
            if client not in self._boxes:
                self._boxes[client] = Box(client)

    def close(self, client: str) -> None:
        """Accept no more messages of a client, and throw away those that wait."""
        with self._lock:
            if (box := self._boxes.pop(client, None)) is not None:
                box.is_leaving = True
                box.items.clear()

    def submit(self, client: str, work: Work) -> bool:
        """Queue work as `put` does."""
        return self.put(client, work, work.size, _unchanged)

    def put(self, client: str, payload: Any, size: int, read: Callable[[Any], Work] = BatchWork) -> bool:
        """Queue a message, if its client is known and has not too much waiting.

        Args:
            payload: the message as it arrived.
            size: its bytes.
            read: makes work of it; called only if there is space for it.

        Returns:
            Whether the client may continue at this rate. If not, slow it down; the message may be accepted even so.
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
            waiting = box.size
            if waiting > RESERVED:
                self.had_much = True
            is_flood = self._is_flood(box, size, waiting)
            # Last, as it wakes the physics thread up, which needs the interpreter.
            self._add(box, Arrival(client, read(payload)), None)
            return not is_flood

    def _is_flood(self, box: Box, size: int, waiting: int) -> bool:
        """Return whether a client that sends one more message should be slowed down.

        Args:
            size: the bytes of the message.
            waiting: those of all its messages, with this one.
        """
        tick, weight = int(time.monotonic() / MOMENT), 1 + size // LARGE
        if tick != self._tick:
            self._tick, self._recent = tick, 0
        if tick != box.tick:
            box.tick, box.recent = tick, 0
        self._recent += weight
        box.recent += weight
        if self._recent > BUSY and box.recent > GREEDY:
            return True
        return len(box.items) >= MUCH or waiting > MUCH_BYTES

    def _limit_reached(self, box: Box, size: int) -> str:
        """Return the limit that one more message would exceed; empty if there is space for it."""
        limits, waiting = self._limits(), box.size
        of_client = waiting + size
        if size > MAX_BATCH:
            return "message"
        if len(box.items) >= limits.waiting:
            return "waiting"
        if waiting and of_client > limits.waiting_bytes:
            return "waiting_bytes"
        if of_client > RESERVED and self.size + size > limits.all_waiting_bytes:
            return "all_waiting_bytes"
        return ""

    def limit_reached(self, client: str, size: int) -> str:
        """Return the limit that one more message of a client would exceed; empty if there is space for it."""
        box = self._boxes.get(client)
        if box is None:
            return ""
        with box.lock:
            return self._limit_reached(box, size)

    def _add(
        self,
        box: Box,
        what: Event | Arrival,
        waits_for_scripts: bool | None,
        stops: Callable[[], bool] | None = None,
    ) -> None:
        number, now = next(self._numbers), time.monotonic()
        box.items.append(Item(what, self._virtual, number, now, waits_for_scripts, stops))
        self._announce(box)

    def _announce(self, box: Box) -> None:
        if not box.is_known:
            box.is_known = True
            self._tell(box)

    def post(self, event: Event) -> None:
        """Queue an event of the server; there is always space for it."""
        with self._events.lock:
            self._add(self._events, event, False)

    def ask(self, kind: str, question: Event) -> int:
        """Queue a question; return how many of this kind wait now, 0 if too many did already."""
        box = self._questions.get(kind) or self._questions.setdefault(kind, Box())
        with box.lock:
            if len(box.items) >= MOST_QUESTIONS:
                return 0
            self._add(box, question, False)
            return max(1, len(box.items))  # the physics thread may have taken it already

    def leave(self, client: str, leaving: Event) -> None:
        """Queue an event behind the last message of a client, and accept no more messages of it."""
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
        """Suspend a client, or questions of a kind, or resume them."""
        box = self._boxes.get(kind) or self._questions.get(kind)
        if box is None:
            return
        with box.lock:
            if not box.is_leaving:
                box.is_suspended = is_behind
                if not is_behind:
                    self._unpark(box)

    def keep_back(self, client: str, is_kept: bool) -> None:
        """Hold back a client, even one that is leaving, until a step of its call is done; see `background.py`."""
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
            self._tell(box)

    def _tell(self, box: Box) -> None:
        """Tell the physics thread that something waits in a queue."""
        self._ready.put(box)
        if self.sockets is not None:
            self.sockets.wake()

    def _forget(self, box: Box, item: Item) -> None:
        """Subtract the bytes of an item that was removed from a queue, under its lock."""
        if isinstance(item.what, Arrival):
            box.size_put -= item.what.work.size

    def is_leaving(self, client: str) -> bool:
        """Return whether a client is about to leave."""
        box = self._boxes.get(client)
        return box is not None and box.is_leaving

    def has_much(self, client: str) -> bool:
        """Return whether so much of a client waits that it should be slowed down."""
        box = self._boxes.get(client)
        return box is not None and (len(box.items) >= MUCH or box.size > MUCH_BYTES)

    def put_last(
        self,
        client: str,
        event: Event,
        *,
        waits_for_scripts: bool = False,
        stops: Callable[[], bool] | None = None,
    ) -> None:
        """Queue an event behind the messages of a client; it is served while a script runs, as soon as they are.

        Args:
            waits_for_scripts: it is served after scripts.
            stops: returns whether it would stop the simulation; None: it would not. Physics thread.
        """
        box = self._boxes.get(client)
        if box is None:
            return
        with box.lock:
            if not box.is_leaving:
                self._add(box, event, waits_for_scripts, stops)

    def put_first(self, client: str, event: Event) -> None:
        """Queue an event for the client's next turn, in front of its messages, and after scripts."""
        if (box := self._boxes.get(client)) is None:
            return
        with box.lock:
            box.items.appendleft(Item(event, self._virtual, next(self._numbers), time.monotonic(), True))
            self._announce(box)

    def take_overdue(
        self,
        older_than: float,
        except_client: str | None = None,
        is_still_busy: Callable[[], bool] = lambda: True,
    ) -> Iterator[tuple[str, CallsWork]]:
        """Take the blocking calls of batches that have waited for long, one by one; they will not be executed.

        The other calls of these batches stay in their place. For another thread, while the physics thread is busy.

        Args:
            older_than: seconds since they arrived.
            except_client: a client whose calls stay.
            is_still_busy: whether the physics thread still does the same work; otherwise nothing is taken.
        """
        before, left_to_read = time.monotonic() - older_than, _MOST_READ
        # Clients with little waiting come first, because the batches of flooding clients take long to read.
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
                    left_to_read -= batch.work.size + _COST
                    awaited, rest = batch.work.divide()
                    with self._taking, box.lock:
                        if not is_still_busy():
                            return
                        is_taken = self._replace(box, item, batch, rest)
                    if is_taken and awaited is not None:
                        yield client, awaited

    def _replace(self, box: Box, item: Item, batch: Arrival, rest: Work | None) -> bool:
        """Replace a batch by the calls that no client waits for, which are not checked again.

        Returns False if the batch is not there any more.
        """
        try:
            if rest is None:
                box.items.remove(item)
            else:
                kept = item._replace(what=Arrival(batch.client, rest), arrived=math.inf)
                box.items[box.items.index(item)] = kept
        except (ValueError, IndexError):
            return False
        box.size_put -= batch.work.size - (rest.size if rest is not None else 0)
        return True

    def take_had_much(self) -> bool:
        """Return whether many bytes of a client have waited since the last call."""
        had_much, self.had_much = self.had_much, False
        return had_much

    def take_dropped(self) -> Counter[tuple[str, str]]:
        """Return how many messages of each client were thrown away since the last call, and for which limit."""
        with self._lock:
            dropped, self.dropped = self.dropped, Counter()
        return dropped

    @property
    def size(self) -> int:
        """Return the waiting bytes of all clients."""
        return sum(box.size for box in self._boxes.copy().values())

    # --- the physics thread ----------------------------------------------------------------------

    def open_sockets(self) -> Sockets:
        """Return the sockets that the physics thread reads; made on first use. Physics thread, or before it runs."""
        if self.sockets is None:
            self.sockets = Sockets()
        return self.sockets

    def close_sockets(self) -> None:
        """Read no sockets any more, after the gateways that have them are closed."""
        sockets, self.sockets = self.sockets, None
        if sockets is not None:
            sockets.close()

    def hold(self, event: Event) -> None:
        """Keep an event until no script runs."""
        self._held.append(event)

    def hand_over(self, client: str, work: Work) -> bool:
        """Give the waiting physics thread a message that it has just read itself, without a queue.

        Returns:
            False if that is not possible: something else waits, or nothing of the client may be executed now.
        """
        if not self._is_waiting or self.has_work() or work.size > LARGE:
            return False
        box = self._boxes.get(client)
        if box is None or box.items or box.is_waiting or box.is_leaving:
            return False
        self._held.append(Arrival(client, work))
        return True

    def served(self, seconds: float) -> None:
        """Record that the last item taken has been served, and how many seconds it kept the thread."""
        box, self._serving = self._serving, None
        if box is not None:
            box.finish += seconds
            if box.is_leaving:
                self._hasten(box, seconds)
            if box.client:
                self._line_up(box)

    def _hasten(self, box: Box, seconds: float) -> None:
        """Remove the remaining messages of a client that has left, if it has had its time."""
        box.aftermath += seconds
        sharing = sum(each.is_leaving for each in self._boxes.copy().values())
        if box.aftermath > AFTERMATH / max(1, sharing):
            with box.lock:
                while len(box.items) > 1:
                    self._forget(box, box.items.popleft())

    def others_wait(self) -> bool:
        """Return whether anything waits apart from the last item taken."""
        return bool(self._turns) or self._ready.qsize() > 0

    def has_something_of_others(self, client: str) -> bool:
        """Return whether a message of another client waits to be executed."""
        boxes = self._boxes.copy().items()
        return any(box.items and not box.is_waiting for key, box in boxes if key != client)

    def others_have_come(self) -> bool:
        """Return whether anything waits apart from the last item taken, at a socket too."""
        if self.sockets is not None:
            self.sockets.poll()
        return self.others_wait()

    def wait(self, seconds: float) -> Event | Arrival | None:
        """Return the next item as soon as there is one; None when the time is over, or a socket had something else."""
        if self.sockets is not None:
            self._is_waiting = True
            try:
                self.sockets.poll(seconds, self.has_work)
            finally:
                self._is_waiting = False
            return self._next()
        taken = self._next()
        if taken is None:
            try:
                box = self._ready.get(timeout=seconds)
            except queue.Empty:
                return None
            self._line_up(box)
            taken = self._next()
        return taken

    def has_work(self) -> bool:
        """Return whether something waits."""
        return bool(self._held) or self.others_wait()

    def wait_for_work(self, seconds: float) -> None:
        """Wait until something arrives, or the time is over; take nothing. Any thread, but one at a time."""
        if self.sockets is not None:
            self.sockets.wait(seconds, self.has_work)
        elif not self.has_work():
            with contextlib.suppress(queue.Empty):
                self._ready.put(self._ready.get(timeout=seconds))

    def at_hand(self, seconds: float = float("inf")) -> Iterator[Event | Arrival]:
        """Yield the items that are present now, for at most this many seconds. Items that come meanwhile stay."""
        if self.sockets is not None:
            self.sockets.poll()
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
        """Yield the present items that may be served while a script runs, for at most this long; the rest stays.

        Args:
            executing: the client whose batch runs the script; its other batches come after that one.
            waits: whether all items of this client have to wait.
        """
        if self.sockets is not None:
            self.sockets.poll()
        until = time.perf_counter() + seconds
        outer, self._serving = self._serving, None
        staying: list[Box] = []
        has_stop = False
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
                    has_stop = has_stop or (not is_to_stay and self._has_stop(box))
                elif (taken := self._take(box)) is not None:
                    yield taken
        finally:
            self.has_stop_waiting = has_stop
            self.served(0.0)
            self._serving = outer
            for box in staying:
                self._line_up(box)

    def _next(self) -> Event | Arrival | None:
        """Return the next item; None if there is none."""
        if self._serving is not None:
            self.served(0.0)
        if self._held:
            return self._held.popleft()
        while (box := self._first()) is not None:
            if (taken := self._take(box)) is not None:
                return taken
        return None

    def _first(self) -> Box | None:
        """Take the queue with the next turn out of the line."""
        if self._serving is not None:
            self.served(0.0)
        while count := self._ready.qsize():
            box = self._ready.get_nowait()
            if count == 1 and not self._turns and box.items and not self._is_parked(box):
                return box  # it is alone
            self._line_up(box)
        if not self._turns:
            return None
        box = heapq.heappop(self._turns)[2]
        box.is_in_line = False
        return box

    def _line_up(self, box: Box) -> None:
        """Put a queue into the line, if it is not empty."""
        if box.is_in_line or self._is_parked(box):
            return
        while (first := _first_of(box)) is None:
            box.is_known = False
            if not box.items:
                return
            box.is_known = True  # something came just now
        box.is_in_line = True
        heapq.heappush(self._turns, (self._start(box, first), first.number, box))

    def _start(self, box: Box, item: Item) -> float:
        """Return the virtual time at which an item is served.

        An item that had to wait, for a script or until its client had read, gets no earlier start for it: otherwise the
        others would wait for everything that has accumulated.
        """
        return max(item.virtual, box.finish - CREDIT, self._virtual - CREDIT)

    def _is_parked(self, box: Box) -> bool:
        """Return whether nothing may be taken out now. The queue stays known; a change announces it again."""
        if box.is_suspended or box.is_kept_back:
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
            box.size_taken += item.what.work.size
        start = self._start(box, item)
        box.finish = max(box.finish, start)
        self._virtual = max(self._virtual, start)
        if box is not self._events:
            self._serving = box
        if (
            not box.client
        ):  # events and questions are also served while a script runs that one of them has started
            self._line_up(box)
        return item.what

    def _must_wait(self, box: Box) -> bool:
        """Return whether the first item of a queue has to wait for scripts."""
        item = _first_of(box)
        if item is None:
            return False
        if item.waits_for_scripts is not None:
            return item.waits_for_scripts
        if box.waits is None or box.waits[0] != item.number:
            assert isinstance(item.what, Arrival)
            box.waits = item.number, item.what.work.waits_for_scripts()
        return box.waits[1]

    def _has_stop(self, box: Box) -> bool:
        """Return whether anything that waits in a queue stops the simulation. Each item is examined once."""
        items = box.items.copy()  # at once, as other threads add some meanwhile
        if not items or box.client.startswith(VIEWER):  # a viewer's is refused
            return False
        examined, stop = box.stop
        for item in reversed(items):
            if item.number <= examined:
                break
            if _stops(item):
                stop = max(stop, item.number)
        box.stop = max(examined, items[-1].number), stop
        return any(item.number == stop for item in items)


def _unchanged(work: Work) -> Work:
    return work


def _first_of(box: Box) -> Item | None:
    """Return the first item of a queue; None if it is empty."""
    if not box.items:
        return None
    try:
        return box.items[0]
    except IndexError:  # it was taken out just now
        return None


def _stops(item: Item) -> bool:
    """Return whether an item stops the simulation."""
    if isinstance(item.what, Arrival):
        return item.what.work.stops()
    return item.stops is not None and item.stops()
