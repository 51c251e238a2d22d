"""Joints."""

from __future__ import annotations

from ..kinds import FLOAT
from .command import Command, Effect
from .meanings import FORCE, JOINT_HANDLE, JOINT_MATRIX, JOINT_POSITION, Meaning

JOINTS = (
    Command(
        name="simxGetJointPosition",
        takes={"jointHandle": JOINT_HANDLE},
        gives={"position": JOINT_POSITION},
        doc="Return the position of a joint in radians or metres.",
        effect=Effect.READS,
        key=("jointHandle",),
        legacy_id=0x1001,
        twin="sim.getJointPosition",
    ),
    Command(
        name="simxSetJointPosition",
        takes={"jointHandle": JOINT_HANDLE, "position": JOINT_POSITION},
        doc="Set the position of a joint, within its limits.",
        effect=Effect.CHANGES,
        key=("jointHandle",),
        legacy_id=0x1002,
        twin="sim.setJointPosition",
    ),
    Command(
        name="simxGetJointMatrix",
        takes={"jointHandle": JOINT_HANDLE},
        gives={"matrix": JOINT_MATRIX},
        doc="Return the transformation that the joint's position makes, 3x4 row by row.",
        effect=Effect.READS,
        key=("jointHandle",),
        legacy_id=0x100A,
        twin="sim.getJointMatrix",
    ),
    Command(
        name="simxSetSphericalJointMatrix",
        takes={"jointHandle": JOINT_HANDLE.but(sample="ball_joint"), "matrix": JOINT_MATRIX},
        doc="Set the rotation of a ball joint, 3x4 row by row.",
        effect=Effect.CHANGES,
        key=("jointHandle",),
        legacy_id=0x100B,
        twin="sim.setSphericalJointMatrix",
    ),
    Command(
        name="simxSetJointTargetVelocity",
        takes={"jointHandle": JOINT_HANDLE, "targetVelocity": Meaning(FLOAT, "rad/s, or m/s", sample="0.5")},
        doc="Set the target velocity in rad/s or m/s, for a motor whose control loop is off.",
        effect=Effect.CHANGES,
        key=("jointHandle",),
        legacy_id=0x1008,
        twin="sim.setJointTargetVelocity",
    ),
    Command(
        name="simxSetJointTargetPosition",
        takes={"jointHandle": JOINT_HANDLE, "targetPosition": JOINT_POSITION},
        doc="Set the target position in rad or m, for a motor whose control loop is on.",
        effect=Effect.CHANGES,
        key=("jointHandle",),
        legacy_id=0x100C,
        twin="sim.setJointTargetPosition",
    ),
    Command(
        name="simxGetJointForce",
        aliases=("simxJointGetForce",),
        takes={"jointHandle": JOINT_HANDLE},
        gives={"force": FORCE},
        doc=(
            "Return the motor's force in N m or N, the mean of the last simulation step; negative while "
            "the motor pushes along +z; 0 while stopped."
        ),
        effect=Effect.READS,
        key=("jointHandle",),
        legacy_id=0x100D,
        twin="sim.getJointForce",
    ),
    Command(
        name="simxGetJointMaxForce",
        takes={"jointHandle": JOINT_HANDLE},
        gives={"force": FORCE},
        doc="Return the largest force or torque of the motor.",
        effect=Effect.READS,
        key=("jointHandle",),
        legacy_id=0x1038,
        twin="sim.getJointTargetForce",
    ),
    Command(
        name="simxSetJointForce",
        aliases=("simxSetJointMaxForce",),
        takes={"jointHandle": JOINT_HANDLE, "force": FORCE},
        doc="Set the largest force or torque of the motor.",
        effect=Effect.CHANGES,
        key=("jointHandle",),
        legacy_id=0x100E,
        twin="sim.setJointTargetForce",
    ),
)
