"""A goal that is reached where an object of the robot is at another one, measured on a scratch state."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import mujoco

from simx_server.kinematics.chain import fixed_pose
from simx_server.kinematics.scratch import Array, copy_positions
from simx_server.scene.poses.placing import carrier_body
from simx_server.scene.poses.poses import Pose, compose, inverse
from simx_server.simulation.sleepers import kinematics

from .regions import Reached
from .states import DummyGoal

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation


def at_dummy(
    sim: Simulation,
    goal: DummyGoal,
    model: mujoco.MjModel,
    write: Callable[[mujoco.MjData, Array], None],
) -> Reached:
    """Return the function that knows the goal.

    Args:
        sim: the simulation; everything but the robot is where it is now.
        goal: the objects and the measure.
        model: the model that `write` may change.
        write: puts the robot into a state (n,), without kinematics.
    """
    data = mujoco.MjData(model)
    copy_positions(sim.data, data)
    handles = (goal.robot, goal.target, *([] if goal.reference == -1 else [goal.reference]))
    carried = [(carrier_body(sim, item), fixed_pose(sim, item)) for item in map(sim.scene.get, handles)]

    def reached(state: Array) -> tuple[bool, float]:
        write(data, state)
        kinematics(model, data)
        robot, target, *reference = (compose(_of_body(data, body), fixed) for body, fixed in carried)
        if reference:
            robot, target = (compose(inverse(reference[0]), pose) for pose in (robot, target))
        gap = compose(inverse(robot), target)
        angle = 2 * math.acos(min(1.0, abs(gap[1][0])))
        changes = [*(b - a for a, b in zip(robot[0], target[0], strict=True)), angle]
        distance = math.hypot(*(factor * each for factor, each in zip(goal.metric, changes, strict=True)))
        return distance <= goal.tolerance, distance

    return reached


def _of_body(data: mujoco.MjData, body: int) -> Pose:
    x, y, z = map(float, data.xpos[body])
    w, i, j, k = map(float, data.xquat[body])
    return (x, y, z), (w, i, j, k)
