"""Joint commands. The package `joints` explains the physical meaning of the settings."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_server.service.calls.registry import handler

if TYPE_CHECKING:
    from simx_server.world.world import World


@handler("simxGetJointPosition")
def get_joint_position(world: World, joint: int) -> float:
    """Return code 8 for spherical joints."""
    return world.simulation.joints.position(joint)


@handler("simxSetJointPosition")
def set_joint_position(world: World, joint: int, position: float) -> None:
    """Move the joint at once; a controller drives it back. A dependent joint follows its master instead.

    Differs: a joint on a tendon in force mode cannot be set (code 8); give it a target.
    """
    world.simulation.joints.set_position(joint, position)


@handler("simxGetJointMatrix")
def get_joint_matrix(world: World, joint: int) -> list[float]:
    """Accept spherical joints too; the 12 numbers are the rotation or translation of the joint value."""
    return world.simulation.joints.matrix(joint)


@handler("simxSetSphericalJointMatrix")
def set_spherical_joint_matrix(world: World, joint: int, matrix: list[float]) -> None:
    """Ignore the translation; return code 8 for other joints."""
    world.simulation.joints.set_spherical_matrix(joint, matrix)


@handler("simxSetJointTargetVelocity")
def set_joint_target_velocity(world: World, joint: int, velocity: float) -> None:
    """Accept every mode; the value moves the joint in force mode with the control loop off, and in motion mode.

    Differs: a joint without annotation is switched to velocity control; V-REP's files define how joints are driven.
    """
    world.simulation.joints.set_target_velocity(joint, velocity)


@handler("simxSetJointTargetPosition")
def set_joint_target_position(world: World, joint: int, position: float) -> None:
    """Return code 8 outside force mode and hybrid operation.

    Differs: a joint without annotation is switched to position control, and its motor on.
    """
    world.simulation.joints.set_target_position(joint, position)


@handler("simxGetJointForce")
def get_joint_force(world: World, joint: int) -> float:
    """Use V-REP's sign: the reverse of the force on the child along +z. The value is 0 also without motor and spring.

    Differs: in a scene without position controllers the first call of a run returns the value of the last physics step.
    """
    return world.simulation.joints.force(joint)


@handler("simxGetJointMaxForce")
def get_joint_max_force(world: World, joint: int) -> float:
    """Return 1e9 for a joint without a limit."""
    return world.simulation.joints.max_force(joint)


@handler("simxSetJointForce")
def set_joint_force(world: World, joint: int, force: float) -> None:
    """Use the magnitude, also of a negative number; the target velocity gives the direction."""
    joints = world.simulation.joints
    joints.set_target_force(joint, -abs(force) if joints.target_velocity(joint) < 0 else abs(force))
