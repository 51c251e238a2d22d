"""Cars with steered front wheels: a straight drive, and a turn beside the point where the wheels' axes meet."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from bench.motion.models import build_model, read_model
from bench.motion.opened import Array, Running

STRAIGHT, TURN = 20.0, 10.0
"""Seconds of the straight drive and of the turn that is measured."""
_SETTLE = 3.0
"""Seconds in which a car comes to rest, or reaches a new velocity."""


@dataclass(frozen=True)
class Car:
    """A car model: its wheels' joints, and how a driver steers and drives it."""

    front: tuple[str, str]
    rear: tuple[str, str]
    """Names of the joints about which the wheels turn, left and right."""
    drives: Mapping[str, float]
    """Velocities of its motors for the straight drive and the turn, rad/s."""
    steer: float
    """Angle of a wheel in the middle of the front axle in the turn, to the left, rad."""
    steers: Callable[[float], Mapping[str, float]]
    """Return the positions of the steering motors for such an angle, rad."""


@dataclass(frozen=True)
class CarDrive:
    """How a car moves."""

    speed: float
    """Speed of the straight drive, as a part of what the rear wheels' velocities and radius give."""
    side: float
    """How far it ends beside its line, as a part of its way."""
    yaw: float
    """How far it has turned on that way, rad."""
    radius: float
    """Radius of the turn of the rear axle's middle, m."""
    geometry: float
    """The same by the wheels' axes, m: where those of the front wheels meet that of the rear ones."""
    share: float


def drive(file: Path, car: Car) -> CarDrive:
    """Let a car stand on an endless floor, drive straight and turn to the left."""
    spec = read_model(file, scripted=False)
    _add_floor(spec)
    one = Running(build_model(spec, file))
    one.world.simulation.start()
    _steer(one, car, 0.0)
    one.step(_steps(one, _SETTLE))
    _set(one, car.drives, one.world.simulation.joints.set_target_velocity)
    one.step(_steps(one, _SETTLE))
    speed, side, yaw = _straight(one, car)
    _steer(one, car, car.steer)
    one.step(_steps(one, _SETTLE))
    radius, geometry = _turn(one, car)
    one.world.simulation.stop()
    return CarDrive(speed, side, yaw, radius, geometry, one.share)


def _add_floor(spec: Any) -> None:
    spec.worldbody.add_geom(
        name="floor",
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=[0, 0, 1],
        friction=(1.0, 0.005, 0.0001),
        solref=(0.005, 1.0),
    )


def _straight(one: Running, car: Car) -> tuple[float, float, float]:
    start, axle = _axle(one, car.rear)
    wheels = [one.handle(name) for name in car.rear]
    radius = start[2]
    velocities: list[float] = []
    for _ in range(_steps(one, STRAIGHT)):
        one.step(1)
        velocities += [abs(one.world.simulation.joints.velocity(wheel)) for wheel in wheels]
    end, final = _axle(one, car.rear)
    way = end - start
    length = float(np.linalg.norm(way))
    speed = length / (radius * float(np.mean(velocities)) * STRAIGHT)
    return speed, abs(float(way @ axle)) / length, abs(_angle(axle, final))


def _turn(one: Running, car: Car) -> tuple[float, float]:
    way = turned = 0.0
    centres: list[float] = []
    for _ in range(_steps(one, TURN)):
        before, axle = _axle(one, car.rear)
        one.step(1)
        after, final = _axle(one, car.rear)
        way += float(np.linalg.norm((after - before)[:2]))
        turned += _angle(axle, final)
        centres.append(_centre(one, car))
    return way / abs(turned), float(np.mean(centres))


def _centre(one: Running, car: Car) -> float:
    """Return how far left of the rear axle's middle the front wheels' axes meet the rear one, in the mean, m."""
    middle, axle = _axle(one, car.rear)
    ahead = np.array([-axle[1], axle[0], 0.0])
    found: list[float] = []
    for name in car.front:
        joint = one.model.joint(name).id
        place, axis = one.data.xanchor[joint] - middle, one.data.xaxis[joint]
        found.append(-float(place @ axle - (place @ ahead) / (axis @ ahead) * (axis @ axle)))
    return float(np.mean(found))


def _axle(one: Running, joints: tuple[str, str]) -> tuple[Array, Array]:
    """Return the middle between two wheels, and the direction from the left to the right one, level."""
    one.world.simulation.refresh()
    left, right = (one.data.xanchor[one.model.joint(name).id] for name in joints)
    across = (right - left) * (1.0, 1.0, 0.0)
    return (left + right) / 2, across / np.linalg.norm(across)


def _angle(first: Array, second: Array) -> float:
    return math.remainder(math.atan2(second[1], second[0]) - math.atan2(first[1], first[0]), 2 * math.pi)


def _steer(one: Running, car: Car, angle: float) -> None:
    _set(one, car.steers(angle), one.world.simulation.joints.set_target_position)


def _set(one: Running, values: Mapping[str, float], command: Callable[[int, float], object]) -> None:
    for name, value in values.items():
        command(one.handle(name), value)


def _steps(one: Running, seconds: float) -> int:
    return round(seconds / one.world.simulation.time_step)


def _naked(angle: float) -> dict[str, float]:
    """Return the angles of both wheels of the car without a body, whose axes meet that of the rear ones."""
    base, half = 2.5772, 0.755
    turn = math.tan(angle) / base
    left, right = (math.atan(base * turn / (1.0 + side * half * turn)) for side in (-1, 1))
    return {"nakedCar_steeringLeft": left, "nakedCar_steeringRight": right}


CARS = {
    "simple Ackermann steering": Car(
        ("nakedCar_motorLeft", "nakedCar_motorRight"),
        ("nakedCar_freeAxisLeft", "nakedCar_freeAxisRight"),
        {"nakedCar_motorLeft": 3.0, "nakedCar_motorRight": 3.0},
        0.4,
        _naked,
    ),
    "manta with differential": Car(
        ("fl_brake_joint", "fr_brake_joint"),
        ("bl_brake_joint", "br_brake_joint"),
        {"motor_joint": 6.0},
        0.4,
        lambda angle: {"steer_joint": angle},
    ),
}
"""By the name of the file, without its suffix; the shipped ones have underscores for the spaces."""
