"""A tip that joints of the scene bring to its moving target: the field ik of `sim.moveToPose`."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, cast

from simx_server.errors import CommandError
from simx_server.handlers.objects import poses
from simx_server.kinematics import Calculation, Element, Result
from simx_server.kinematics.environment import Environment, EnvironmentGroup
from simx_server.scene.poses import frames
from simx_server.scene.poses.poses import Pose
from simx_server.scripting.conversion.signature import describe, to_bool, to_float, to_int, to_list
from simx_server.sim_api.motion.fields import NUMBERS, read
from simx_server.world.world import World

from .ik import as_constraints, as_pair
from .sim_ik import as_calculation, summary

_METHOD, _DAMPING, _ITERATIONS, _CONSTRAINTS = 1, 0.02, 20, 31
_PRECISION = (0.001, math.radians(0.5))
"""The values of CoppeliaSim for fields that are left out."""


class FollowingTarget:
    """Moves a target to poses, and the joints after it."""

    def __init__(self, world: World, fields: Any, own: Callable[[int], int]) -> None:
        """Prepare, and move the target to the tip.

        Args:
            world: the world of the tip.
            fields: the table: `tip` and `target`, the rest has CoppeliaSim's usual values: base, joints, method,
                damping, iterations, constraints, precision, allowError, breakFlags.
            own: replaces sim.handle_self by an object.

        Raises:
            CommandError: a field is missing or wrong, or no joint lies between base and tip.
        """
        if not isinstance(fields, dict):
            raise CommandError(f"the field ik must be a table, got {describe(fields)}")
        given = cast(dict[str, Any], fields)
        tip, target = read(given, "tip", to_int, None), read(given, "target", to_int, None)
        if tip is None or target is None:
            raise CommandError("the field ik needs tip and target, the handles of two objects")
        base = read(given, "base", to_int, -1)
        self._world = world
        self.target: int = own(target)
        self._may_miss: bool = read(given, "allowError", to_bool, False)
        self._stops_at: int = read(given, "breakFlags", to_int, 0)
        self._environment = Environment(world.simulation)
        self._group = EnvironmentGroup("ik", _calculation(given))
        element = Element(
            own(tip),
            self.target,
            base if base == -1 else own(base),
            as_constraints(read(given, "constraints", to_int, _CONSTRAINTS)),
            as_pair(read(given, "precision", NUMBERS, list(_PRECISION)), "precision"),
        )
        self.start = frames.get_pose(world.simulation, element.tip)
        self._environment.add(self._group, element)
        self._keep_only([own(each) for each in read(given, "joints", to_list(to_int), [])])
        poses.set_object_pose(world, self.target, frames.WORLD, self.start)

    def follow(self, pose: Pose) -> None:
        """Move the target to a world pose, and the joints so that the tip is there.

        Joints stay where they are if the tip does not reach the pose, unless errors are allowed.

        Raises:
            CommandError: the calculation failed for a reason that the script has named as breakFlags.
        """
        poses.set_object_pose(self._world, self.target, frames.WORLD, pose)
        self._environment.take_over([self._group])
        result, flags, _ = summary([self._environment.handle(self._group)])
        if result == Result.SUCCESS or self._may_miss:
            self._environment.give_back([self._group])
        if flags & self._stops_at:
            raise CommandError(f"the inverse kinematics failed; its flags simIK.calc_* are {flags}")

    def _keep_only(self, joints: list[int]) -> None:
        """Let only these joints move, or all of them if there are none."""
        if joints:
            self._environment.passive.update(set(self._environment.joints(self._group).handles) - set(joints))
            self._environment.joints(self._group)  # fails if none is left


def _calculation(fields: Mapping[str, Any]) -> Calculation:
    return as_calculation(
        read(fields, "method", to_int, _METHOD),
        read(fields, "damping", to_float, _DAMPING),
        read(fields, "iterations", to_int, _ITERATIONS),
    )
