"""Search joint values for a pose from random starts, and follow a straight line of poses."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from simx_server.scene.poses.poses import Pose, blend

from ..errors import CommandError
from .chain import Joints
from .sampling import Effort, Nearness, sampling_range, wrapped
from .scratch import Array
from .solver import Calculation, Method, Result, Solver

_HOW = Calculation(Method.ADAPTIVE, 0.0, 60)
"""From a random start the UR5 arrives in two of three trials; more iterations help less than another start."""

MOST_STATES = 10_000
"""Maximum number of states in a path that a script requests."""

_SAMPLES_AT_ONCE = 100
"""Random starts between two calls that serve others."""

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
    near: Nearness | None = None,
    accepts: Callable[[Array], bool] | None = None,
    may_go_on: Callable[[], bool] | None = None,
) -> Iterator[Array]:
    """Yield different joint values (n,) that bring the tips to their goals, as they are found.

    Args:
        solver: the solver.
        joints: the joints that it moves.
        goals: world poses of the targets.
        random: source of the random starts.
        seconds: maximum work, see `Effort`; without `near` it is enough for one trial at least.
        trials: maximum number of trials.
        start: joint values (n,) of the first trial; a random configuration if None.
        sampled: minimum values and ranges (n,) of random starts; the joints' limits if None.
        near: random starts whose tips are farther away are left out.
        accepts: a further condition for a configuration.
        may_go_on: called between trials; where it returns false, the time is over.
    """
    one_trial = 0.0 if near is not None else _HOW.iterations * solver.seconds_per_look
    effort = Effort(max(seconds, one_trial), solver.seconds_per_look)
    low, extent = sampled if sampled is not None else sampling_range(joints)
    found: list[Array] = []
    trial = 0
    while effort.is_left and (trials is None or trial < trials):
        if start is not None and not trial:
            begin = start
        elif near is None:
            begin = low + extent * random.random(len(low))
        else:
            most = min(_SAMPLES_AT_ONCE, effort.samples)
            begin, count, is_near = solver.sample(random, (low, extent), goals, near, most)
            effort.spend(samples=count - is_near)
            if not is_near:
                if may_go_on is None or may_go_on():
                    continue
                return
        trial += 1
        solution = solver.solve(begin, goals, _HOW, effort.looks)
        effort.spend(looks=solution.looks)
        if may_go_on is not None and not may_go_on():
            return
        if solution.result != Result.SUCCESS:
            continue
        values = wrapped(joints, solution.values)
        if any(np.max(np.abs(values - known)) < _SAME for known in found):
            continue
        effort.spend(checks=accepts is not None)
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


def _between(a: Pose, b: Pose, share: float) -> Pose:
    x, y, z = ((1 - share) * p + share * q for p, q in zip(a[0], b[0], strict=True))
    return (x, y, z), blend(a[1], b[1], share)
