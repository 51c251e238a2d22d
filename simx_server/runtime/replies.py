"""The replies to the calls of a batch; those to sets that nobody waits for are put together into one."""

from __future__ import annotations

from typing import Any

from simx_client.protocol.messages import STATUS_OK, Reply, of_fields


class Replies:
    """In the order of their calls."""

    __slots__ = ("_count", "_next_id", "_time_ms", "is_awaited", "made")

    def __init__(self, earlier: list[Reply]) -> None:
        """Begin with those that are there already."""
        self.made = earlier
        self.is_awaited = bool(earlier)
        """Somebody may wait for one of them. What was read, or why it was not, counts as such: it may be megabytes, of
        which no message shall hold many times as many."""

        self._count = [0]
        """The values of the last reply that ``done`` made."""

        self._next_id: int | None = None
        """Of a call that it may count as well, at this time."""

        self._time_ms = 0

    def add(self, call_id: int, status: int, time_ms: int, values: list[Any]) -> None:
        """Reply to a call whose answer says something, or is waited for."""
        self.is_awaited = True
        self.made.append(of_fields(Reply, (call_id, status, time_ms, values)))

    def done(self, call_id: int, time_ms: int) -> None:
        """A call that nobody waits for was executed, and gave nothing."""
        if call_id == self._next_id and time_ms == self._time_ms:
            self._count[0] += 1
        else:
            self._count, self._time_ms = [1], time_ms
            self.made.append(Reply(call_id, STATUS_OK, time_ms, self._count))
        self._next_id = call_id + 1
