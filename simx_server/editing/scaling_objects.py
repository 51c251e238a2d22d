"""Scale objects of any kind alike along all axes, with the lengths, masses and forces that belong to them.

Accelerations stay as they are, so a mass rises with the third power of the factor, and so does a force; a torque rises
with the fourth, as in V-REP.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from simx_server.errors import CommandError
from simx_server.joints.scaling import scale_joint
from simx_server.scene.editing import renaming
from simx_server.scene.editing.marks import scale_mark
from simx_server.scene.editing.scaling.geoms import scale_shape
from simx_server.scene.formats.annotations import numbers_of
from simx_server.scene.objects import ObjectKind, SceneObject
from simx_server.scene.poses import frames

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation
    from simx_server.world.world import World

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
        _scale_alike(world.simulation, item, x)
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
    for handle in dict.fromkeys(handles):
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


def _scale_alike(sim: Simulation, item: SceneObject, factor: float) -> None:
    """Scale an object other than a shape; the parts scale what they know of it."""
    if item.kind == ObjectKind.JOINT:
        scale_joint(sim.joints, item.handle, factor)
    scale_mark(sim, item, factor)
    sim.parts.tell(lambda part: part.object_scaled(item.handle, factor))
