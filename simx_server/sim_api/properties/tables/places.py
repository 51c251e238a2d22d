"""Properties of all objects: where they are, how fast they move, and the boxes about them.

Local poses are those in the frame of the parent object, absolute ones those in the world.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from simx_server.errors import CommandError
from simx_server.handlers.objects import bounding_box, poses, shape_boxes
from simx_server.scene.objects import ObjectKind
from simx_server.scene.poses import frames
from simx_server.sim_api.properties.entry import Property
from simx_server.sim_api.properties.property_types import FLOAT, POSE, QUATERNION, VECTOR3
from simx_server.sim_api.values.matrices import as_numbers, as_pose

if TYPE_CHECKING:
    from simx_server.world.world import World

_NO_TURN = [0.0, 0.0, 0.0, 1.0]


def _poses(relative_to: int, name: str) -> list[Property]:
    """Return the properties of a pose in one frame; `name`: how their names start, such as abs."""

    def named(word: str) -> str:
        return f"{name}{word[0].upper()}{word[1:]}" if name else word

    def pose(world: World, handle: int) -> list[float]:
        return as_numbers(frames.get_pose(world.simulation, handle, relative_to))

    def set_pose(world: World, handle: int, value: list[float]) -> None:
        poses.set_object_pose(world, handle, relative_to, as_pose(value))

    return [
        Property(named("pose"), POSE, pose, set_pose),
        Property(
            named("position"),
            VECTOR3,
            lambda world, handle: poses.get_object_position(world, handle, relative_to),
            lambda world, handle, value: poses.set_object_position(world, handle, relative_to, value),
        ),
        Property(
            named("quaternion"),
            QUATERNION,
            lambda world, handle: poses.get_object_quaternion(world, handle, relative_to),
            lambda world, handle, value: poses.set_object_quaternion(world, handle, relative_to, value),
        ),
        Property(
            named("eulerAngles"),
            VECTOR3,
            lambda world, handle: poses.get_object_orientation(world, handle, relative_to),
            lambda world, handle, value: poses.set_object_orientation(world, handle, relative_to, value),
        ),
    ]


def _rotation_axis(world: World, handle: int) -> list[float]:
    rate = world.velocities.measure(handle)[2]
    length = math.hypot(*rate)
    return [each / length for each in rate] if length else [0.0, 0.0, 1.0]


def _box(world: World, handle: int, *, whole_model: bool) -> tuple[list[float], list[float]]:
    """Return centre and sizes of a box in the object's frame; an object without a box is a point."""
    try:
        least, greatest = bounding_box.of_object(world, handle, whole_model=whole_model, with_volumes=False)
    except CommandError:
        return [0.0] * 3, [0.0] * 3
    pairs = list(zip(least, greatest, strict=True))
    return [(low + high) / 2 for low, high in pairs], [high - low for low, high in pairs]


def _half(world: World, handle: int) -> list[float]:
    if _is_shape(world, handle):
        return [side / 2 for side in shape_boxes.box(world, handle)[0]]
    return [side / 2 for side in _box(world, handle, whole_model=False)[1]]


def _box_pose(world: World, handle: int) -> list[Any]:
    if _is_shape(world, handle):
        return as_numbers(shape_boxes.box(world, handle)[1])
    return [*_box(world, handle, whole_model=False)[0], *_NO_TURN]


def _is_shape(world: World, handle: int) -> bool:
    return world.simulation.scene.get(handle).kind == ObjectKind.SHAPE


PLACES = (
    *_poses(frames.PARENT, ""),
    *_poses(frames.WORLD, "abs"),
    Property("calcLinearVelocity", VECTOR3, lambda world, handle: world.velocities.measure(handle)[0]),
    Property("calcRotationAxis", VECTOR3, _rotation_axis),
    Property(
        "calcRotationVelocity",
        FLOAT,
        lambda world, handle: math.hypot(*world.velocities.measure(handle)[2]),
    ),
    Property("bbPose", POSE, _box_pose),
    Property("bbHSize", VECTOR3, _half),
    Property("model.bbPos", VECTOR3, lambda world, handle: _box(world, handle, whole_model=True)[0]),
    Property("model.bbSize", VECTOR3, lambda world, handle: _box(world, handle, whole_model=True)[1]),
)
