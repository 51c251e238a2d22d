"""A carriage that a program builds of joints and shapes: it carries a gripper across, up and down, and turns it."""

from __future__ import annotations

import numpy as np

from .grippers import Gripper
from .program import Array, Program

_REVOLUTE, _PRISMATIC, _FORCE_MODE = 10, 11, 5
_CUBOID, _CYLINDER = 0, 2
_NOT_RESPONDABLE, _STATIC, _STATIC_RESPONDABLE = 0, 16, 24
_MOTOR = 2000
"""Numbers of V-REP: joints, pure shapes, their options, and the parameter that switches a motor on."""

_STRENGTH = 1e4
"""Of the carriage's motors, N and N m."""

AXES = {
    "across": (_PRISMATIC, np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])),
    "lift": (_PRISMATIC, np.eye(3)),
    "tilt": (_REVOLUTE, np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])),
}
"""Kind of each axis, and its frame, whose z axis is its direction: x, z and y of the world."""

NARROW, LOW, PART = 0.016, 0.04, 0.6
"""Width in m of the column below things that are gripped lower than 0.04 m: fingers reach below them. The column below
others has this part of their width.
"""


class Carriage:
    """A carriage with its gripper."""

    def __init__(self, program: Program, gripper: int, place: Array) -> None:
        """Build it around a gripper.

        Args:
            gripper: handle of its base, which is where it starts.
            place: where the axis lies about which it turns, m.
        """
        self._program = program
        parent = program.call("createPureShape", _CUBOID, _STATIC, [0.02] * 3, 1.0)
        program.place(parent, place + np.array((0.0, 0.0, 0.3)))
        self.axes: dict[str, int] = {}
        for name, (kind, frame) in AXES.items():
            joint = program.call("createJoint", kind, _FORCE_MODE, 0, [0.01, 0.01])
            program.set_pose(joint, np.column_stack((frame, place)))
            program.call("setJointInterval", joint, False, [-10.0, 20.0])
            program.call("setObjectInt32Parameter", joint, _MOTOR, 1)
            program.call("setJointForce", joint, _STRENGTH)
            program.call("setObjectParent", joint, parent, True)
            carrier = program.call("createPureShape", _CUBOID, _NOT_RESPONDABLE, [0.02] * 3, 5.0)
            program.place(carrier, place + np.array((0.0, 0.0, 0.3)))
            program.call("setObjectParent", carrier, joint, True)
            parent, self.axes[name] = carrier, joint
        sensor = program.call("createForceSensor", 0, [0, 1, 0, 0, 0], [0.01, 0.0, 0.0, 0.0, 0.0])
        program.set_pose(sensor, program.pose(gripper))
        program.call("setObjectParent", sensor, parent, True)
        program.call("setObjectParent", gripper, sensor, True)

    def drive(self, places: dict[str, float], step: float) -> None:
        """Command the axes to be at these places, m and rad, after a simulation step of s."""
        for name, place in places.items():
            joint = self.axes[name]
            velocity = (place - self._program.call("getJointPosition", joint)) / step
            self._program.call("setJointTargetVelocity", joint, velocity)


def hang(program: Program, gripper: Gripper, handle: int, grip: Array) -> Carriage:
    """Hang a gripper with its fingers downwards, so that it grips at a place in the world, m."""
    turn = gripper.turned_down()
    program.set_pose(handle, np.column_stack((turn, grip - turn @ gripper.grip)))
    return Carriage(program, handle, grip)


def add_column(program: Program, height: float, width: float) -> None:
    """Add a column on the floor, m."""
    size = [width, width, height]
    column = program.call("createPureShape", _CYLINDER, _STATIC_RESPONDABLE, size, 1.0)
    program.place(column, (0.0, 0.0, height / 2))
