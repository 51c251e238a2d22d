"""Mass, centre of mass and inertia of a shape's body.

V-REP's engines take any three moments of inertia; a tenth of the dynamic shapes of public files have some that no body
can have. MuJoCo refuses those. So the smaller moments are raised as little as possible; the largest one stays.
"""

from __future__ import annotations

import math
from typing import Any

from simx_server.scene.formats.vrep.objects import Shape
from simx_server.scene.poses.poses import IDENTITY, Pose, normalised

from .context import Conversion
from .geometry.damage import is_frame

LEAST_MASS = 1e-4
"""kg; with less, contacts and motors throw a body about."""

_LEAST_GYRATION = 1e-6
"""Least moment of inertia per mass, m^2: that of a body of some millimetres."""

_MARGIN = 2e-5
"""Part of a moment by which the sum of the two others must be above it: MJCF is written with six digits."""

_MOST = 1e8
"""Mass in kilograms and moment per mass in m^2 above which a value cannot belong to a thing."""

_MASS = "a mass that physics cannot use became another one"
_MOMENTS = "moments of inertia that no body can have were raised"
_FRAME = "a centre of mass that is no point became the shape's origin"


def set_inertia(conversion: Conversion, shape: Shape, body: Any) -> None:
    """Give a body the mass, the centre of mass and the inertia of a shape; the body's frame is the shape's."""
    report, name = conversion.report, conversion.name(shape)
    mass = shape.mass
    if not LEAST_MASS <= mass <= _MOST:
        mass = min(max(mass, LEAST_MASS), _MOST) if math.isfinite(mass) else LEAST_MASS
        if shape.is_dynamic:
            report.approximate(_MASS, name)
    moments, is_changed = physical(shape.inertia)
    if is_changed and shape.is_dynamic:
        report.approximate(_MOMENTS, name)
    frame = _frame(shape.inertia_frame)
    if frame is None:
        frame = IDENTITY
        report.approximate(_FRAME, name)
    body.explicitinertial = True
    body.mass = mass
    body.ipos[:], body.iquat[:] = frame
    body.inertia[:] = [mass * moment for moment in moments]


def physical(moments: tuple[float, float, float]) -> tuple[tuple[float, float, float], bool]:
    """Return moments of inertia per mass that a body can have, m^2, and whether they differ from the given ones.

    None is above the sum of the two others: where one is, these two are raised by the same amount.
    """
    found = [
        min(max(moment, _LEAST_GYRATION), _MOST) if math.isfinite(moment) else _LEAST_GYRATION
        for moment in moments
    ]
    largest = max(range(3), key=found.__getitem__)
    excess = found[largest] * (2 + _MARGIN) - sum(found)
    if excess > 0:
        found = [each if place == largest else each + excess / 2 for place, each in enumerate(found)]
    # Values of a file that stores 32 bits lie a little beside each other.
    is_changed = any(abs(a - b) > 2 * _MARGIN * abs(a) for a, b in zip(found, moments, strict=True))
    return (found[0], found[1], found[2]), is_changed or not all(map(math.isfinite, moments))


def _frame(frame: Pose) -> Pose | None:
    """Return a frame with a quaternion of length 1; None where it cannot be a frame."""
    position, turn = frame
    return (position, normalised(turn)) if is_frame(frame) else None
