"""Search joint values for a pose from random starts, and follow a straight line of poses."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence

import numpy as np

from simx_server.scene.poses.poses import Pose, blend

from ..errors import CommandError
from .chain import Joints
from .scratch import Array
from .solver import Calculation, Method, Result, Solver

_HOW = Calculation(Method.ADAPTIVE, 0.0, 60)
"""From a random start the UR5 arrives in two of three trials; more iterations help less than another start."""

LONGEST = 60.0
"""Maximum duration in seconds of a search or a plan, even if a script requests more."""

MOST_STATES = 10_000
"""Maximum number of states in a path that a script requests."""

_SAME = 1e-3
"""rad or m: configurations that differ less in every joint count as equal."""


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
    may_go_on: Callable[[], bool] | None = None,
) -> Iterator[Array]:
    """Yield different joint values (n,) that bring the tips to their goals, as they are found.

    Args:
        solver: the solver.
        joints: the joints that it moves.
        goals: world poses of the targets.
        random: source of the random starts.
        seconds: maximum wall time; at least one trial is made.
        trials: maximum number of trials.
        start: joint values (n,) of the first trial; a random configuration if None.
        sampled: minimum values and ranges (n,) of random starts; the joints' limits if None.
        accepts: a further condition for a configuration.
        may_go_on: called between trials; where it returns false, the time is over.
    """
    end = time.monotonic() + min(seconds, LONGEST)
    low, extent = sampled if sampled is not None else sampling_range(joints)
    found: list[Array] = []
    trial = 0
    while trial == 0 or (time.monotonic() < end and (trials is None or trial < trials)):
        begin = low + extent * random.random(len(low)) if start is None or trial else start
        trial += 1
        solution = solver.solve(begin, goals, _HOW)
        if may_go_on is not None and not may_go_on():
            return
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
    may_go_on: Callable[[], bool] | None = None,
) -> list[Array] | None:
    """Return `count` configurations (n,) whose tips move on straight lines between two lists of poses.

    The first has the first poses and is near `start`, the last has the poses `goals`.

    Returns:
        None when a pose is out of reach, or `may_go_on`, which is called for each configuration, returns false.

    Raises:
        CommandError: too many states.
    """
    if not 0 <= count <= MOST_STATES:
        raise CommandError(f"a path has up to {MOST_STATES} states, not {count}")
    path: list[Array] = []
    values = start
    for share in np.linspace(0.0, 1.0, max(2, count)).tolist():
        if may_go_on is not None and not may_go_on():
            return None
        between = [_between(a, b, share) for a, b in zip(begin, goals, strict=True)]
        solution = solver.solve(values, between, _HOW)
        if solution.result != Result.SUCCESS or (accepts is not None and not accepts(solution.values)):
            return None
        values = solution.values
        path.append(values)
    return path


def sampling_range(joints: Joints) -> tuple[Array, Array]:
    """Return (minimum, range) of each joint; a joint without limits turns once, or moves by 1 m to both sides."""
    no_limit = np.where(joints.is_hinge, math.pi, 1.0)
    low = np.where(np.isfinite(joints.low), joints.low, -no_limit)
    high = np.where(np.isfinite(joints.high), joints.high, no_limit)
    return low, high - low


def asked_range(
    low: Sequence[float] | None, ranges: Sequence[float] | None, order: Sequence[int]
) -> tuple[Array, Array] | None:
    """Return (minimum, range) of each joint as a script passes them, in our order; None when it passes none.

    Args:
        low: minimum values in the script's order.
        ranges: ranges in the script's order.
        order: our index of each of the script's joints.

    Raises:
        CommandError: the number of values is wrong.
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
    """Return joint values with those of cyclic joints in -pi..pi."""
    endless = ~np.isfinite(joints.low) & joints.is_hinge
    return np.where(endless, np.remainder(values + math.pi, 2 * math.pi) - math.pi, values)


def _between(a: Pose, b: Pose, share: float) -> Pose:
    x, y, z = ((1 - share) * p + share * q for p, q in zip(a[0], b[0], strict=True))
    return (x, y, z), blend(a[1], b[1], share)
