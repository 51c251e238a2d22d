"""Quantities that an action or the start of an episode can set."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simx_client.connection.calls import Calls

from .names import Subject
from .readable import OBJECT, SIGNAL

_NEVER_REACHED = 1e4
"""Velocity in rad/s or m/s that no motor reaches: the motor then pushes with its maximum force, V-REP's idiom."""

Numbers = Sequence[float]
Rows = NDArray[np.float64]


@dataclass(frozen=True)
class Writable:
    """A quantity of one kind of objects."""

    kind: str
    attribute: str
    meaning: str
    size: int
    note: Callable[[Calls, Subject, Numbers], object]
    """Notes the calls that set it."""

    counted_from: str | None = None
    """Property that an `Increment` starts from; None: increments are impossible."""

    has_frame: bool = False
    arguments: Callable[[Numbers], Numbers] | None = None
    """Returns the last arguments of the calls, one after the other; None: these are the numbers."""

    rows: Callable[[Rows], Rows] | None = None
    """Does the same for many simulations: (n, size) to (n, number of arguments)."""


def _velocity_and_force(numbers: Numbers) -> Numbers:
    return _NEVER_REACHED if numbers[0] >= 0 else -_NEVER_REACHED, abs(numbers[0])


def _push(calls: Calls, it: Subject, numbers: Numbers) -> None:
    velocity, force = _velocity_and_force(numbers)
    calls.simxSetJointTargetVelocity(it.handle, velocity)
    calls.simxSetJointForce(it.handle, force)


def _velocities_and_forces(numbers: Rows) -> Rows:
    velocities = np.where(numbers >= 0, _NEVER_REACHED, -_NEVER_REACHED)
    return np.concatenate((velocities, np.abs(numbers)), axis=1)


WRITABLE = (
    Writable(
        "joint",
        "target_position",
        "target of the position controller, rad or m",
        1,
        lambda calls, it, numbers: calls.simxSetJointTargetPosition(it.handle, numbers[0]),
        "position",
    ),
    Writable(
        "joint",
        "target_velocity",
        "target of the motor, rad/s or m/s",
        1,
        lambda calls, it, numbers: calls.simxSetJointTargetVelocity(it.handle, numbers[0]),
    ),
    Writable(
        "joint",
        "force",
        "force or torque of the motor in N or N m: a velocity that is not reached, and a maximum force",
        1,
        _push,
        arguments=_velocity_and_force,
        rows=_velocities_and_forces,
    ),
    Writable(
        "joint",
        "position",
        "joint position, rad or m; moves the joint at once",
        1,
        lambda calls, it, numbers: calls.simxSetJointPosition(it.handle, numbers[0]),
        "position",
    ),
    Writable(
        OBJECT,
        "position",
        "x, y, z in m; moves the object at once",
        3,
        lambda calls, it, numbers: calls.simxSetObjectPosition(it.handle, it.frame, numbers),
        "position",
        has_frame=True,
    ),
    Writable(
        OBJECT,
        "quaternion",
        "orientation: x, y, z, w",
        4,
        lambda calls, it, numbers: calls.simxSetObjectQuaternion(it.handle, it.frame, numbers),
        has_frame=True,
    ),
    Writable(
        OBJECT,
        "euler_angles",
        "alpha, beta, gamma of V-REP in rad",
        3,
        lambda calls, it, numbers: calls.simxSetObjectOrientation(it.handle, it.frame, numbers),
        "euler_angles",
        has_frame=True,
    ),
    Writable(
        SIGNAL,
        "float_signal",
        "float signal",
        1,
        lambda calls, it, numbers: calls.simxSetFloatSignal(it.name, numbers[0]),
    ),
    Writable(
        SIGNAL,
        "int_signal",
        "integer signal; the number is rounded",
        1,
        lambda calls, it, numbers: calls.simxSetIntegerSignal(it.name, round(numbers[0])),
        arguments=lambda numbers: [round(numbers[0])],
        rows=np.rint,
    ),
)
