"""Joints. What the settings mean physically is in the package `joints`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .registry import handler

if TYPE_CHECKING:
    from ..simulation import Simulation


@handler("simxGetJointPosition")
def get_joint_position(sim: Simulation, joint: int) -> float:
    return sim.joints.position(joint)


@handler("simxSetJointPosition")
def set_joint_position(sim: Simulation, joint: int, position: float) -> None:
    sim.joints.set_position(joint, position)


@handler("simxGetJointMatrix")
def get_joint_matrix(sim: Simulation, joint: int) -> list[float]:
    return sim.joints.matrix(joint)


@handler("simxSetSphericalJointMatrix")
def set_spherical_joint_matrix(sim: Simulation, joint: int, matrix: list[float]) -> None:
    sim.joints.set_spherical_matrix(joint, matrix)


@handler("simxSetJointTargetVelocity")
def set_joint_target_velocity(sim: Simulation, joint: int, velocity: float) -> None:
    sim.joints.set_target_velocity(joint, velocity)


@handler("simxSetJointTargetPosition")
def set_joint_target_position(sim: Simulation, joint: int, position: float) -> None:
    sim.joints.set_target_position(joint, position)


@handler("simxGetJointForce")
def get_joint_force(sim: Simulation, joint: int) -> float:
    return sim.joints.force(joint)


@handler("simxGetJointMaxForce")
def get_joint_max_force(sim: Simulation, joint: int) -> float:
    return sim.joints.max_force(joint)


@handler("simxSetJointForce")
def set_joint_force(sim: Simulation, joint: int, force: float) -> None:
    sim.joints.set_max_force(joint, force)
