"""The ground: nothing falls through it, however fast.

V-REP's floor is a thin box. A fast thing would be on its other side after one physics step, and MuJoCo would push it
out there. So the box reaches far down where nothing is below it.
"""

from __future__ import annotations

import math

import numpy as np

from simx_server.scene.formats.vrep.conversion.context import Conversion
from simx_server.scene.formats.vrep.conversion.structure import world_poses
from simx_server.scene.formats.vrep.objects import Leaf, Primitive, Shape
from simx_server.scene.poses.poses import IDENTITY, Pose, compose, rotate

from .damage import undamaged
from .primitives import Form
from .surfaces import ground_of

_DEPTH = 10.0
"""Metres down to which the ground reaches: a thing would need 2 km/s to pass it in a physics step of 5 ms."""

_WIDE = 0.5
"""Least half width of a ground in metres."""

_LEVEL = 0.9999
"""Vertical part of the direction of a box's z axis from which on it lies level."""


def deepened(conversion: Conversion, shape: Shape, leaf: Leaf, form: Form) -> tuple[Form, Pose]:
    """Return the form with which a leaf collides, and its pose in the leaf's frame.

    Args:
        form: the leaf's own form; only the box of the ground becomes another one.
    """
    file = conversion.file
    width = min(form.size[:2])
    is_slab = leaf.primitive == Primitive.CUBOID and width >= max(_WIDE, 2 * form.size[2])
    if not is_slab or file.is_model:
        return form, IDENTITY
    if ground_of(file.objects.values()) is not shape:
        return form, IDENTITY
    poses = world_poses(file)
    position, turn = compose(poses[shape.handle], leaf.pose)
    upwards = rotate(turn, (0.0, 0.0, 1.0))[2]
    x, y, half = form.size
    bottom = position[2] - half
    others = [each for each in file.objects.values() if isinstance(each, Shape) and each is not shape]
    if abs(upwards) < _LEVEL or any(_lowest(each, poses[each.handle]) < bottom for each in others):
        return form, IDENTITY
    return Form(form.type, (x, y, half + _DEPTH / 2)), (
        (0.0, 0.0, math.copysign(_DEPTH / 2, -upwards)),
        IDENTITY[1],
    )


def _lowest(shape: Shape, pose: Pose) -> float:
    """Return a height that no part of a shape lies below."""
    leaves = [leaf for leaf in map(undamaged, shape.leaves) if leaf is not None]
    reach = max(
        (
            math.hypot(*leaf.pose[0])
            + (
                float(np.linalg.norm(leaf.vertices, axis=1).max())
                if len(leaf.vertices)
                else math.hypot(*leaf.size) / 2
            )
            for leaf in leaves
        ),
        default=0.0,
    )
    return pose[0][2] - reach
