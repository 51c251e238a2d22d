"""Searching joint values for a pose from random starts, and following a straight line of poses."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence

import numpy as np

from simx_server.scene.geometry.poses import Pose, blend

from ..errors import CommandError
from .chain import Joints
from .scratch import Array
from .solver import Calculation, Method, Result, Solver

_HOW = Calculation(Method.ADAPTIVE, 0.0, 60)
"""From a random start the UR5 arrives in two of three trials; more iterations help less than another start."""

LONGEST = 60.0
"""Seconds that a search, or a plan, may take whatever a script wants."""

MOST_STATES = 10_000
"""Of a path that a script asks for."""

_SAME = 1e-3
"""rad or m: configurations that differ less in every joint are one."""


def find_configs(
    solver: Solver,
    joints: Joints,
    goals: Sequence[Pose],
    random: np.random.Generator,
    *,
    seconds: float,
    trials: int | None = None,
    start: Array | None = None,
    sampled: tuple[Array, Array] | None = None,
    accepts: Callable[[Array], bool] | None = None,
    serve_others: Callable[[], object] | None = None,
) -> Iterator[Array]:
    """Different joint values (n,) that bring the tips to their goals, one after the other as they are found.

    At most `seconds` of wall time and so many `trials` are spent, always at least one. `start`: the first trial is from
    there, else from a random place. `sampled`: least values and ranges (n,) of random starts, else the joints' limits.
    `accepts`: what else a configuration must fulfil.
    """
    end = time.monotonic() + min(seconds, LONGEST)
    low, extent = sampled if sampled is not None else sampling_range(joints)
    found: list[Array] = []
    trial = 0
    while trial == 0 or (time.monotonic() < end and (trials is None or trial < trials)):
        begin = low + extent * random.random(len(low)) if start is None or trial else start
        trial += 1
        solution = solver.solve(begin, goals, _HOW)
        if serve_others is not None:
            serve_others()
        if solution.result != Result.SUCCESS:
            continue
        values = wrapped(joints, solution.values)
        if any(np.max(np.abs(values - known)) < _SAME for known in found):
            continue
        if accepts is None or accepts(values):
            found.append(values)
            yield values


def straight_path(
    solver: Solver,
    start: Array,
    begin: Sequence[Pose],
    goals: Sequence[Pose],
    count: int,
    accepts: Callable[[Array], bool] | None = None,
) -> list[Array] | None:
    """`count` configurations (n,) whose tips go straight from `begin` to `goals`; None when one is out of reach.

    The first is that of `begin` near `start`, the last that of `goals`. Raises CommandError for too many.
    """
    if not 0 <= count <= MOST_STATES:
        raise CommandError(f"a path has up to {MOST_STATES} states, not {count}")
    path: list[Array] = []
    values = start
    for share in np.linspace(0.0, 1.0, max(2, count)).tolist():
        between = [_between(a, b, share) for a, b in zip(begin, goals, strict=True)]
        solution = solver.solve(values, between, _HOW)
        if solution.result != Result.SUCCESS or (accepts is not None and not accepts(solution.values)):
            return None
        values = solution.values
        path.append(values)
    return path


def sampling_range(joints: Joints) -> tuple[Array, Array]:
    """(least value, range) of each joint; a joint without limits turns once, or moves by 1 m to both sides."""
    no_limit = np.where(joints.max_step < 0.1 + 1e-9, 1.0, math.pi)
    low = np.where(np.isfinite(joints.low), joints.low, -no_limit)
    high = np.where(np.isfinite(joints.high), joints.high, no_limit)
    return low, high - low


def asked_range(
    low: Sequence[float] | None, ranges: Sequence[float] | None, order: Sequence[int]
) -> tuple[Array, Array] | None:
    """(least value, range) of each joint as a script gives them, in its order; None when it gives none.

    `order`: where each of the script's joints is among ours. Raises CommandError for another count.
    """
    if not low or not ranges:
        return None
    if not len(low) == len(ranges) == len(order):
        raise CommandError(
            f"lowest values and ranges of random starts are one for each of the {len(order)} joints"
        )
    found = np.zeros(len(order)), np.zeros(len(order))
    found[0][list(order)], found[1][list(order)] = low, ranges
    return found


def wrapped(joints: Joints, values: Array) -> Array:
    """Joints that turn without end in -pi..pi."""
    endless = ~np.isfinite(joints.low) & (joints.max_step > 0.1 + 1e-9)
    return np.where(endless, np.remainder(values + math.pi, 2 * math.pi) - math.pi, values)


def _between(a: Pose, b: Pose, share: float) -> Pose:
    x, y, z = ((1 - share) * p + share * q for p, q in zip(a[0], b[0], strict=True))
    return (x, y, z), blend(a[1], b[1], share)
