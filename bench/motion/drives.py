"""Robots on wheels: straight, turning, and sideways, beside what the wheels' velocities and places give."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from bench.motion.opened import Array, Running, running

STRAIGHT = 30.0
"""Seconds of a straight drive."""
_SPEED = 0.1
"""m/s."""


@dataclass(frozen=True)
class Differential:
    """A base with a driven wheel on either side."""

    model: str
    """A shipped model."""
    left: str
    right: str


@dataclass(frozen=True)
class Drive:
    """How a differential base moves."""

    speed: float
    """Speed of the straight drive, as a part of what the wheels give."""
    side: float
    """How far it ends beside its line, m."""
    yaw: float
    """How far it has turned, rad."""
    turning: float
    """Yaw rate with different wheel velocities, as a part of what they give: the one farthest from 1."""
    wheels: float
    """Greatest difference of a wheel's velocity from its command, as a part of it."""
    share: float


def differential(robot: Differential) -> Drive:
    """Drive straight for 30 s, then turn in three ways."""
    with running("", robot.model) as one:
        handles = [one.handle(robot.left), one.handle(robot.right)]
        step = one.world.simulation.time_step
        radius = float(one.model.geom_size[_tyre(one, robot.left)].max())
        track = float(np.linalg.norm(_axle(one, robot)[1]))
        command = _SPEED / radius
        _command(one, handles, (command, command))
        one.step(_steps(one, 2.0))
        wrong: list[float] = []
        start, axle = _axle(one, robot)
        for _ in range(_steps(one, STRAIGHT)):
            one.step(1)
            wrong += [abs(one.world.simulation.joints.velocity(h) / command - 1) for h in handles]
        end, final = _axle(one, robot)
        way = end - start
        side = float(way @ axle) / track
        turning = 1.0
        for part in (0.9, 0.5, -1.0):
            _command(one, handles, (command, command * part))
            one.step(_steps(one, 2.0))
            rates: list[float] = []
            for _ in range(_steps(one, 3.0)):
                before = _axle(one, robot)[1]
                one.step(1)
                rates.append(abs(_angle(before, _axle(one, robot)[1])) / step)
            found = float(np.mean(rates)) / (abs(1 - part) * command * radius / track)
            turning = found if abs(found - 1) > abs(turning - 1) else turning
        return Drive(
            speed=float(np.linalg.norm(way)) / (_SPEED * STRAIGHT),
            side=abs(side),
            yaw=abs(_angle(axle, final)),
            turning=turning,
            wheels=float(np.max(wrong)),
            share=one.share,
        )


def _axle(one: Running, robot: Differential) -> tuple[Array, Array]:
    """Return the middle between the wheels, and the way from the left to the right one, in the x-y plane."""
    one.world.simulation.refresh()
    left, right = (one.data.geom_xpos[_tyre(one, name)][:2] for name in (robot.left, robot.right))
    return (left + right) / 2, right - left


def _angle(first: Array, second: Array) -> float:
    return math.remainder(math.atan2(second[1], second[0]) - math.atan2(first[1], first[0]), 2 * math.pi)


def _tyre(one: Running, joint: str) -> int:
    """Return the geom with which the wheel on a joint touches the floor."""
    body = int(one.model.jnt_bodyid[one.model.joint(joint).id])
    bodies = [
        each for each in range(one.model.nbody) if each == body or one.model.body_parentid[each] == body
    ]
    collides = (one.model.geom_contype | one.model.geom_conaffinity) != 0
    return int(np.flatnonzero(collides & np.isin(one.model.geom_bodyid, bodies))[0])


@dataclass(frozen=True)
class Mecanum:
    """How the youBot's base moves, for its commands ahead, sideways, turning and combined."""

    error: float
    """Greatest difference of a velocity from the kinematics, as a part of the greatest commanded one."""
    jump: float
    """Greatest change of the velocity from one simulation step to the next, m/s."""
    share: float


def mecanum() -> Mecanum:
    """Drive the youBot ahead, sideways, about itself and combined, by wheel velocities of 2 rad/s."""
    error = jump = 0.0
    with running("", "kuka_youbot") as one:
        wheels = [one.handle(f"rollingJoint_{name}") for name in ("fl", "rl", "rr", "fr")]
        base = one.world.simulation.scene.get(one.handle("youBot")).body
        for ahead, side, turn in ((2, 0, 0), (0, 2, 0), (0, 0, 2), (2, 2, 0), (2, 0, 1), (-1, 2, 1)):
            signs = ((-1, -1, -1), (-1, 1, -1), (-1, -1, 1), (-1, 1, 1))
            speeds = [float(np.dot(sign, (ahead, side, turn))) for sign in signs]
            _command(one, wheels, speeds)
            one.step(_steps(one, 1.5))
            wanted = np.array([0.05 * ahead, 0.05 * side, -0.05 * turn / (0.228 + 0.1585) * 0.3])
            found: list[Array] = []
            for _ in range(_steps(one, 2.0)):
                before, heading = _place(one, base)
                one.step(1)
                after, final = _place(one, base)
                step = one.world.simulation.time_step
                across = np.array([math.sin(heading), -math.cos(heading)])
                along = np.array([math.cos(heading), math.sin(heading)])
                way = (after - before) / step
                rate = math.remainder(final - heading, 2 * math.pi) / step
                found.append(np.array([way @ along, way @ across, 0.3 * rate]))
            jump = max(jump, float(np.abs(np.diff(found, axis=0)).max()))
            error = max(error, float(np.abs(np.mean(found, axis=0) - wanted).max() / np.abs(wanted).max()))
        return Mecanum(error, jump, one.share)


def _place(one: Running, body: int) -> tuple[Array, float]:
    """Return the youBot's place on the floor and its heading: its body's z axis points ahead."""
    axis = one.data.xmat[body].reshape(3, 3)[:, 2]
    return one.data.xpos[body][:2].copy(), float(np.arctan2(axis[1], axis[0]))


def _command(one: Running, handles: list[int], speeds: list[float] | tuple[float, ...]) -> None:
    for handle, speed in zip(handles, speeds, strict=True):
        one.world.simulation.joints.set_target_velocity(handle, float(speed))


def _steps(one: Running, seconds: float) -> int:
    return round(seconds / one.world.simulation.time_step)
