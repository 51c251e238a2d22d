"""Functions of PyRep's add-on that read and change the scene: paths in space, facing, images of all directions."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from simx_server.errors import CommandError
from simx_server.scene.poses.frames import get_pose, matrix12, quat_from_euler, set_pose
from simx_server.scene.poses.poses import matrix
from simx_server.sim_api.kinematics.ik import IkFunctions
from simx_server.sim_api.paths.path_objects import PathObjectFunctions
from simx_server.sim_api.vision.composed import ComposedImageFunctions

if TYPE_CHECKING:
    from simx_server.scripting.script import Script
    from simx_server.world.world import World

_PLACES, _STATES = 20, 20
"""Places along a path that a tip goes to, and states on the way to each."""

_BEZIER_POINTS, _BEZIER_FACTOR = 20, 0.99
"""Of control points that are inserted."""

_POSE = 6
"""Numbers of a position with Euler angles."""


class SceneFunctions:
    """They call functions of `sim` and `simVision`, for a script without a text."""

    def __init__(self, world: World, script: Script) -> None:
        self._world = world
        self._sim = world.simulation
        self._ik = IkFunctions(world, script)
        self._paths = PathObjectFunctions(world, script)
        self._vision = ComposedImageFunctions(world, script)

    def follow_path(self, ints: list[int], _floats: list[float], _strings: list[str]) -> list[float]:
        """Return configurations in sequence with which the tip of an IK group follows a path, or nothing where it
        cannot: 20 on a straight line to each of 20 places, the last one at the path's end. Collisions do not count.

        Args:
            ints: path, IK group, target of the group, joints.

        Raises:
            CommandError: arguments are missing or unknown.
        """
        if len(ints) < 4:
            raise CommandError("getPathFromCartesianPath takes a path, an IK group, its target and joints")
        path, group, target, *joints = ints
        curve = self._world.paths.get(path).curve
        before = [self._sim.joints.position(handle) for handle in joints]
        rest = get_pose(self._sim, target)
        found: list[float] = []
        try:
            for number in range(1, _PLACES + 1):
                place = self._world.paths.pose_at(path, number / _PLACES * curve.length)
                set_pose(self._sim, target, -1, place)
                states = self._ik.generateIkPath(group, joints, _STATES)
                if states is None:
                    return []
                found += states
                self._place(joints, states[-len(joints) :])
        finally:
            self._place(joints, before)
            set_pose(self._sim, target, -1, rest)
        return found

    def insert_control_points(self, ints: list[int], floats: list[float], _strings: list[str]) -> list[float]:
        """Insert control points at the start of a path; return nothing.

        Args:
            ints: path, number of points.
            floats: position (m) and Euler angles (rad) of each, in the path's frame.

        Raises:
            CommandError: numbers are missing, or the object is not a path.
        """
        path, count = ints
        if count < 0 or len(floats) < count * _POSE:
            raise CommandError(f"{count} control points are {count * _POSE} numbers, not {len(floats)}")
        more = [0.0, 0.0, _BEZIER_POINTS, _BEZIER_FACTOR, _BEZIER_FACTOR]
        numbers = [
            value for at in range(0, count * _POSE, _POSE) for value in (*floats[at : at + _POSE], *more)
        ]
        self._paths.insertPathCtrlPoints(path, 0, 0, count, numbers)
        return []

    def face(self, ints: list[int], _floats: list[float], _strings: list[str]) -> list[float]:
        """Return a matrix (12 numbers) at the target, turned about the world's z axis only, and an angle in rad.

        Its x axis has the yaw of the target's axis, in either direction, that points most along the line from the
        base to the target; the angle is this yaw less a quarter turn.

        Args:
            ints: base, target.

        Raises:
            CommandError: both are at the same place.
        """
        (start, _), (end, turn) = (get_pose(self._sim, handle) for handle in ints)
        line = np.subtract(end, start)
        if not line.any():
            raise CommandError("base and target are at the same place, so there is no direction between them")
        axes = np.array(matrix(turn)).T
        along = axes @ line
        best = int(np.argmax(np.abs(along)))
        x, y, _ = axes[best] * np.sign(along[best])
        yaw = math.atan2(y, x)
        return [*matrix12((end, quat_from_euler([0.0, 0.0, yaw]))), yaw - math.pi / 2]

    def handle_spherical(self, ints: list[int], _floats: list[float], _strings: list[str]) -> list[float]:
        """Make the images of all directions of a colour and a depth sensor; return nothing.

        Args:
            ints: the depth sensor, the colour sensor; front, top, back, bottom, left and right.

        Raises:
            CommandError: the sensors do not fit together.
        """
        depth, colors, *sensors = ints
        self._vision.handleSpherical(colors, sensors, 2 * math.pi, math.pi, depth)
        return []

    def _place(self, joints: list[int], values: list[float]) -> None:
        for handle, value in zip(joints, values, strict=True):
            self._sim.joints.set_position(handle, value)
