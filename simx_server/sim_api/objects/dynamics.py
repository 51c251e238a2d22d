"""Forces on shapes, which act during the next simulation step and add up; inertia of shapes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from simx_server.editing import shape_properties
from simx_server.errors import CommandError
from simx_server.joints import JointMode
from simx_server.scene.geometry import inertia
from simx_server.scene.objects import ObjectKind
from simx_server.scene.poses import frames
from simx_server.scene.poses.poses import IDENTITY, NO_TURN, Pose, Vector, compose, inverse, matrix
from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.effects import reads
from simx_server.sim_api.values.matrices import vector

Array = NDArray[np.float64]

_RESET_FORCE, _RESET_TORQUE = 0x400000, 0x800000
_NOTHING: Vector = (0.0, 0.0, 0.0)


class DynamicsFunctions(ApiPart, effect="changes"):
    """Functions for dynamics: newtons, newton metres, kilograms. A force on a static shape has no effect."""

    def addForce(self, shape: int, position: list[float], force: list[float]) -> int:
        """Add a force at a point (metres) of the shape; point and force are in the shape's frame.

        sim.handleflag_resetforcetorque added to the handle deletes the forces and torques added before.
        """
        handle = self._reset(shape)
        self._world.applied_forces.add_at(handle, vector(position, "a position"), vector(force, "a force"))
        return 1

    def addForceAndTorque(
        self, shape: int, force: list[float] | None = None, torque: list[float] | None = None
    ) -> int:
        """Add a force and a torque at the centre of mass, both along world axes. Flags as for addForce, also a
        separate one for the force and one for the torque.
        """
        handle = self._reset(shape)
        self._world.applied_forces.add(
            handle,
            _NOTHING if force is None else vector(force, "a force"),
            _NOTHING if torque is None else vector(torque, "a torque"),
        )
        return 1

    @reads
    def getShapeInertia(self, shape: int) -> tuple[list[float], list[float]]:
        """Return the inertia, 9 numbers in kg m^2, about the centre of mass and along the shape's axes; and the
        centre as a matrix in the shape's frame, without rotation.
        """
        _, moments, centre = inertia.get_inertia(self._sim, self._self(shape))
        x, y, z = centre.tolist()
        return moments.ravel().tolist(), frames.matrix12(((x, y, z), NO_TURN))

    def setShapeInertia(self, shape: int, moments: list[float], frame: list[float]) -> None:
        """Set the inertia in the form of getShapeInertia; a rotation in the matrix defines the axes of the moments."""
        own = self._self(shape)
        mass, _, _ = inertia.get_inertia(self._sim, own)
        centre, turn = _split(frames.pose_from_matrix12(frame))
        inertia.set_inertia(self._sim, own, mass, turn @ _square(moments) @ turn.T, centre)

    @reads
    def getShapeMassAndInertia(
        self, shape: int, frame: list[float] | None = None
    ) -> tuple[float, list[float], list[float]]:
        """Return the mass in kg, 9 numbers of inertia about the centre of mass, and that centre, in the frame given
        as a matrix; nil: in the world frame.
        """
        own = self._self(shape)
        mass, moments, centre = inertia.get_inertia(self._sim, own)
        place, turn = self._seen_from(own, frame)
        return mass, (turn @ moments @ turn.T).ravel().tolist(), (turn @ centre + place).tolist()

    def setShapeMassAndInertia(
        self,
        shape: int,
        mass: float,
        moments: list[float],
        centre: list[float],
        frame: list[float] | None = None,
    ) -> int:
        """Set mass and inertia in the form of getShapeMassAndInertia; return 1."""
        own = self._self(shape)
        place, turn = self._seen_from(own, frame)
        local = turn.T @ (np.array(vector(centre, "a centre of mass")) - place)
        inertia.set_inertia(self._sim, own, mass, turn.T @ _square(moments) @ turn, local)
        return 1

    def computeMassAndInertia(self, shape: int, density: float) -> int:
        """Compute mass and inertia of the shape filled with this density in kg/m^3; return 1."""
        inertia.compute_inertia(self._sim, self._self(shape), density)
        return 1

    @reads
    def isDynamicallyEnabled(self, handle: int) -> bool:
        """Return whether the physics moves the object in this run: a dynamic shape, or a joint in force mode."""
        own = self._self(handle)
        item = self._sim.scene.get(own)
        if not (self._sim.is_running and self._sim.dynamics_enabled):
            return False
        if item.kind == ObjectKind.SHAPE:
            return not shape_properties.is_static(self._sim, own)
        if item.kind == ObjectKind.JOINT:
            return self._sim.joints.mode(own) == JointMode.FORCE or self._sim.joints.is_hybrid(own)
        return item.kind == ObjectKind.FORCE_SENSOR

    def _seen_from(self, shape: int, frame: list[float] | None) -> tuple[Array, Array]:
        """Return position and rotation of a shape in a frame, None for the world."""
        reference = IDENTITY if frame is None else frames.pose_from_matrix12(frame)
        return _split(compose(inverse(reference), frames.get_pose(self._sim, shape)))

    def _reset(self, shape: int) -> int:
        """Return the handle without flags after deleting the forces and torques that the flags select."""
        flags = shape & (_RESET_FORCE | _RESET_TORQUE) if shape > 0 else 0
        handle = self._self(shape & ~flags)
        if flags:
            self._world.applied_forces.reset(
                handle, force=bool(flags & _RESET_FORCE), torque=bool(flags & _RESET_TORQUE)
            )
        return handle


def _split(pose: Pose) -> tuple[Array, Array]:
    """Return (3,) position and (3, 3) rotation."""
    return np.array(pose[0]), np.array(matrix(pose[1]))


def _square(moments: list[float]) -> Array:
    if len(moments) < 9:
        raise CommandError(f"an inertia matrix is 9 numbers, not {len(moments)}")
    return np.array(moments[:9]).reshape(3, 3)
