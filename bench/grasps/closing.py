"""How a program opens and closes a gripper."""

from __future__ import annotations

from .grippers import Gripper
from .program import Program

_ERROR = {"ROBOTIQ_85": 1e-5}
"""Of PyRep's classes: distance within a simulation step, m or rad, from which on a joint moves; 1 mm else."""


class Fingers:
    """The motors of a gripper, commanded as `pyrep.robots.end_effectors.Gripper.actuate` does."""

    def __init__(self, program: Program, gripper: Gripper, *, keeps_closing: bool) -> None:
        """Find the joints.

        Args:
            keeps_closing: whether the motors go on closing; else they stop when no finger moves any more, as in
                PyRep.
        """
        self._program, self._gripper, self._keeps_closing = program, gripper, keeps_closing
        self._joints = [program.handle(name) for name in gripper.joints]
        self._error = _ERROR.get(gripper.base, 1e-3)
        self._velocity = 0.0
        self._is_done = True
        self._before: list[float] = []

    def open(self) -> None:
        """Open from the next step on."""
        self._velocity, self._is_done, self._before = self._gripper.speed, False, []

    def close(self) -> None:
        """Close from the next step on."""
        self._velocity, self._is_done, self._before = -self._gripper.speed, False, []

    def command(self) -> None:
        """Command the motors for a simulation step."""
        if self._keeps_closing:
            for joint in self._joints:
                self._program.call("setJointTargetVelocity", joint, self._velocity)
            return
        if self._is_done:
            return
        positions = [self._program.call("getJointPosition", joint) for joint in self._joints]
        rests = [
            bool(self._before) and abs(now - before) < self._error
            for now, before in zip(positions, self._before or positions, strict=True)
        ]
        for joint, stands in zip(self._joints, rests, strict=True):
            self._program.call("setJointTargetVelocity", joint, 0.0 if stands else self._velocity)
        self._before = positions
        self._is_done = all(rests)
