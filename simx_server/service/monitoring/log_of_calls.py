"""Note the calls of clients, short: what was called, with which arguments, and what came back."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from heapq import merge
from itertools import islice
from operator import itemgetter
from typing import Any

from simx_client.protocol.commands import TRIGGER
from simx_client.protocol.messages import STATUS_OK
from simx_client.protocol.python.light_dataclass import dataclass

MOST_PER_STEP = 500
"""Calls of one simulation step that are kept, of those that read and of the others each; earlier ones are counted."""

_MOST_ITEMS = 24
"""Items of a list that are kept."""

_MOST_LETTERS = 160
"""Letters or bytes of a text that are kept."""

_MOST_DEPTH = 2

_ENTRY, _ITEM = 400, 40
"""About how many bytes a call takes, and each value in it."""

_NUMBER = itemgetter(0)
_PLAIN = (int, float, bool, type(None))


@dataclass(frozen=True, slots=True)
class Cut:
    """A long value, of which only the start is kept."""

    start: Any
    size: int

    def __repr__(self) -> str:
        return self.described(repr(self.start))

    def described(self, shown: str) -> str:
        """Return how a program would write it; `shown`: the start."""
        unit = "bytes" if isinstance(self.start, bytes) else "letters"
        if isinstance(self.start, list):
            return f"{shown[:-1]}, ... ({self.size} items)]"
        return f"{shown}... ({self.size} {unit})"


@dataclass(slots=True, eq=False)
class Called:
    """One call of a client."""

    client: str
    """Its name."""

    function: str
    arguments: tuple[Any, ...]
    """Shortened, in the order of the function's own arguments."""

    results: Any = None
    """A tuple, shortened; None: the answer has not come yet. Of a failed call the reason, a text."""

    has_failed: bool = False
    only_reads: bool = False
    is_stream: bool = False
    """The client asks for the results after each simulation step."""

    def mark_stream(self) -> None:
        """Note that the client asks for the results after each simulation step."""
        self.is_stream = True

    def finish(self, status: int, values: Sequence[Any]) -> None:
        """Note the answer. Any thread."""
        self.has_failed = status != STATUS_OK
        self.results = tuple(map(short, values))

    @property
    def size(self) -> int:
        """Return about how many bytes it takes."""
        return _ENTRY + sum(map(_size, (*self.arguments, *(self.results or ()))))


@dataclass(frozen=True, slots=True)
class CallsOfStep:
    """The calls that belong to one simulation step: those after the step before, until its end."""

    calls: tuple[Called, ...]
    left_out: int
    """Further calls of the step, which are not kept."""

    size: int
    has_changes: bool
    """One of the calls may change something."""


def short(value: Any, depth: int = 0) -> Any:
    """Return a value as it is, or a copy of its start: what is kept must be small, and must not change."""
    if isinstance(value, _PLAIN):
        return value
    if isinstance(value, str | bytes):
        return value if len(value) <= _MOST_LETTERS else Cut(value[:_MOST_LETTERS], len(value))
    if isinstance(value, list | tuple):
        if depth > _MOST_DEPTH:
            return Cut([], len(value))  # pyright: ignore[reportUnknownArgumentType]
        kept = [short(each, depth + 1) for each in islice(value, _MOST_ITEMS)]  # pyright: ignore[reportUnknownArgumentType, reportUnknownVariableType]
        return kept if len(value) <= _MOST_ITEMS else Cut(kept, len(value))  # pyright: ignore[reportUnknownArgumentType]
    if isinstance(value, dict):
        return Cut({}, len(value)) if len(value) else {}  # pyright: ignore[reportUnknownArgumentType]
    return short(repr(value)[: _MOST_LETTERS + 1])


def _size(value: Any) -> int:
    if isinstance(value, str | bytes):
        return _ITEM + len(value)
    if isinstance(value, list):
        return _ITEM + sum(map(_size, value))  # pyright: ignore[reportUnknownArgumentType]
    if isinstance(value, Cut):
        return _ITEM + _size(value.start)
    return _ITEM


class LogOfCalls:
    """The calls since the last simulation step. Physics thread only, except where an answer comes from another one."""

    def __init__(self) -> None:
        self._calls: deque[tuple[int, Called]] = deque(maxlen=MOST_PER_STEP)
        self._reads: deque[tuple[int, Called]] = deque(maxlen=MOST_PER_STEP)
        """Kept separately, with numbers: a client that reads without a pause displaces no other call."""

        self._count = 0
        self._is_left_out: Callable[[str, str, Sequence[Any]], bool] = lambda _name, _function, _arguments: (
            False
        )

    def leave_out(self, is_left_out: Callable[[str, str, Sequence[Any]], bool]) -> None:
        """Note no more the calls, such as the web viewer's own, of which a function returns True.

        Args:
            is_left_out: takes the client's name, the function and the arguments.
        """
        self._is_left_out = is_left_out

    def note(
        self,
        client: str,
        function: str,
        arguments: Sequence[Any],
        answer: tuple[int, Sequence[Any]] | Future[Any] | None,
        *,
        only_reads: bool = False,
    ) -> Called | None:
        """Note a call; return it, or None if it is left out.

        Args:
            client: the name of the client.
            arguments: of the call, as they came.
            answer: status and values; a future of both, of an image or a trigger; None: `Called.finish` gets it later.
            only_reads: the function changes nothing. A trigger counts as such a call: it comes with every step.
        """
        if self._is_left_out(client, function, arguments):
            return None
        only_reads = only_reads or function == TRIGGER
        called = Called(client, function, tuple(map(short, arguments)), only_reads=only_reads)
        if isinstance(answer, Future):
            answer.add_done_callback(lambda done: called.finish(*done.result()))
        elif answer is not None:
            called.finish(*answer)
        self._count += 1
        (self._reads if only_reads else self._calls).append((self._count, called))
        return called

    def take(self) -> CallsOfStep:
        """Return the calls since the last time, and forget them."""
        calls = tuple(called for _, called in merge(self._calls, self._reads, key=_NUMBER))
        has_changes = bool(self._calls)
        left_out, self._count = self._count - len(calls), 0
        self._calls.clear()
        self._reads.clear()
        return CallsOfStep(calls, left_out, sum(each.size for each in calls), has_changes)
