"""Joint values that put an arm where given ones do: hinges may be whole turns away."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import product

from simx_server.errors import CommandError

_MOST = 10_000
"""Most configurations."""

_ROUNDING = 1e-9
"""Part of a turn by which a value may lie outside an interval."""


def alternatives(
    values: Sequence[float], intervals: Sequence[tuple[float, float] | None]
) -> list[tuple[float, ...]]:
    """Return all configurations whose values differ from the given ones by whole turns, those included.

    Args:
        values: rad or m, one for each joint.
        intervals: least value and range of each joint that may turn; None for a joint that keeps its value.

    Raises:
        CommandError: there are too many, or a number is not finite.
    """
    possible: list[list[float]] = []
    count = 1
    for value, interval in zip(values, intervals, strict=True):
        if interval is None:
            possible.append([value])
            continue
        turns = _turns(value, *interval)
        number = max(0, turns.stop - turns.start)
        count *= number
        if max(number, count) > _MOST:
            raise CommandError(f"there are more than {_MOST} such configurations; limit the intervals")
        possible.append([value + math.tau * turn for turn in turns])
    return list(product(*possible))


def _turns(value: float, least: float, extent: float) -> range:
    """Return the numbers of whole turns after which an angle lies in an interval."""
    if not math.isfinite(value) or not math.isfinite(least + extent):
        raise CommandError(f"an angle and its interval are finite numbers, not {value}, {least}, {extent}")
    first = math.ceil((least - value) / math.tau - _ROUNDING)
    return range(first, math.floor((least + extent - value) / math.tau + _ROUNDING) + 1)
