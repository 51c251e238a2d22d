"""Joints without a motor stay where they are almost balanced, as in V-REP, whose engines put slow bodies to rest.

Drawers of files are hardly ever level: one that slopes by 0.3 mrad would be a hand's breadth out after seven seconds.
"""

from __future__ import annotations

from typing import Any

import mujoco

from simx_server.scene.formats.vrep.objects import Joint
from simx_server.scene.poses.poses import IDENTITY, Pose, compose

from .context import Conversion

_REST = 0.02
"""Acceleration in m/s^2 or rad/s^2 up to which a joint does not start to move: that of a slope of 2 mrad."""

_FORCE = 5
"""The joint mode in which physics moves a joint."""


def let_rest(conversion: Conversion) -> None:
    """Give each joint that physics moves without a motor a friction in proportion to its load."""
    joints = {
        conversion.name(each): each for each in conversion.file.objects.values() if isinstance(each, Joint)
    }
    for body in conversion.spec.bodies:
        for moved in body.joints:
            joint = joints.get(moved.name)
            if joint is not None and joint.mode == _FORCE and not joint.motor:
                if moved.type == mujoco.mjtJoint.mjJNT_SLIDE:
                    moved.frictionloss = _REST * _mass(body)
                elif moved.type == mujoco.mjtJoint.mjJNT_HINGE:
                    moved.frictionloss = _REST * _moment(body, IDENTITY)


def _mass(body: Any) -> float:
    """Return the mass in kg of a body with all that it carries; one that is only a frame has none."""
    own = body.mass if body.explicitinertial else 0.0
    return own + sum(map(_mass, body.bodies))


def _moment(body: Any, pose: Pose) -> float:
    """Return the moment of inertia about the axis of a joint, z, in kg m^2.

    Args:
        body: it, and all that it carries.
        pose: of the body's frame in the joint's.
    """
    own = 0.0
    if body.explicitinertial:
        (x, y, _), _ = compose(pose, (tuple(body.ipos), tuple(body.iquat)))
        own = body.mass * (x * x + y * y) + sum(body.inertia) / 3
    return own + sum(
        _moment(each, compose(pose, (tuple(each.pos), tuple(each.quat)))) for each in body.bodies
    )
