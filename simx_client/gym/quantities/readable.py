"""Quantities that an environment can observe: how each is read, and its numbers or pixels."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from simx_client.connection.calls import Calls
from simx_client.protocol import constants as c

from .names import Subject

SIGNAL, OBJECT = "signal", "object"
KINDS = {
    c.sim_object_joint_type: "joint",
    c.sim_object_visionsensor_type: "camera",
    c.sim_object_proximitysensor_type: "proximity sensor",
    c.sim_object_forcesensor_type: "force sensor",
}
"""Kinds of objects with quantities that other objects lack. Every object has those of kind ``object`` too."""

_PHYSICAL = 0x400000
"""Added to a handle: return the physical angular velocity instead of Euler rates."""

_GREY = 1
_WHITE = 255.0
_NOTHING_DETECTED = -1.0

_HAS_VALUES = 1

Value = NDArray[Any]


@dataclass(frozen=True)
class Readable:
    """A quantity of one kind of objects."""

    kind: str
    attribute: str
    meaning: str
    size: int
    """Number of values; 0: an image."""

    note: Callable[[Calls, Subject], Any]
    """Notes the calls that read it; returns their answers."""

    value: Callable[[Any], Any]
    """Returns the numbers or pixels from the answers."""

    has_frame: bool = False
    channels: int = 0
    """Colours of a pixel, for an image."""

    is_float_image: bool = False
    at_start: float | None = None
    """Value at the start of an episode if nothing was measured or set yet; None: then there always is a value."""

    rows: Callable[[Value], Value] | None = None
    """Returns the numbers of many simulations, (n, size), from all numbers of the answers, (n, ...); None: only `value`
    can do it, for each simulation.
    """


def _answer(answer: Any) -> Any:
    return answer.value


def _image(answer: Any) -> Value:
    image = np.ascontiguousarray(answer.value[1].upright())
    return image.reshape(*image.shape[:2], -1)


def _depth(answers: Any) -> Value:
    buffer, near, far = (answer.value for answer in answers)
    upright = np.asarray(buffer[1].upright(), np.float32)[..., np.newaxis]
    return np.float32(near) + upright * np.float32(far - near)


def _distance(answer: Any) -> float:
    is_detecting, point, _, _ = answer.value
    return float(np.linalg.norm(point)) if is_detecting else _NOTHING_DETECTED


def _wrench(part: int) -> Callable[[Any], Any]:
    def value(answer: Any) -> Any:
        state, *parts = answer.value
        return parts[part] if state & _HAS_VALUES else (0.0, 0.0, 0.0)

    return value


def all_numbers(rows: Value) -> Value:
    """Return the numbers of the answers, all of which count."""
    return rows


def _wrenches(part: slice) -> Callable[[Value], Value]:
    def rows(numbers: Value) -> Value:
        has_values = (numbers[:, :1].astype(int) & _HAS_VALUES) != 0
        return np.where(has_values, numbers[:, part], 0.0)

    return rows


READABLE = (
    Readable(
        "joint",
        "position",
        "joint position, rad or m",
        1,
        lambda calls, it: calls.simxGetJointPosition(it.handle),
        _answer,
        rows=all_numbers,
    ),
    Readable(
        "joint",
        "velocity",
        "joint velocity, rad/s or m/s",
        1,
        lambda calls, it: calls.simxGetObjectFloatParameter(it.handle, c.sim_jointfloatparam_velocity),
        _answer,
        rows=all_numbers,
    ),
    Readable(
        "joint",
        "force",
        "force of the motor, N or N m, with the sign of `simxGetJointForce`",
        1,
        lambda calls, it: calls.simxGetJointForce(it.handle),
        _answer,
        rows=all_numbers,
    ),
    Readable(
        OBJECT,
        "position",
        "x, y, z in m",
        3,
        lambda calls, it: calls.simxGetObjectPosition(it.handle, it.frame),
        _answer,
        has_frame=True,
        rows=all_numbers,
    ),
    Readable(
        OBJECT,
        "quaternion",
        "orientation: x, y, z, w",
        4,
        lambda calls, it: calls.simxGetObjectQuaternion(it.handle, it.frame),
        _answer,
        has_frame=True,
        rows=all_numbers,
    ),
    Readable(
        OBJECT,
        "euler_angles",
        "alpha, beta, gamma of V-REP in rad",
        3,
        lambda calls, it: calls.simxGetObjectOrientation(it.handle, it.frame),
        _answer,
        has_frame=True,
        rows=all_numbers,
    ),
    Readable(
        OBJECT,
        "velocity",
        "linear velocity in m/s along world axes",
        3,
        lambda calls, it: calls.simxGetObjectVelocity(it.handle),
        lambda answer: answer.value[0],
        rows=lambda rows: rows[:, :3],
    ),
    Readable(
        OBJECT,
        "angular_velocity",
        "angular velocity in rad/s along world axes",
        3,
        lambda calls, it: calls.simxGetObjectVelocity(it.handle | _PHYSICAL),
        lambda answer: answer.value[1],
        rows=lambda rows: rows[:, 3:],
    ),
    Readable(
        "proximity sensor",
        "distance",
        "distance of the detected point in m, -1 without a detection and before the first step",
        1,
        lambda calls, it: calls.simxReadProximitySensor(it.handle),
        _distance,
        at_start=_NOTHING_DETECTED,
    ),
    Readable(
        "force sensor",
        "force",
        "x, y, z in N in the frame of the sensor",
        3,
        lambda calls, it: calls.simxReadForceSensor(it.handle),
        _wrench(0),
        rows=_wrenches(slice(1, 4)),
    ),
    Readable(
        "force sensor",
        "torque",
        "x, y, z in N m in the frame of the sensor",
        3,
        lambda calls, it: calls.simxReadForceSensor(it.handle),
        _wrench(1),
        rows=_wrenches(slice(4, 7)),
    ),
    Readable(
        "camera",
        "brightness",
        "mean of the grey image, 0 to 1",
        1,
        lambda calls, it: calls.simxGetVisionSensorImage(it.handle, _GREY),
        lambda answer: float(answer.value[1].upright().mean()) / _WHITE,
    ),
    Readable(
        "camera",
        "rgb",
        "image: uint8, height × width × 3, top row first",
        0,
        lambda calls, it: calls.simxGetVisionSensorImage(it.handle, 0),
        _image,
        channels=3,
    ),
    Readable(
        "camera",
        "grey",
        "image: uint8, height × width × 1",
        0,
        lambda calls, it: calls.simxGetVisionSensorImage(it.handle, _GREY),
        _image,
        channels=1,
    ),
    Readable(
        "camera",
        "depth",
        "image: float32, height × width × 1, m along the viewing axis",
        0,
        lambda calls, it: (
            calls.simxGetVisionSensorDepthBuffer(it.handle),
            calls.simxGetObjectFloatParameter(it.handle, c.sim_visionfloatparam_near_clipping),
            calls.simxGetObjectFloatParameter(it.handle, c.sim_visionfloatparam_far_clipping),
        ),
        _depth,
        channels=1,
        is_float_image=True,
    ),
    Readable(
        SIGNAL,
        "float_signal",
        "float signal; 0 at the start of an episode if none is set",
        1,
        lambda calls, it: calls.simxGetFloatSignal(it.name),
        _answer,
        at_start=0.0,
    ),
    Readable(
        SIGNAL,
        "int_signal",
        "integer signal; 0 at the start of an episode if none is set",
        1,
        lambda calls, it: calls.simxGetIntegerSignal(it.name),
        _answer,
        at_start=0.0,
    ),
)
