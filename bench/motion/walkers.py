"""Robots of V-REP that walk and slither: how far they come, how high their base stays, and whether they rest."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from bench.motion.opened import Running, running
from bench.motion.rest import jitter
from simx_server.scene.poses.frames import get_pose
from simx_server.scene.poses.poses import Pose, Vector, conjugate, rotate, subtract

BASES = {
    "ACM-R5": "ACMR",
    "Asti": "Asti",
    "Marty the Robot": "Marty",
    "NAO": "NAO",
    "Snake": "snake",
    "ant hexapod": "Ant_bodyTextured",
    "hexapod": "hexa_body",
    "rollerWalker": "rwRobot",
}
"""Name of a file without its suffix to the object that is watched."""

_UP: Vector = (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Walk:
    """What the base of a robot did while its scripts ran."""

    distance: float
    """From start to end, on the floor, m."""
    way: float
    """Length of its path on the floor, m."""
    lowest: float
    highest: float
    """Heights, m."""
    tilt: float
    """Greatest angle from its attitude at the start, whatever its heading, rad."""
    shaking: float
    """Root mean square of the change of its velocity from one simulation step to the next, m/s."""
    stopped: int
    """Number of scripts that an error has stopped."""
    share: float
    """Processor time as a part of the simulated time."""


def walk(file: Path, seconds: float = 30.0, base: str | None = None) -> Walk:
    """Let a robot do what its scripts want on the default floor.

    Args:
        file: of V-REP.
        seconds: of the simulation.
        base: name of the object that is watched; None: that of `BASES`.
    """
    with running(str(file)) as robot:
        handle = robot.handle(base or BASES[file.stem])
        poses: list[Pose] = [get_pose(robot.world.simulation, handle)]
        for _ in range(round(seconds / robot.world.simulation.time_step)):
            robot.step(1)
            poses.append(get_pose(robot.world.simulation, handle))
        return _walk(robot, poses)


def rest(file: Path) -> float:
    """Return the greatest speed of any part, m/s, while the robot should stand: its scripts do not run."""
    with running(str(file)) as robot:
        simulation, scripts = robot.world.simulation, robot.world.scripts
        simulation.stop()
        for one in scripts.all():
            scripts.enable(one, enabled=False)
        simulation.start()
        return jitter(robot)


def _walk(robot: Running, poses: list[Pose]) -> Walk:
    places = [place for place, _ in poses]
    upright = rotate(conjugate(poses[0][1]), _UP)
    steps = [subtract(after, before) for before, after in pairwise(places)]
    changes = [math.hypot(*subtract(after, before)) for before, after in pairwise(steps[1:])]
    scripts = robot.world.scripts.all()
    return Walk(
        distance=math.dist(places[0][:2], places[-1][:2]),
        way=sum(math.hypot(x, y) for x, y, _ in steps),
        lowest=min(z for _, _, z in places),
        highest=max(z for _, _, z in places),
        tilt=max(math.acos(min(1.0, max(-1.0, rotate(turn, upright)[2]))) for _, turn in poses),
        shaking=math.hypot(*changes) / math.sqrt(len(changes)) / robot.world.simulation.time_step,
        stopped=sum(bool(one.problem) for one in scripts),
        share=robot.share,
    )
