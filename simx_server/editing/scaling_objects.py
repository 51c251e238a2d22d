"""Scale objects of any kind alike along all axes, with the lengths, masses and forces that belong to them.

Accelerations stay as they are, so a mass rises with the third power of the factor, and so does a force; a torque rises
with the fourth, as in V-REP.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from simx_server.errors import CommandError
from simx_server.scene.editing import editing, renaming
from simx_server.scene.editing.scaling.geoms import scale_shape
from simx_server.scene.formats.annotations import numbers_of
from simx_server.scene.objects import ObjectKind
from simx_server.scene.poses import frames

if TYPE_CHECKING:
    from simx_server.world.world import World

_SLIDE, _BALL = 11, 12

_SENSOR_LENGTHS = (
    *("offset", "range", "radius", "radius_far", "size_x", "size_y", "size_x_far", "size_y_far"),
    *("height", "min_distance"),
)
"""Lengths in the annotation of a proximity sensor."""

_ONE = (1.0, 1.0, 1.0)


def size_factor(world: World, handle: int) -> float:
    """Return how much an object was scaled, in all. Raises UnknownHandle."""
    note = world.simulation.scene.get(handle).annotations.get("object", {})
    return float(note.get("size_factor", 1.0))


def size_values(world: World, handle: int) -> tuple[float, ...]:
    """Return how much an object was scaled along each axis. Raises UnknownHandle."""
    note = world.simulation.scene.get(handle).annotations.get("object", {})
    return numbers_of(note["size_values"]) if "size_values" in note else _ONE


def scale_object(world: World, handle: int, factors: Sequence[float]) -> None:
    """Scale one object about its own frame; only shapes can have different factors along the axes.

    Args:
        factors: three numbers above 0, along the axes of the object's frame.

    Raises UnknownHandle, CommandError.
    """
    item = world.simulation.scene.get(handle)
    x, y, z = _checked(factors)
    if item.kind == ObjectKind.SHAPE:
        scale_shape(world.simulation, handle, np.array([x, y, z]))
    elif not np.allclose([x, y], z, rtol=1e-6):
        raise CommandError(
            f"'{item.name}', a {item.kind.text}, can only be scaled alike along all axes, not by {x:g}, {y:g}, {z:g}"
        )
    else:
        _SCALE.get(item.kind, _nothing)(world, handle, x)
    _count(world, handle, (x, y, z))


def scale_objects(world: World, handles: Sequence[int], factor: float, *, positions: bool) -> None:
    """Scale objects alike along all axes; with a model base all objects below it, and their places.

    Args:
        positions: also scale the places of the given objects in their parents' frames.

    Raises UnknownHandle, CommandError.
    """
    scene = world.simulation.scene
    _checked([factor] * 3)
    chosen: dict[int, bool] = {}
    for handle in handles:
        chosen[handle] = chosen.get(handle, False) or positions
        if scene.is_model_base(handle):
            chosen |= dict.fromkeys(scene.descendants(handle), True)
    for handle in sorted(chosen, key=lambda each: _depth(world, each)):
        if chosen[handle]:
            _scale_place(world, handle, factor)
        scale_object(world, handle, [factor] * 3)


def _checked(factors: Sequence[float]) -> tuple[float, float, float]:
    if len(factors) != 3 or not all(np.isfinite(factors)) or min(factors) <= 0:
        raise CommandError(f"a scaling factor is a number above 0, not {list(factors)}")
    x, y, z = (float(each) for each in factors)
    return x, y, z


def _depth(world: World, handle: int) -> int:
    scene, depth = world.simulation.scene, 0
    while (handle := scene.get(handle).parent) != -1:
        depth += 1
    return depth


def _scale_place(world: World, handle: int, factor: float) -> None:
    sim = world.simulation
    if sim.scene.get(handle).element == "tendon":
        return  # it lies where its sites are
    place = frames.get_position(sim, handle, frames.PARENT)
    frames.set_position(sim, handle, frames.PARENT, [factor * each for each in place])


def _count(world: World, handle: int, factors: tuple[float, float, float]) -> None:
    """Remember how much the object was scaled."""
    values = [before * now for before, now in zip(size_values(world, handle), factors, strict=True)]
    factor = size_factor(world, handle) * float(np.prod(factors)) ** (1 / 3)
    note = {"size_factor": factor, "size_values": ",".join(repr(value) for value in values)}
    renaming.annotate(world.simulation, handle, "object", dict(note))


def _nothing(_world: World, _handle: int, _factor: float) -> None:
    """Change nothing: of this kind only the place in the scene has lengths."""


def _scale_joint(world: World, handle: int, factor: float) -> None:
    joints = world.simulation.joints
    kind = joints.joint_type(handle)
    if kind == _BALL:
        return
    state = joints.state(handle)
    is_slide = kind == _SLIDE
    force = factor ** (3 if is_slide else 4)
    stiffness = factor ** (2 if is_slide else 4)
    position = joints.position(handle)
    if state.max_force < 1e9:
        joints.set_max_force(handle, state.max_force * force)
    joints.change(handle, k=state.k * stiffness, c=state.c * stiffness)
    if not is_slide:
        return
    cyclic, least, extent = joints.interval(handle)
    if extent < 1e9:
        joints.set_interval(handle, cyclic, least * factor, extent * factor)
    joints.change(
        handle,
        target_position=state.target_position * factor,
        target_velocity=state.target_velocity * factor,
        upper_velocity=state.upper_velocity * factor,
    )
    if joints.state(handle).master < 0:
        joints.set_position(handle, position * factor)


def _scale_dummy(world: World, handle: int, factor: float) -> None:
    sim = world.simulation
    if sim.scene.get(handle).element == "site":
        editing.set_dummy_size(sim, handle, editing.dummy_size(sim, handle) * factor)


def _scale_proximity(world: World, handle: int, factor: float) -> None:
    note = world.simulation.scene.get(handle).annotations.get("proximity", {})
    lengths = {key: float(note[key]) * factor for key in _SENSOR_LENGTHS if key in note}
    if lengths:
        renaming.annotate(world.simulation, handle, "proximity", dict(lengths))
        world.proximity.look_again(handle)


def _scale_vision(world: World, handle: int, factor: float) -> None:
    settings = world.vision.settings(handle)
    changes = {"near": settings.near * factor, "far": settings.far * factor}
    if settings.orthographic_size is not None:
        changes["orthographic_size"] = settings.orthographic_size * factor
    world.vision.change(handle, **changes)


def _scale_force(world: World, handle: int, factor: float) -> None:
    note = world.simulation.scene.get(handle).annotations.get("force", {})
    powers = {"max_force": 3, "max_torque": 4}
    limits = {key: float(note[key]) * factor**power for key, power in powers.items() if key in note}
    if limits:
        renaming.annotate(world.simulation, handle, "force", dict(limits))


def _scale_points(world: World, handle: int, factor: float) -> None:
    world.clouds.scale(handle, factor)


_SCALE: Mapping[ObjectKind, Callable[[World, int, float], None]] = {
    ObjectKind.JOINT: _scale_joint,
    ObjectKind.DUMMY: _scale_dummy,
    ObjectKind.PROXIMITY_SENSOR: _scale_proximity,
    ObjectKind.VISION_SENSOR: _scale_vision,
    ObjectKind.FORCE_SENSOR: _scale_force,
    ObjectKind.POINT_CLOUD: _scale_points,
    ObjectKind.OCTREE: _scale_points,
}
