"""Joints: positions, targets, forces, intervals, modes, dependencies."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import ClassVar

from simx_client.protocol import constants as c
from simx_server.editing import coupling
from simx_server.errors import CommandError
from simx_server.handlers import joints
from simx_server.joints import JointMode
from simx_server.kinematics.whole_turns import alternatives
from simx_server.scene.objects import ObjectKind
from simx_server.scripting.interpreter import Constant
from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.effects import no_edit, reads

_HYBRID = 1
"""Bit 0 of the options of sim.setJointMode."""


class JointFunctions(ApiPart, effect="changes"):
    """Functions for joints: radians or metres, their rates per second, N m or N. Setters return 1, as in V-REP 3."""

    CONSTANTS: ClassVar[Mapping[str, Constant]] = {
        "jointmode_kinematic": 0,
        "jointmode_dynamic": 5,
        "jointdynctrl_free": 0,
        "jointdynctrl_force": 1,
        "jointdynctrl_velocity": 4,
        "jointdynctrl_position": 8,
        "jointdynctrl_spring": 12,
        "jointdynctrl_callback": 16,
    }

    @reads
    def getJointPosition(self, joint: int) -> float:
        """Return the position; cyclic joints in -pi..pi. A spherical joint is an error."""
        return joints.get_joint_position(self._world, self._self(joint))

    @no_edit
    def setJointPosition(self, joint: int, position: float) -> int:
        """Set the position immediately, within the limits; a controller drives it back."""
        joints.set_joint_position(self._world, self._self(joint), position)
        return 1

    @reads
    def getJointTargetPosition(self, joint: int) -> float:
        """Return the position to which the position controller drives the joint."""
        return self._sim.joints.target_position(self._self(joint))

    @no_edit
    def setJointTargetPosition(self, joint: int, position: float, motion: list[float] | None = None) -> int:
        """Set the target position. `motion`: {velocity, acceleration, jerk}, the greatest ones from now on; 0 leaves
        one as it is.

        Outside force mode a joint with a greatest acceleration moves there by a motion profile. Joints in force mode
        obey only the velocity, as position controllers do.
        """
        self._limit_motion(joint, motion or [])
        joints.set_joint_target_position(self._world, self._self(joint), position)
        return 1

    @reads
    def getJointTargetVelocity(self, joint: int) -> float:
        """Return the target velocity as last set, even if it has no effect."""
        return self._sim.joints.target_velocity(self._self(joint))

    @no_edit
    def setJointTargetVelocity(self, joint: int, velocity: float, motion: list[float] | None = None) -> int:
        """Set the target velocity. `motion`: {acceleration, jerk}, the greatest ones from now on; 0 leaves one as it
        is.

        Outside force mode a joint with a greatest acceleration reaches the velocity by a motion profile. Joints in
        force mode ignore it.
        """
        self._limit_motion(joint, [0.0, *(motion or [])])
        joints.set_joint_target_velocity(self._world, self._self(joint), velocity)
        return 1

    @reads
    def getJointVelocity(self, joint: int) -> float:
        """Return the mean velocity of the last simulation step; 0 when stopped. CoppeliaSim 4's form of V-REP's
        parameter 2012.
        """
        return self._sim.joints.velocity(self._self(joint))

    @reads
    def getJointForce(self, joint: int) -> float:
        """Return the mean force of the motor in the last simulation step; negative while it pushes towards greater
        positions.

        Before the first step it returns 0, where V-REP returned nil.
        """
        return joints.get_joint_force(self._world, self._self(joint))

    jointGetForce = getJointForce

    @no_edit
    def setJointForce(self, joint: int, force: float) -> int:
        """Set the maximum force of the motor, as a magnitude."""
        joints.set_joint_force(self._world, self._self(joint), force)
        return 1

    setJointMaxForce = setJointForce

    @no_edit
    def setJointTargetForce(self, joint: int, force: float, signed: bool = True) -> int:
        """Set the maximum force. The target velocity takes its sign, and a joint in force control pushes in that
        direction. With `signed` False only the magnitude counts, and the target velocity gives the sign.
        """
        if not signed:
            return self.setJointForce(joint, force)
        self._sim.joints.set_target_force(self._self(joint), force)
        return 1

    def _limit_motion(self, joint: int, settings: list[float]) -> None:
        if any(settings):
            self._sim.joints.limit_motion(self._self(joint), settings)

    @reads
    def getJointMaxForce(self, joint: int) -> float:
        """Return the maximum force; 1e9 for a joint without a limit."""
        return joints.get_joint_max_force(self._world, self._self(joint))

    @reads
    def getJointTargetForce(self, joint: int) -> float:
        """Return the maximum force with the sign of its direction; 1e9 for a joint without a limit."""
        return self._sim.joints.target_force(self._self(joint))

    @reads
    def getJointInterval(self, joint: int) -> tuple[bool, list[float]]:
        """Return whether the joint is cyclic, and {least value, range}."""
        cyclic, least, extent = self._sim.joints.interval(self._self(joint))
        return cyclic, [least, extent]

    def setJointInterval(self, joint: int, cyclic: bool, interval: list[float]) -> int:
        """Set the interval {least value, range}."""
        if len(interval) < 2:
            raise CommandError("a joint's interval is {least value, range}")
        self._sim.joints.set_interval(self._self(joint), cyclic, interval[0], interval[1])
        return 1

    @reads
    def getJointMode(self, joint: int) -> tuple[int, int]:
        """Return a sim.jointmode_* and the options: bit 0 when a motor drives the joint outside force mode."""
        handle = self._self(joint)
        return int(self._sim.joints.mode(handle)), _HYBRID if self._sim.joints.is_hybrid(handle) else 0

    def setJointMode(self, joint: int, mode: int, options: int = 0) -> int:
        """Set the mode, a sim.jointmode_*; bit 0 of `options`: hybrid operation."""
        handle = self._self(joint)
        if mode not in tuple(JointMode):
            known = ", ".join(f"{int(each)} {each.name.lower()}" for each in JointMode)
            raise CommandError(f"{mode} is no joint mode; those are {known}")
        self._sim.joints.set_mode(handle, JointMode(mode))
        if self._sim.joints.joint_type(handle) != _SPHERICAL:
            self._sim.joints.change(handle, hybrid=bool(options & _HYBRID))
        return 1

    @reads
    def getJointType(self, joint: int) -> int:
        """Return sim.joint_revolute_subtype, sim.joint_prismatic_subtype or sim.joint_spherical_subtype."""
        return self._sim.joints.joint_type(self._self(joint))

    @reads
    def getJointMatrix(self, joint: int) -> list[float]:
        """Return the rotation or translation of the joint value: 12 numbers, row-major 3 x 4."""
        return joints.get_joint_matrix(self._world, self._self(joint))

    def setSphericalJointMatrix(self, joint: int, matrix: list[float]) -> int:
        """Set the rotation by 12 numbers; the translation is ignored."""
        joints.set_spherical_joint_matrix(self._world, self._self(joint), matrix)
        return 1

    @reads
    def getSphericalJointMatrix(self, joint: int) -> list[float]:
        """Return the matrix as sim.getJointMatrix does, only for spherical joints."""
        handle = self._self(joint)
        if self.getJointType(handle) != _SPHERICAL:
            name = self._sim.scene.get(handle).name
            raise CommandError(f"'{name}' is no spherical joint; use sim.getJointMatrix")
        return self.getJointMatrix(handle)

    @reads
    def getAlternateConfigs(
        self,
        joints: list[int],
        values: list[float],
        tip: int = -1,
        low: list[float] | None = None,
        ranges: list[float] | None = None,
    ) -> list[float]:
        """Return the joint values that put the joints where the given ones do, in sequence: revolute joints that are
        not cyclic take each value that is whole turns away, within their intervals.

        `low`, `ranges`: other intervals; a range of 0 is the joint's own, a negative one is centred at the present
        position. `tip`: an object whose pose must stay; only joints that others follow could move it.
        """
        if len(values) != len(joints):
            raise CommandError(f"{len(joints)} joints need as many values, not {len(values)}")
        for given in (low, ranges):
            if given is not None and len(given) != len(joints):
                raise CommandError(
                    f"{len(joints)} joints need as many low limits and ranges, not {len(given)}"
                )
        intervals: list[tuple[float, float] | None] = []
        for index, joint in enumerate(map(self._self, joints)):
            cyclic, least, extent = self._sim.joints.interval(joint)
            if self.getJointType(joint) != c.sim_joint_revolute_subtype or cyclic:
                intervals.append(None)
                continue
            if low is not None and ranges is not None and ranges[index] > 0:
                least, extent = low[index], ranges[index]
            elif ranges is not None and ranges[index] < 0:
                extent = -ranges[index]
                least = self._sim.joints.position(joint) - extent / 2
            intervals.append((least, extent))
        if tip != -1:
            self._sim.scene.get(self._self(tip))
        return [
            value
            for found in alternatives(values, intervals)
            if tip == -1 or self._keeps_followers(joints, values, found)
            for value in found
        ]

    def _keeps_followers(
        self, joints: Sequence[int], values: Sequence[float], others: Sequence[float]
    ) -> bool:
        """Return whether joints that follow these are in equal places for both values."""
        turned = {
            self._self(joint): other - value
            for joint, value, other in zip(joints, values, others, strict=True)
        }
        for joint in self._sim.scene.of_kind(ObjectKind.JOINT):
            if self.getJointType(joint) == _SPHERICAL:
                continue
            state = self._sim.joints.state(joint)
            shift = turned.get(state.master, 0.0) * state.factor if joint not in turned else 0.0
            if self.getJointType(joint) == c.sim_joint_revolute_subtype:
                shift = math.remainder(shift, math.tau)
            if abs(shift) > _SAME:
                return False
        return True

    @reads
    def getJointDependency(self, joint: int) -> tuple[int, float, float]:
        """Return master (-1: none), offset and factor: position = offset + factor * master's position. Since
        CoppeliaSim 4.
        """
        state = self._sim.joints.state(self._self(joint))
        return state.master, state.shift, state.factor

    def setJointDependency(self, joint: int, master: int, offset: float = 0.0, factor: float = 1.0) -> int:
        """Set the dependency of a joint in dependent mode, through which both exchange forces; master -1 ends it. Since
        CoppeliaSim 4.
        """
        handle = self._self(joint)
        self._sim.joints.set_dependency(handle, master=self._self(master), shift=offset, factor=factor)
        if master != -1:
            coupling.couple(self._world, handle)
        return 1


_SAME = 1e-6
"""Tolerance in rad or m."""

_SPHERICAL = 12
"""`sim_joint_spherical_subtype`."""
