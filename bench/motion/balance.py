"""V-REP's ball robot: its script balances it on a ball by three omni wheels, and follows a target."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from bench.motion.opened import Running, running
from simx_server.scene.poses.frames import get_pose, set_pose
from simx_server.scene.poses.poses import rotate

STAND, FOLLOW = 10.0, 20.0
"""Seconds in which it stands, and in which it follows the target and comes to rest."""
ASIDE, SPEED = 1.0, 0.1
"""How far (m) and how fast (m/s) the target moves."""


@dataclass(frozen=True)
class Balance:
    """How the robot stood and followed."""

    standing: float
    """Greatest tilt while it stands, rad."""
    tilt: float
    """Greatest tilt while it follows, rad."""
    error: float
    """Distance of the ball from the target at the end, on the floor, m."""
    share: float


def balance(file: Path) -> Balance:
    """Let the robot stand for a while, and lead its target aside."""
    with running(str(file)) as robot:
        simulation, target = robot.world.simulation, robot.handle("BallRobot_target")
        (x, y, z), turn = get_pose(simulation, target)

        def lead(time: float) -> None:
            set_pose(simulation, target, -1, ((x + min(SPEED * time, ASIDE), y, z), turn))

        standing, tilt = _tilt(robot, STAND, lambda _: None), _tilt(robot, FOLLOW, lead)
        ball = get_pose(simulation, robot.handle("BallRobot_ball"))[0]
        return Balance(standing, tilt, math.dist(ball[:2], (x + ASIDE, y)), robot.share)


def _tilt(robot: Running, seconds: float, before: Callable[[float], None]) -> float:
    """Run, with a call of `before` (by the time since the start) before each step; return the greatest tilt in rad."""
    greatest, step = 0.0, robot.world.simulation.time_step
    for number in range(round(seconds / step)):
        before(number * step)
        robot.step(1)
        up = rotate(get_pose(robot.world.simulation, robot.handle("BallRobot"))[1], (0.0, 0.0, 1.0))
        greatest = max(greatest, math.acos(min(1.0, up[2])))
    return greatest
