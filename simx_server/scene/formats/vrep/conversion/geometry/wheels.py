"""Wheels: cylinders that roll on the ground touch it at one point, in the middle of their width.

V-REP's engines give the two ends of the line of contact the same friction, and wheels turn a robot about their
middles. MuJoCo's contacts creep under load, and unequally: two points per wheel brake a turn by some per cent, and let
a straight drive rattle. An ellipsoid as wide as the wheel rolls as the wheel does.
"""

from __future__ import annotations

import mujoco

from simx_server.scene.formats.vrep.conversion.context import Conversion
from simx_server.scene.formats.vrep.conversion.structure import world_poses
from simx_server.scene.formats.vrep.objects import Joint, JointType, Leaf, Primitive, Shape
from simx_server.scene.poses.poses import compose, rotate

from .primitives import Form

_COAXIAL = 1e-3
"""Metres between a wheel's centre and its joint's axis, and sine of the angle between their directions."""

_WIDEST = 0.8
"""Width of a wheel, in diameters; a wider cylinder is a roller, on which things lie."""

_LEVEL = 0.5
"""Vertical part of the direction of a wheel's axis; with more, the cylinder is a turntable."""


def is_wheel(conversion: Conversion, shape: Shape, leaf: Leaf) -> bool:
    """Return whether a leaf of a shape is a cylinder that its joint turns about a level axis, its own."""
    joint = conversion.file.objects.get(shape.parent)
    if leaf.primitive != Primitive.CYLINDER or not isinstance(joint, Joint) or not shape.is_dynamic:
        return False
    width, diameter = leaf.size[2], max(leaf.size[:2])
    if joint.type != JointType.REVOLUTE or width > _WIDEST * diameter:
        return False
    (x, y, _), turn = compose(shape.pose, leaf.pose)
    across = rotate(turn, (0.0, 0.0, 1.0))
    if max(abs(x), abs(y), abs(across[0]), abs(across[1])) > _COAXIAL:
        return False
    _, world = compose(world_poses(conversion.file)[shape.handle], leaf.pose)
    return abs(rotate(world, (0.0, 0.0, 1.0))[2]) <= _LEVEL


def rolling(form: Form) -> Form:
    """Return the form with which the cylinder of a wheel collides."""
    radius, half_width, _ = form.size
    return Form(mujoco.mjtGeom.mjGEOM_ELLIPSOID, (radius, radius, half_width))
