"""Count the bytes of unfinished messages at all sockets, and cut connections that hold too many or for too long.

A message is kept from its first byte to its last, so peers that never send the last one would fill the memory together,
each within the limit of one message. When there are too many bytes, the connection goes whose message has been arriving
for the longest time: that of a program that really sends is complete long before.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from simx_server.limits import Limits

_FREE = 1 << 16
"""Bytes that a connection holds without being counted: a lock for each small message would cost too much."""


class Unfinished:
    """The counter of one server. Any thread."""

    def __init__(
        self, limits: Callable[[], Limits] = Limits, clock: Callable[[], float] = time.monotonic
    ) -> None:
        """Count nothing yet.

        Args:
            limits: returns the present limits.
            clock: seconds.
        """
        self._limits, self._clock = limits, clock
        self._lock = threading.Lock()
        self._held: dict[Holder, None] = {}
        """The connections with an unfinished message, in the order of their first bytes."""

        self.size = 0
        """Bytes of all of them."""

    def holder(self, cut: Callable[[str], object], *, is_timed: bool = True) -> Holder:
        """Return the account of a new connection.

        Args:
            cut: closes the connection for a reason, on any thread; called once at most.
            is_timed: a message has a total time.
        """
        return Holder(self, cut, is_timed)

    def look(self) -> None:
        """Cut the connections whose message has been arriving for too long; called now and then."""
        most = self._limits().message_seconds
        with self._lock:
            late = [each for each in self._held if each.is_timed and each.began < self._clock() - most]
            for each in late:
                self._cut(each)
        for each in late:
            each.cut(f"its message has not arrived within {most} s (limit 'message_seconds')")

    def hold(self, holder: Holder, size: int, *, is_new: bool) -> None:
        """Note what a connection holds, and cut the oldest ones while all together hold too much."""
        limit = self._limits().unfinished
        cut: list[Holder] = []
        with self._lock:
            if holder.is_cut:
                return
            if is_new or not size:
                self._drop(holder)
            if size and holder not in self._held:
                holder.began = self._clock()
                self._held[holder] = None
            self.size += size - holder.size
            holder.size = size
            while self.size > limit:
                cut.append(self._cut(next(iter(self._held))))
        for each in cut:
            each.cut(f"unfinished messages together have more than {limit} bytes (limit 'unfinished')")

    def _cut(self, holder: Holder) -> Holder:
        self._drop(holder)
        holder.is_cut = True
        return holder

    def _drop(self, holder: Holder) -> None:
        self._held.pop(holder, None)
        self.size -= holder.size
        holder.size = 0


class Holder:
    """The account of one connection. One thread at a time, except for what the counter does."""

    def __init__(self, counter: Unfinished, cut: Callable[[str], object], is_timed: bool) -> None:
        self._counter = counter
        self.cut = cut
        self.is_timed = is_timed
        self.size = 0
        self.began = 0.0
        """When the first bytes of the message came that is arriving."""

        self.is_cut = False

    def hold(self, size: int, *, is_new: bool = False) -> None:
        """Note the bytes of the connection's messages that are not complete; call it after each receive.

        Args:
            is_new: a message was completed, so the bytes are those of another one.
        """
        if size > _FREE or self.size:
            self._counter.hold(self, size if size > _FREE else 0, is_new=is_new)

    def end(self) -> None:
        """Hold nothing any more: the connection is closed. It refers to this account, and this no more to it."""
        self.hold(0)
        self.cut = bool
