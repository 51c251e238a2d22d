"""Queue what arrives for the physics thread: a bounded queue per client, served fairly.

Each client has a queue (`box.py`), which keeps its messages in order. `fairness.py` chooses the queue that is served
next, `flood.py` limits the messages that wait, and `overdue.py` takes calls out that have waited too long.

A long-running script holds the thread. Meanwhile the server executes calls of others that only read, or that set what a
script may find changed between two of its calls: signals, targets, poses. A batch with anything else, and all later
batches of its client, wait until the script is over.
"""

from __future__ import annotations

import itertools
import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Iterator
from typing import Any

from simx_server.limits import Limits
from simx_server.service.calls.work import BatchWork, CallsWork, Work

from .box import Arrival, Box, Event, Item
from .fairness import Fairness
from .flood import LARGE, MUCH, Flood, has_much
from .overdue import take_overdue
from .sockets import Sockets

MOST_QUESTIONS = 100
"""Waiting questions of one kind; further ones get no answer, and their senders may ask again."""


class Inbox:
    """Events and batches. Any thread may put them in; the physics thread takes them out."""

    def __init__(self, limits: Callable[[], Limits] = Limits) -> None:
        """Make an empty inbox.

        Args:
            limits: returns the present limits.
        """
        self._lock = threading.Lock()
        """Lock of the known clients."""

        self._boxes: dict[str, Box] = {}
        self._events = Box(is_charged=False)
        self._questions: dict[str, Box] = {}
        self._fairness = Fairness(lambda: sum(each.is_leaving for each in self._boxes.copy().values()))
        self._flood = Flood(limits, lambda: self.size)
        self.sockets: Sockets | None = None
        """Those that the physics thread reads; None: it waits for other threads only."""

        self._is_waiting = False
        """The physics thread waits for an item, which `hand_over` can give it."""

        self._numbers = itertools.count(1)
        self._held: deque[Event | Arrival] = deque()
        """Events that had to wait for a script's end, or a batch that was handed over; they come before all others."""

        self.has_stop_waiting = False
        """A client waited for a stop of the simulation when items were last served during a script."""

    def __len__(self) -> int:
        """Return the number of waiting items."""
        boxes = [self._events, *self._questions.copy().values(), *self._boxes.copy().values()]
        return len(self._held) + sum(len(box.items) for box in boxes)

    @property
    def size(self) -> int:
        """Return the waiting bytes of all clients."""
        return sum(box.size for box in self._boxes.copy().values())

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
            if reached := self._flood.limit_reached(box, size):
                self._flood.drop(box, reached)
                return False
            is_flood = self._flood.count(box, size)
            # Last, as it wakes the physics thread up, which needs the interpreter.
            self._add(box, Arrival(client, read(payload)), None)
            return not is_flood

    def limit_reached(self, client: str, size: int) -> str:
        """Return the limit that one more message of a client would exceed; empty if there is space for it."""
        box = self._boxes.get(client)
        if box is None:
            return ""
        with box.lock:
            return self._flood.limit_reached(box, size)

    def has_much(self, client: str) -> bool:
        """Return whether so much of a client waits that it should be slowed down."""
        box = self._boxes.get(client)
        return box is not None and has_much(box)

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
            box.items.appendleft(self._item(event, True))
            self._announce(box)

    def leave(self, client: str, leaving: Event) -> None:
        """Queue an event behind the last message of a client, and accept no more messages of it."""
        if (box := self._boxes.get(client)) is None:
            return
        with box.lock:
            if not box.is_leaving:
                while len(box.items) > MUCH:
                    box.forget(box.items.pop())
                self._add(box, leaving, False)
                box.is_leaving, box.is_suspended = True, False
                self._unpark(box)

    def is_leaving(self, client: str) -> bool:
        """Return whether a client is about to leave."""
        box = self._boxes.get(client)
        return box is not None and box.is_leaving

    def suspend(self, kind: str, is_behind: bool) -> None:
        """Suspend a client, or questions of a kind, or resume them."""
        box = self._boxes.get(kind) or self._questions.get(kind)
        if box is None:
            return
        with box.lock:
            if not box.is_leaving:
                box.is_suspended = is_behind
                self._unpark(box)

    def keep_back(self, client: str, is_kept: bool) -> None:
        """Hold back a client, even one that is leaving, until a step of its call is done; see `background.py`."""
        box = self._boxes.get(client)
        if box is None:
            return
        with box.lock:
            box.is_kept_back = is_kept
            self._unpark(box)

    def take_overdue(
        self,
        older_than: float,
        except_client: str | None = None,
        is_still_busy: Callable[[], bool] = lambda: True,
    ) -> Iterator[tuple[str, CallsWork]]:
        """Take the blocking calls of batches that have waited for long, see `overdue.py`; not on the physics thread."""
        return take_overdue(self._boxes.copy(), older_than, except_client, is_still_busy)

    @property
    def dropped(self) -> Counter[tuple[str, str]]:
        """Return the messages that were thrown away, by client and limit, without taking the list."""
        return self._flood.dropped

    def take_dropped(self) -> Counter[tuple[str, str]]:
        """Return how many messages of each client were thrown away since the last call, and for which limit."""
        return self._flood.take_dropped()

    def take_had_much(self) -> bool:
        """Return whether many bytes of a client have waited since the last call."""
        return self._flood.take_had_much()

    def _item(
        self,
        what: Event | Arrival,
        waits_for_scripts: bool | None,
        stops: Callable[[], bool] | None = None,
    ) -> Item:
        """Return an entry that arrives now."""
        virtual, number = self._fairness.virtual, next(self._numbers)
        return Item(what, virtual, number, time.monotonic(), waits_for_scripts, stops)

    def _add(
        self,
        box: Box,
        what: Event | Arrival,
        waits_for_scripts: bool | None,
        stops: Callable[[], bool] | None = None,
    ) -> None:
        box.items.append(self._item(what, waits_for_scripts, stops))
        self._announce(box)

    def _announce(self, box: Box) -> None:
        if not box.is_known:
            box.is_known = True
            self._tell(box)

    def _unpark(self, box: Box) -> None:
        if box.unpark():
            self._tell(box)

    def _tell(self, box: Box) -> None:
        """Tell the physics thread that something waits in a queue."""
        self._fairness.announce(box)
        if self.sockets is not None:
            self.sockets.wake()

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
        if box is None or box.items or box.is_suspended or box.is_kept_back or box.is_leaving:
            return False
        self._held.append(Arrival(client, work))
        return True

    def served(self, seconds: float) -> None:
        """Record that the last item taken has been served, and how many seconds it kept the thread."""
        self._fairness.served(seconds)

    def has_work(self) -> bool:
        """Return whether something waits."""
        return bool(self._held) or self._fairness.has_more()

    def has_something_of_others(self, client: str) -> bool:
        """Return whether a message of another client waits to be executed."""
        boxes = self._boxes.copy().items()
        return any(box.items and not box.is_waiting for key, box in boxes if key != client)

    def others_have_come(self) -> bool:
        """Return whether anything waits apart from the last item taken, at a socket too."""
        if self.sockets is not None:
            self.sockets.poll()
        return self._fairness.has_more()

    def wait(self, seconds: float) -> Event | Arrival | None:
        """Return the next item as soon as there is one; None when the time is over, or a socket had something else."""
        if self.sockets is not None:
            self._is_waiting = True
            try:
                self.sockets.poll(seconds, self.has_work)
            finally:
                self._is_waiting = False
        elif (taken := self._next()) is not None:
            return taken
        else:
            self._fairness.wait(seconds)
        return self._next()

    def wait_for_work(self, seconds: float) -> None:
        """Wait until something arrives, or the time is over; take nothing. Any thread, but one at a time."""
        if self.sockets is not None:
            self.sockets.wait(seconds, self.has_work)
        elif not self.has_work():
            self._fairness.wait(seconds)

    def at_hand(self, seconds: float = float("inf")) -> Iterator[Event | Arrival]:
        """Yield the items that are present now, for at most this many seconds. Items that come meanwhile stay."""
        if self.sockets is not None:
            self.sockets.poll()
        self._fairness.served(0.0)  # what waits behind the last item takes its place in the line
        if not self.has_work():
            return
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
        staying: list[Box] = []
        has_stop = False
        try:
            with self._fairness.inside():
                for _ in range(len(self)):
                    box = self._fairness.first()
                    if box is None:
                        return
                    if time.perf_counter() >= until:
                        staying.append(box)
                        return
                    is_to_stay = box.client and (box.client == executing or waits(box.client))
                    if is_to_stay or box.must_wait():
                        staying.append(box)
                        has_stop = has_stop or (not is_to_stay and box.has_stop())
                    elif (taken := self._take(box)) is not None:
                        yield taken
        finally:
            self.has_stop_waiting = has_stop
            for box in staying:
                self._fairness.line_up(box)

    def _next(self) -> Event | Arrival | None:
        """Return the next item; None if there is none."""
        self._fairness.served(0.0)
        if self._held:
            return self._held.popleft()
        while (box := self._fairness.first()) is not None:
            if (taken := self._take(box)) is not None:
                return taken
        return None

    def _take(self, box: Box) -> Event | Arrival | None:
        """Take the first item out of a queue; None if there is none, or it must not be taken now."""
        if box.park():
            return None
        if (item := box.pop()) is None:
            self._fairness.line_up(box)
            return None
        self._fairness.took(box, item)
        return item.what


def _unchanged(work: Work) -> Work:
    return work
