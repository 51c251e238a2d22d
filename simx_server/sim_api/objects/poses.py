"""Poses and velocities of objects.

A handle may carry flags: `sim.handleflag_reljointbaseframe` (a reference joint's fixed frame) and
`sim.handleflag_wxyzquat` (quaternions w, x, y, z). Values of relative to: -1 or sim.handle_world for the world,
sim.handle_parent for the parent, sim.handle_self for the script's object, else an object. Setters take V-REP's order
(object, relative to, value) and CoppeliaSim's later one (object, value, relative to; the world by default).
"""

from __future__ import annotations

from types import MappingProxyType

from simx_server.errors import CommandError
from simx_server.handlers.objects import poses as handlers
from simx_server.scene.objects import ObjectKind
from simx_server.scene.poses import frames, poses
from simx_server.scene.poses.poses import Pose
from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.effects import no_edit, reads
from simx_server.sim_api.values.matrices import as_numbers, as_pose

_WXYZ = 0x1000000
"""`sim_handleflag_wxyzquat` of later versions; in V-REP 3 it was one with the flag for a joint's fixed frame."""

_INVERSE = -14
"""`sim_handle_inverse`: in place of a reference, the world seen from the object."""


class PoseFunctions(ApiPart, effect="changes"):
    """Functions for poses: metres, Euler angles in radians, quaternions (x, y, z, w), matrices of 12 numbers."""

    CONSTANTS = MappingProxyType(
        {
            "handleflag_wxyzquaternion": 0x400000,
        }
    )

    @reads
    def getObjectPosition(self, handle: int, relative_to: int = -1) -> list[float]:
        return handlers.get_object_position(self._world, *self._both(handle, relative_to))

    @no_edit
    def setObjectPosition(
        self, handle: int, relative_to: int | list[float], position: list[float] | int = -1
    ) -> int:
        value, reference = _ordered(relative_to, position, "a position")
        handlers.set_object_position(self._world, *self._both(handle, reference), value)
        return 1

    @reads
    def getObjectOrientation(self, handle: int, relative_to: int = -1) -> list[float]:
        """Return Euler angles."""
        return handlers.get_object_orientation(self._world, *self._both(handle, relative_to))

    @no_edit
    def setObjectOrientation(
        self, handle: int, relative_to: int | list[float], euler: list[float] | int = -1
    ) -> int:
        value, reference = _ordered(relative_to, euler, "Euler angles")
        handlers.set_object_orientation(self._world, *self._both(handle, reference), value)
        return 1

    @reads
    def getObjectQuaternion(self, handle: int, relative_to: int = -1) -> list[float]:
        quat = handlers.get_object_quaternion(self._world, *self._both(handle, relative_to))
        return _w_first(quat) if _is_w_first(handle) else quat

    @no_edit
    def setObjectQuaternion(
        self, handle: int, relative_to: int | list[float], quaternion: list[float] | int = -1
    ) -> int:
        value, reference = _ordered(relative_to, quaternion, "a quaternion")
        if _is_w_first(handle):
            value = _w_last(value)
        handlers.set_object_quaternion(self._world, *self._both(handle, reference), value)
        return 1

    @reads
    def getObjectPose(self, handle: int, relative_to: int = -1) -> list[float]:
        """Return x, y, z, then the quaternion."""
        numbers = as_numbers(self._pose(handle, relative_to))
        return [*numbers[:3], *_w_first(numbers[3:])] if _is_w_first(handle) else numbers

    @no_edit
    def setObjectPose(self, handle: int, relative_to: int | list[float], pose: list[float] | int = -1) -> int:
        value, reference = _ordered(relative_to, pose, "a pose")
        if _is_w_first(handle):
            value = [*value[:3], *_w_last(value[3:])]
        handlers.set_object_pose(self._world, *self._both(handle, reference), as_pose(value))
        return 1

    @reads
    def getObjectMatrix(self, handle: int, relative_to: int = -1) -> list[float]:
        return frames.matrix12(self._pose(handle, relative_to))

    @no_edit
    def setObjectMatrix(
        self, handle: int, relative_to: int | list[float], matrix: list[float] | int = -1
    ) -> int:
        value, reference = _ordered(relative_to, matrix, "a matrix")
        pose = frames.pose_from_matrix12(value)
        handlers.set_object_pose(self._world, *self._both(handle, reference), pose)
        return 1

    @reads
    def getObjectVelocity(self, handle: int) -> tuple[list[float], list[float]]:
        """Return linear (m/s) and angular (rad/s) velocity over the last simulation step along world axes: Euler
        rates, or with sim.handleflag_axis added to the handle the angular velocity of physics.
        """
        return handlers.get_object_velocity(self._world, self._self(handle))

    @reads
    def getVelocity(self, shape: int) -> tuple[list[float], list[float]]:
        """Return the velocity of the centre of mass (m/s) and the angular one (rad/s) of physics, in world axes.

        They are those at the end of the last step. Of a static shape they are the mean over that step.
        """
        return handlers.get_velocity(self._world, self._self(shape))

    def resetDynamicObject(self, handle: int) -> int:
        """Set the velocity of the object and all below it to 0, only during a run; sim.handle_all means all objects.

        Static shapes of them that are moved before the next simulation step are put there, and drag nothing.
        """
        handles = self._sim.scene.children(-1) if handle == -2 else [self._self(handle)]
        for each in handles:
            handlers.reset_dynamic_object(self._world, each)
        return 1

    def _plain(self, handle: int) -> int:
        """Return the handle without the flag for the order of a quaternion's numbers."""
        return self._self(handle & ~_WXYZ if _is_w_first(handle) else handle)

    def _both(self, handle: int, relative_to: int) -> tuple[int, int]:
        """Return the handle, with the flag for a joint's fixed frame where the script means that, and the reference."""
        plain, reference = self._plain(handle), self._self(relative_to)
        if self._script.joint_bases and plain > 0:
            parent = (
                reference
                if reference != frames.PARENT
                else self._sim.scene.get(plain & ~frames.JOINT_BASE_FLAG).parent
            )
            item = self._sim.scene.objects.get(parent)
            if item is not None and item.kind == ObjectKind.JOINT:
                plain |= frames.JOINT_BASE_FLAG
        return plain, reference

    def _pose(self, handle: int, relative_to: int) -> Pose:
        if relative_to == _INVERSE:
            return poses.inverse(frames.get_pose(self._sim, self._plain(handle)))
        return frames.get_pose(self._sim, *self._both(handle, relative_to))


def _is_w_first(handle: int) -> bool:
    return handle > 0 and bool(handle & _WXYZ)


def _w_first(quat_xyzw: list[float]) -> list[float]:
    return [quat_xyzw[3], *quat_xyzw[:3]]


def _w_last(quat_wxyz: list[float]) -> list[float]:
    return [*quat_wxyz[1:], *quat_wxyz[:1]]


def _ordered(first: int | list[float], second: int | list[float], what: str) -> tuple[list[float], int]:
    """Return the value and the reference, which may come in either order."""
    if isinstance(first, list) and isinstance(second, int):
        return first, second
    if isinstance(first, int) and isinstance(second, list):
        return second, first
    raise CommandError(
        f"besides the handle, one argument must be {what} (a table) and one a reference (a handle)"
    )
