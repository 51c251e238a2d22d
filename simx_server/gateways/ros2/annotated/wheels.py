"""Wheels of robots, found in the scene: their axes, places, radii, and the joints that steer them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from simx_server.joints.joints import JOINT_TYPES
from simx_server.joints.servo import Rule
from simx_server.scene.objects import ObjectKind, SceneObject

if TYPE_CHECKING:
    from simx_server.world.world import World

LEVEL, SKEW = 0.3, (0.4, 0.92)
"""Greatest vertical share of a level axis; shares of a roller's axis along that of its wheel, cosines of 66 and 23
degrees.
"""

ROUND = 0.8
"""Least share of the greater half side of a wheel that the other one has; meshes of wheels have few corners."""

Vector = NDArray[np.float64]


class NoDrive(Exception):
    """The joints of a robot are not those of a drive that is known; the text says why."""


def turning_joints(world: World, base: SceneObject) -> Iterator[SceneObject]:
    """Yield the turning joints of a robot."""
    simulation = world.simulation
    for handle in simulation.scene.descendants(base.handle):
        item = simulation.scene.objects[handle]
        is_joint = item.kind is ObjectKind.JOINT and item.element == "joint"
        if is_joint and simulation.joints.joint_type(handle) == JOINT_TYPES["hinge"]:
            yield item


def axis_of(world: World, joint: SceneObject) -> Vector:
    return world.simulation.data.xaxis[joint.id].copy()


def place_of(world: World, joint: SceneObject) -> Vector:
    return world.simulation.data.xanchor[joint.id].copy()


def is_level(world: World, joint: SceneObject) -> bool:
    return abs(float(axis_of(world, joint)[2])) < LEVEL


def joint_above(world: World, joint: SceneObject) -> SceneObject | None:
    """Return the nearest joint above one."""
    objects = world.simulation.scene.objects
    item = objects.get(joint.parent)
    while item is not None and item.kind is not ObjectKind.JOINT:
        item = objects.get(item.parent)
    return item


def steering_of(world: World, wheel: SceneObject) -> SceneObject | None:
    """Return the upright joint above a wheel that moves to positions; None for a wheel that is not steered."""
    above = joint_above(world, wheel)
    if above is None or above.element != "joint" or is_level(world, above):
        return None
    joints = world.simulation.joints
    is_turning = joints.joint_type(above.handle) == JOINT_TYPES["hinge"]
    return above if is_turning and joints.rule(above.handle) is Rule.POSITION else None


def free_axle(world: World, base: SceneObject, driven: Sequence[SceneObject]) -> Vector:
    """Return the middle of the wheels that are not steered. Raises NoDrive: there are none."""
    others = [
        place_of(world, each)
        for each in turning_joints(world, base)
        if is_level(world, each) and (each not in driven or steering_of(world, each) is None)
    ]
    if not others:
        raise NoDrive("all of its wheels are steered")
    return np.mean(others, axis=0)


def has_rollers(world: World, wheels: Sequence[SceneObject]) -> bool:
    """Return whether each wheel hangs in a free joint that is skewed against it, as V-REP models rollers."""
    joints = world.simulation.joints
    for each in wheels:
        above = joint_above(world, each)
        if above is None or above.element != "joint" or joints.rule(above.handle) is not Rule.FREE:
            return False
        if not SKEW[0] < abs(float(axis_of(world, above) @ axis_of(world, each))) < SKEW[1]:
            return False
    return True


def are_rollers_usual(world: World, wheels: Sequence[SceneObject], way: Vector, left: Vector) -> bool:
    """Return whether rollers stand as mecanum drives have them (see `drives.py`), seen in the direction of `way`.

    A wheel pushes along the axis of the roller that it stands on: in front on the left to the right, or backward to the
    left.
    """
    places = [place_of(world, each) for each in wheels]
    middle = np.mean(places, axis=0)
    for each, place in zip(wheels, places, strict=True):
        above = joint_above(world, each)
        assert above is not None  # `has_rollers` was asked before
        axis = axis_of(world, above)
        is_front, is_left = (place - middle) @ way > 0, (place - middle) @ left > 0
        if ((axis @ way) * (axis @ left) < 0) != (is_front == is_left):
            return False
    return True


def radius_of(world: World, wheel: SceneObject) -> float:
    """Return the radius of a wheel: the greatest half side of its geoms across its axis.

    Raises:
        NoDrive: it has no geom, or is not round.
    """
    model, data = world.simulation.model, world.simulation.data
    first = int(model.jnt_bodyid[wheel.id])
    geoms: list[int] = np.flatnonzero(model.body_weldid[model.geom_bodyid] == first).tolist()
    geoms = [geom for geom in geoms if model.geom_contype[geom] or model.geom_conaffinity[geom]] or geoms
    across = np.zeros(2)
    for geom in geoms:
        axis = data.geom_xmat[geom].reshape(3, 3).T @ axis_of(world, wheel)
        sides = np.delete(model.geom_aabb[geom, 3:], int(np.argmax(np.abs(axis))))
        across = sides if sides.max() > across.max() else across
    if not across.any():
        raise NoDrive(f"its wheel {wheel.name} has no shape")
    if across.min() < ROUND * across.max():
        raise NoDrive(f"its wheel {wheel.name} is not round")
    return round(float(across.max()), 6)
