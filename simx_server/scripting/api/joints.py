"""Joints: positions, targets, forces."""

from __future__ import annotations

from ...handlers import joints
from .base import ApiPart


class JointFunctions(ApiPart):
    """Radians or metres, their rates per second, N m or N."""

    def getJointPosition(self, joint: int) -> float:
        return joints.get_joint_position(self._sim, self._self(joint))

    def setJointPosition(self, joint: int, position: float) -> None:
        joints.set_joint_position(self._sim, self._self(joint), position)

    def setJointTargetPosition(self, joint: int, position: float) -> None:
        joints.set_joint_target_position(self._sim, self._self(joint), position)

    def setJointTargetVelocity(self, joint: int, velocity: float) -> None:
        joints.set_joint_target_velocity(self._sim, self._self(joint), velocity)

    def getJointTargetPosition(self, joint: int) -> float:
        return self._sim.joints.target_position(self._self(joint))

    def getJointTargetVelocity(self, joint: int) -> float:
        return self._sim.joints.target_velocity(self._self(joint))

    def setJointForce(self, joint: int, force: float) -> None:
        joints.set_joint_force(self._sim, self._self(joint), force)

    def setJointMaxForce(self, joint: int, force: float) -> None:
        self.setJointForce(joint, force)

    def setJointTargetForce(self, joint: int, force: float) -> None:
        self.setJointForce(joint, force)

    def getJointForce(self, joint: int) -> float:
        return joints.get_joint_force(self._sim, self._self(joint))
