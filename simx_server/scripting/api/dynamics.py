"""Forces on shapes. They act during the next pass; several add up."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...handlers import shape_properties
from ...joints import JointMode
from ...scene.objects import ObjectKind
from .base import ApiPart
from .matrices import vector

if TYPE_CHECKING:
    from ...scene.poses import Vector

_RESET_FORCE, _RESET_TORQUE = 0x400000, 0x800000
_NOTHING: Vector = (0.0, 0.0, 0.0)


class DynamicsFunctions(ApiPart):
    """Newtons and newton metres. A static shape feels nothing."""

    def addForce(self, shape: int, position: list[float], force: list[float]) -> None:
        """At a point of the shape, in metres; point and force in the shape's own frame.

        sim.handleflag_resetforcetorque added to the handle: what was added before is forgotten.
        """
        handle = self._reset(shape)
        self._sim.applied_forces.add_at(handle, vector(position, "a position"), vector(force, "a force"))

    def addForceAndTorque(
        self, shape: int, force: list[float] | None = None, torque: list[float] | None = None
    ) -> None:
        """At the centre of mass, both along world axes. Flags as for addForce, also each by itself."""
        handle = self._reset(shape)
        self._sim.applied_forces.add(
            handle,
            _NOTHING if force is None else vector(force, "a force"),
            _NOTHING if torque is None else vector(torque, "a torque"),
        )

    def isDynamicallyEnabled(self, handle: int) -> bool:
        """Whether the physics moves it in this run: a dynamic shape, or a joint in force mode."""
        own = self._self(handle)
        item = self._sim.scene.get(own)
        if not (self._sim.is_running and self._sim.dynamics_enabled):
            return False
        if item.kind == ObjectKind.SHAPE:
            return not shape_properties.is_static(self._sim, own)
        if item.kind == ObjectKind.JOINT:
            return self._sim.joints.mode(own) == JointMode.FORCE or self._sim.joints.is_hybrid(own)
        return item.kind == ObjectKind.FORCE_SENSOR

    def _reset(self, shape: int) -> int:
        """The handle without flags, after doing what they say."""
        flags = shape & (_RESET_FORCE | _RESET_TORQUE) if shape > 0 else 0
        handle = self._self(shape & ~flags)
        if flags:
            self._sim.applied_forces.reset(
                handle, force=bool(flags & _RESET_FORCE), torque=bool(flags & _RESET_TORQUE)
            )
        return handle
