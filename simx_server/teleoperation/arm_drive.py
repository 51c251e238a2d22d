"""Move the tip of an arm once in each simulation step, as an operator wants it, until the operator is silent.

The tip's target moves at a limited velocity. Damped inverse kinematics brings the joints to it, starting from their
commanded values, so that an arm that its load bends does not sink. Only calls and simulation steps count, no clock: a
replay moves the arm in the same way.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from simx_client.protocol.add_ons.teleoperation import HELD, SPEED, TURN
from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import CommandError
from simx_server.kinematics.scratch import Array, Scratch
from simx_server.kinematics.solver import Calculation, Method, Solver
from simx_server.scene.poses.poses import (
    Pose,
    Quaternion,
    about,
    add,
    conjugate,
    multiply,
    normalised,
    rotation_vector,
    scale,
    subtract,
)
from simx_server.simulation.part import Part

from .arms import BY_VELOCITY, Arm, arm_of, command, commanded, find_tip

if TYPE_CHECKING:
    from simx_server.kinematics import IkGroups
    from simx_server.simulation.simulation import Simulation

_HOW = Calculation(Method.DAMPED_LEAST_SQUARES, 0.05, 20)

_JOINT_SPEED = (math.pi / 2, SPEED)
"""Greatest velocity of a hinge and of a slide, rad/s and m/s."""

_LEASH = (0.02, math.radians(5))
"""Metres and radians that the target is ahead of the joints at most: beyond their reach it waits for them."""

Twist = tuple[float, float, float, float, float, float]
"""Velocity of a tip along and about the axes of the world: m/s, rad/s."""

STILL: Twist = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class _Wish:
    """A velocity, or a pose to reach."""

    tip: int
    twist: Twist = STILL
    pose: Pose | None = None


class ArmDrive(Part):
    """The arm that is driven now, if any. Physics thread only."""

    def __init__(self, sim: Simulation, groups: IkGroups) -> None:
        """Drive no arm yet."""
        self._sim, self._groups = sim, groups
        self._scratch = Scratch(sim)
        self._found: tuple[object, dict[str, int]] = None, {}
        """The model, and the tips that were found in it, by the names that were asked for."""

        self._wish: _Wish | None = None
        self._steps_left = 0
        self._target: Pose | None = None
        self.twist = STILL
        """Velocity of the target in the last simulation step."""

        self.problem = ""
        """Why the last wish could not be carried out; else empty."""

    @property
    def has_work(self) -> bool:
        """Return whether an arm is driven."""
        return self._wish is not None

    def tip(self, name: str) -> int:
        """Return the tip of an arm by name; empty: of the arm that is driven, or the first one. Raises CommandError."""
        if not name and self._wish is not None:
            return self._wish.tip
        model = self._sim.model
        if self._found[0] is not model:
            self._found = model, {}
        tips = self._found[1]
        if name not in tips:
            tips[name] = find_tip(self._sim, self._groups, name)
        return tips[name]

    def drive(self, name: str, twist: Twist) -> None:
        """Have the tip of an arm move at a velocity. Raises CommandError: no such arm, or a number is not finite."""
        self._start(_Wish(self.tip(name), _limited(_finite(twist))))

    def reach(self, name: str, pose: Pose) -> None:
        """Have the tip of an arm move to a pose in the world. Raises CommandError."""
        _finite((*pose[0], *pose[1]))
        self._start(_Wish(self.tip(name), pose=(pose[0], normalised(pose[1]))))

    def release(self) -> None:
        """Let the arm stand still."""
        wish = self._end()
        if wish is None or wish.tip not in self._sim.scene.objects:
            return
        for joint in arm_of(self._sim, wish.tip).joints.handles:
            if self._sim.joints.rule(joint) in BY_VELOCITY:
                self._sim.joints.set_target_velocity(joint, 0.0)

    def move(self) -> None:
        """Set the joints for the coming simulation step."""
        wish = self._wish
        if wish is None or not self._steps_left:
            self.release()
            return
        self._steps_left -= 1
        try:
            self._move(arm_of(self._sim, wish.tip), wish)
            self.problem = ""
        except CommandError as problem:
            self.problem = str(problem)
            self._end()

    def tip_pose(self, arm: Arm) -> Pose:
        """Return the world pose at which the tip of an arm is told to be."""
        return self._target or self._solver(arm).tips(self._values(arm))[0]

    def run_started(self) -> None:
        self._forget()

    def run_stopped(self) -> None:
        self._forget()

    def scene_changed(self) -> None:
        self._forget()

    def _forget(self) -> None:
        self._end()
        self.problem = ""

    def _end(self) -> _Wish | None:
        """End the wish, and return it."""
        wish, self._wish, self._target, self.twist = self._wish, None, None, STILL
        if wish is not None:
            self._sim.parts.replan()
        return wish

    def _start(self, wish: _Wish) -> None:
        if self._wish is None or self._wish.tip != wish.tip:
            self.release()
        self._wish = wish
        self._steps_left = max(1, math.ceil(HELD / self._sim.time_step - 1e-9))
        self._sim.parts.replan()

    def _solver(self, arm: Arm) -> Solver:
        self._scratch.load()
        return Solver(self._scratch, arm.joints, arm.chain)

    def _values(self, arm: Arm) -> Array:
        return np.array([commanded(self._sim, joint) for joint in arm.joints.handles])

    def _move(self, arm: Arm, wish: _Wish) -> None:
        self._sim.refresh()
        seconds = self._sim.time_step
        solver, before = self._solver(arm), self._values(arm)
        present = solver.tips(before)[0]
        start = present if self._target is None else self._leashed(self._target, present)
        twist = wish.twist if wish.pose is None else _limited(_towards(start, wish.pose, seconds))
        self._target = target = _moved(start, twist, seconds)
        self.twist = twist
        values = solver.solve(before, [target], _HOW).values
        most = np.where(arm.joints.is_hinge[: len(values)], *_JOINT_SPEED) * seconds
        way = values - before
        share = min(1.0, *(most / np.maximum(np.abs(way), 1e-12)).tolist())
        for joint, value in zip(arm.joints.handles, (before + share * way).tolist(), strict=True):
            command(self._sim, joint, value)

    def _leashed(self, target: Pose, present: Pose) -> Pose:
        """Return the target, or where the joints are if they cannot follow it."""
        turn = rotation_vector(multiply(target[1], conjugate(present[1])))
        is_near = math.hypot(*subtract(target[0], present[0])) < _LEASH[0]
        return target if is_near and math.hypot(*turn) < _LEASH[1] else present


def _finite(numbers: tuple[float, ...]) -> Twist:
    if not all(map(math.isfinite, numbers)):
        raise CommandError("a velocity or pose has numbers that are not finite")
    return numbers  # pyright: ignore[reportReturnType]


def _limited(twist: Twist) -> Twist:
    """Return a velocity that is not greater than an arm may have."""
    slow = [
        min(1.0, most / max(math.hypot(*part), most))
        for part, most in ((twist[:3], SPEED), (twist[3:], TURN))
    ]
    return (*scale(twist[:3], slow[0]), *scale(twist[3:], slow[1]))


def _towards(start: Pose, goal: Pose, seconds: float) -> Twist:
    """Return the velocity that leads to a pose within a time."""
    turn = rotation_vector(multiply(goal[1], conjugate(start[1])))
    return (*scale(subtract(goal[0], start[0]), 1 / seconds), *scale(turn, 1 / seconds))


def _moved(start: Pose, twist: Twist, seconds: float) -> Pose:
    turn = scale(twist[3:], seconds)
    angle = math.hypot(*turn)
    rotation: Quaternion = about(scale(turn, 1 / angle), angle) if angle > 1e-12 else (1.0, 0.0, 0.0, 0.0)
    return add(start[0], scale(twist[:3], seconds)), normalised(multiply(rotation, start[1]))
