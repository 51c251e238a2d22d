"""What a simulation step costs beyond MuJoCo: its fixed part, and for each physics step."""

from __future__ import annotations

from contextlib import ExitStack
from functools import partial

from bench.measuring.measure import Effort, Rounds, difference, ratio, repeated, side_by_side
from bench.measuring.report import Findings, Ratio, Row

from .physics import Physics

TUTORIAL, SMALL = "ur5_rg2_kinect", "two_link_arm"
LONG, SHORT = 0.05, 0.001
"""Simulation steps in seconds; the physics steps of the first are 2 ms, that of the second is 1 ms."""

FIXED = 2.0
"""Bare physics steps that the fixed part may cost: 60 us where one takes 30 us."""

EACH = 0.1
"""Bare physics steps that each further one may cost in addition: 3 us where one takes 30 us."""

ARM = 2.0
"""Times bare mj_step, that a step of 1 ms of the small arm may take: half of the rate."""


def measure(effort: Effort) -> Findings:
    """In process, running from its start, beside the same `mj_step` calls."""
    taken = repeated(max(1, effort.sets // 2), partial(_one_set, effort))
    steps = {scene: Physics.count(scene, LONG) for scene in (TUTORIAL, SMALL)}
    found = Findings("A lean simulation step", topic="Simulation step")
    bare = taken[_bare(TUTORIAL, SHORT)]
    short = difference(taken[_step(TUTORIAL, SHORT)], bare)
    long = difference(taken[_step(TUTORIAL, LONG)], taken[_bare(TUTORIAL, LONG)])
    further = difference(long, short)
    each = Rounds(tuple((value / (steps[TUTORIAL] - 1),) for (value,) in further.values))
    found.ratios = [
        Ratio(
            f"{TUTORIAL}: fixed part of a simulation step / bare mj_step", ratio(short, bare), target=FIXED
        ),
        Ratio(
            f"{TUTORIAL}: what each further physics step costs more / bare mj_step",
            ratio(each, bare),
            target=EACH,
        ),
        Ratio(
            f"{SMALL}: a simulation step of 1 ms / bare mj_step",
            ratio(taken[_step(SMALL, SHORT)], taken[_bare(SMALL, SHORT)]),
            target=ARM,
        ),
        Ratio(
            f"{TUTORIAL}: a simulation step of 50 ms / the same mj_step calls",
            ratio(taken[_step(TUTORIAL, LONG)], taken[_bare(TUTORIAL, LONG)]),
        ),
    ]
    found.rows = [Row.of(what, rounds, "us") for what, rounds in taken.items()]
    found.rows += [
        Row.of(f"{TUTORIAL}: fixed part", short, "us"),
        Row.of(f"{TUTORIAL}: beyond mj_step for each further physics step", each, "us"),
    ]
    return found


def _step(scene: str, seconds: float) -> str:
    return f"{scene}: a simulation step of {seconds * 1000:g} ms"


def _bare(scene: str, seconds: float) -> str:
    return f"{scene}: mj_step for {seconds * 1000:g} ms"


def _one_set(effort: Effort, stack: ExitStack) -> dict[str, Rounds]:
    cases = {}
    for scene in (TUTORIAL, SMALL):
        for seconds in (LONG, SHORT):
            physics = Physics(stack, seconds, scene)
            cases[_step(scene, seconds)] = physics.simulation.step
            slow = Physics(stack, seconds, scene, in_python=True)
            cases[f"{_step(scene, seconds)}, physics in Python"] = slow.simulation.step
            cases[_bare(scene, seconds)] = physics.step
    return side_by_side("step", cases, rounds=2 * effort.rounds, calls=effort.count(150))
