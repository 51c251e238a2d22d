"""Timing calls side by side: short rounds in turn, so that whatever drifts on the machine hits all cases alike."""

from __future__ import annotations

import logging
import statistics
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial

from .scheduling import DISTURBANCE, MOST_SHARE

logger = logging.getLogger(__name__)

PROGRESS_EVERY = 2.0
"""Seconds after which something is said about a measurement that goes on."""


@dataclass(frozen=True)
class Effort:
    """How long to measure."""

    sets: int
    """Sets of fresh processes: where the system places a process decides half of a round trip, for its life."""

    rounds: int
    """Rounds in each set."""

    factor: float
    """Scales the number of calls of a round, seconds of observation and repetitions of slow things."""

    least: int = 2
    """The fewest calls a round, or processes to start, where a measurement does not need more."""

    def count(self, full: int, least: int | None = None) -> int:
        """So many calls a round, or processes to start, instead of `full`."""
        return max(self.least if least is None else least, round(full * self.factor))

    def seconds(self, full: float) -> float:
        return full * self.factor


FULL = Effort(sets=7, rounds=2, factor=1.0)
QUICK = Effort(sets=2, rounds=1, factor=0.2)


def percentile(values: Sequence[float], percent: float) -> float:
    """The value below which `percent` of the values lie, by the nearest rank."""
    if not values:
        raise ValueError("nothing was measured, so there is no percentile")
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(len(ordered) * percent / 100))]


@dataclass(frozen=True)
class Rounds:
    """What one case took: a list of values per round, seconds unless the owner says otherwise."""

    values: tuple[tuple[float, ...], ...]

    @property
    def medians(self) -> list[float]:
        """One per round."""
        return [statistics.median(values) for values in self.values]

    @property
    def median(self) -> float:
        """The median of the rounds' medians."""
        return statistics.median(self.medians)

    @property
    def p99(self) -> float:
        """The median of the rounds' 99th percentiles: a typical bad call, not the worst minute."""
        return statistics.median([percentile(values, 99) for values in self.values])

    @property
    def count(self) -> int:
        return sum(len(values) for values in self.values)


def ratio(numerator: Rounds, denominator: Rounds) -> float:
    """How many times as long: the median over the rounds of the quotient of both medians of that round."""
    pairs = zip(numerator.medians, denominator.medians, strict=True)
    return statistics.median([above / below for above, below in pairs])


def ratio_p99(numerator: Rounds, denominator: Rounds) -> float:
    """As `ratio`, of the rounds' 99th percentiles."""
    pairs = zip(numerator.values, denominator.values, strict=True)
    return statistics.median([percentile(above, 99) / percentile(below, 99) for above, below in pairs])


def difference(minuend: Rounds, subtrahend: Rounds) -> Rounds:
    """What the first takes more, round by round."""
    pairs = zip(minuend.medians, subtrahend.medians, strict=True)
    return Rounds(tuple((above - below,) for above, below in pairs))


def timed(call: Callable[[], object], calls: int) -> tuple[float, ...]:
    """Seconds each of so many calls took."""
    now = time.perf_counter
    took = []
    for _ in range(calls):
        began = now()
        call()
        took.append(now() - began)
    return tuple(took)


def in_turn(
    what: str, cases: Mapping[str, Callable[[], tuple[float, ...]]], rounds: int
) -> dict[str, Rounds]:
    """Let all cases measure in turn, A B C, C B A, A B C, ...: a steady drift cancels out.

    A turn that other programs disturb is repeated, and the quietest turns are kept.

    Args:
        what: for the progress line.
        cases: name to something that measures one round and returns its values.
    """
    order, progress = list(cases), Progress(what, rounds * len(cases))
    turns: list[tuple[float, dict[str, tuple[float, ...]]]] = []
    wanted = rounds
    while len(turns) < wanted:
        before, began = DISTURBANCE.sample(), time.perf_counter()
        turn: dict[str, tuple[float, ...]] = {}
        for name in order:
            turn[name] = cases[name]()
            progress.step(name)
        order.reverse()
        share = DISTURBANCE.share(before)
        turns.append((share, turn))
        if share > MOST_SHARE and wanted < 2 * rounds and DISTURBANCE.may_repeat(time.perf_counter() - began):
            wanted += 1
    quiet = sorted(range(len(turns)), key=lambda place: turns[place][0])[:rounds]
    kept = [turns[place] for place in sorted(quiet)]
    DISTURBANCE.turns += rounds
    DISTURBANCE.repeated += len(turns) - rounds
    DISTURBANCE.disturbed += sum(share > MOST_SHARE for share, _ in kept)
    return {name: Rounds(tuple(turn[name] for _, turn in kept)) for name in cases}


def side_by_side(
    what: str,
    cases: Mapping[str, Callable[[], object]],
    *,
    rounds: int,
    calls: int,
    settle: Callable[[], object] | None = None,
) -> dict[str, Rounds]:
    """Time the calls of all cases, in turn.

    Args:
        calls: timed calls per round; a tenth of them goes ahead untimed.
        settle: done after each round of each case, untimed; for calls whose work goes on after they return.
    """

    def one_round(call: Callable[[], object]) -> tuple[float, ...]:
        timed(call, max(1, calls // 10))
        took = timed(call, calls)
        if settle is not None:
            settle()
        return took

    return in_turn(what, {name: partial(one_round, call) for name, call in cases.items()}, rounds)


def repeated(sets: int, one_set: Callable[[ExitStack], Mapping[str, Rounds]]) -> dict[str, Rounds]:
    """Measure with several sets of fresh processes; the rounds of all sets together.

    Args:
        one_set: starts its processes on the stack, and measures.
    """
    together: dict[str, Rounds] = {}
    for _ in range(sets):
        with ExitStack() as stack:
            for name, taken in one_set(stack).items():
                before = together.get(name, Rounds(()))
                together[name] = Rounds(before.values + taken.values)
    return together


class Progress:
    """Says every two seconds how far something is."""

    def __init__(self, what: str, steps: int) -> None:
        self._what, self._steps, self._done = what, steps, 0
        self._last = time.monotonic()

    def step(self, detail: str = "") -> None:
        """One of the steps is done."""
        self._done += 1
        self._steps = max(self._steps, self._done)  # a disturbed turn is repeated
        if time.monotonic() - self._last >= PROGRESS_EVERY:
            self._last = time.monotonic()
            logger.info("%s: %d of %d (%s)", self._what, self._done, self._steps, detail)
