"""Limit what waits of each client and of all, and find the clients that send faster than they are served."""

from __future__ import annotations

import threading
import time
from collections import Counter
from collections.abc import Callable

from simx_client.protocol.codec import MAX_BATCH
from simx_server.limits import Limits

from .box import Box

MUCH, MUCH_BYTES = 300, 32 << 20
"""Waiting messages and bytes of a client above which it should be slowed down. A client of this project has at most 200
messages on the way.
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


def has_much(box: Box) -> bool:
    """Return whether so much of a client waits that it should be slowed down. Any thread."""
    return len(box.items) >= MUCH or box.size > MUCH_BYTES


class Flood:
    """The limits of what waits, and the messages that were thrown away. Any thread; the caller holds a queue's lock."""

    def __init__(self, limits: Callable[[], Limits], all_waiting: Callable[[], int]) -> None:
        """Make it without a message.

        Args:
            limits: returns the present limits.
            all_waiting: returns the waiting bytes of all clients.
        """
        self._limits, self._all_waiting = limits, all_waiting
        self._lock = threading.Lock()
        """Lock of the dropped messages. The count of a moment is not guarded: it may miss a message."""

        self._tick = 0
        """The moment of the newest message."""

        self._recent = 0
        """Messages of that moment, of all clients."""

        self._had_much = False
        """Many bytes of a client have waited since `take_had_much`."""

        self.dropped: Counter[tuple[str, str]] = Counter()
        """Messages that were thrown away since `take_dropped`, by client and limit."""

    def limit_reached(self, box: Box, size: int) -> str:
        """Return the limit that one more message of this many bytes would exceed; empty if there is space for it."""
        limits, waiting = self._limits(), box.size
        of_client = waiting + size
        if size > MAX_BATCH:
            return "message"
        if len(box.items) >= limits.waiting:
            return "waiting"
        if waiting and of_client > limits.waiting_bytes:
            return "waiting_bytes"
        if of_client > RESERVED and self._all_waiting() + size > limits.all_waiting_bytes:
            return "all_waiting_bytes"
        return ""

    def drop(self, box: Box, limit: str) -> None:
        """Count a message that is thrown away because of a limit."""
        with self._lock:
            self.dropped[box.client, limit] += 1

    def count(self, box: Box, size: int) -> bool:
        """Count the bytes of a message that is going to be put in; return whether its client should be slowed down."""
        box.size_put += size
        waiting = box.size
        if waiting > RESERVED:
            self._had_much = True
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

    # --- without a queue's lock ------------------------------------------------------------------

    def take_dropped(self) -> Counter[tuple[str, str]]:
        """Return how many messages of each client were thrown away since the last call, and for which limit."""
        with self._lock:
            dropped, self.dropped = self.dropped, Counter()
        return dropped

    def take_had_much(self) -> bool:
        """Return whether many bytes of a client have waited since the last call."""
        had_much, self._had_much = self._had_much, False
        return had_much
