"""Make several shapes of one: of the parts of a compound, or of the unconnected parts of a mesh."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.editing.creating import Body, create_mesh
from simx_server.editing.grafts.grafting import Graft, graft
from simx_server.editing.shape_looks import part_corners
from simx_server.errors import CommandError
from simx_server.scene.editing import editing, welding
from simx_server.scene.editing.recompile import edit
from simx_server.scene.editing.transplant import delete_all
from simx_server.scene.formats.vrep.conversion.geometry.topology import connected
from simx_server.scene.geometry.inertia import compute_inertia, get_inertia, set_inertia
from simx_server.scene.naming.names import alias_of
from simx_server.scene.objects import ObjectKind, SceneObject
from simx_server.scene.poses.placing import body_pose, free_joint, object_pose
from simx_server.scene.poses.poses import IDENTITY, matrix

from .geoms import copy_geom

if TYPE_CHECKING:
    from simx_server.world.world import World

MOST_PARTS = 1000
"""Most shapes that one shape is cut into."""

_WATER = 1000.0
"""Density in kg/m^3 by which the parts share the mass of their shape."""


def ungroup(world: World, handle: int) -> list[int]:
    """Make a shape of each geom of a compound shape; return their handles, the shape itself first.

    The shape keeps its first geom. The others are free where it is free; else they are fixed to its parent, or to the
    shape itself if it is a link of a mechanism. The parts of a free shape share its mass by their volumes.

    Raises:
        UnknownHandle, WrongKind, CommandError: it is a part of the world, or has too many parts.
    """
    sim = world.simulation
    item = sim.scene.get_kind(handle, ObjectKind.SHAPE)
    parts = _parts(world, item)
    if len(parts) < 2:
        return [handle]
    if len(parts) > MOST_PARTS:
        raise CommandError(f"'{item.name}' has {len(parts)} parts; at most {MOST_PARTS} are made shapes")
    names = [[sim.model.geom(geom).name for geom in part] for part in parts]
    is_free = free_joint(sim.model, item.body) >= 0
    is_link = welding.is_link(sim, item.body) or welding.holding_joint(sim, item) is not None
    mass = float(sim.model.body_mass[item.body])
    weight = get_inertia(sim, handle)
    made = _add_parts(world, item, names[1:], is_free)
    gone = [("geom", name) for part in names[1:] for name in part]
    edit(sim, lambda spec: delete_all(spec, gone), set())
    if is_free:
        _share(world, [handle, *made], mass)
    elif mass > 0:
        set_inertia(sim, handle, *weight)
    for other in made if not is_free else ():
        parent = handle if is_link else sim.scene.get(handle).parent
        editing.set_parent(sim, other, parent, keep_in_place=True)
    world.object_settings.apply_masks()
    return [handle, *made]


def divide(world: World, handle: int) -> list[int]:
    """Make a static shape of each unconnected part of a shape's surface; return their handles.

    The shape itself is removed. One that is a single piece stays, and is returned.

    Raises:
        UnknownHandle, WrongKind, CommandError: it is a plane, or has too many parts.
    """
    sim = world.simulation
    item = sim.scene.get_kind(handle, ObjectKind.SHAPE)
    parts: list[tuple[NDArray[np.float64], list[float]]] = []
    for part in world.shape_colors.parts(handle):
        corners = part_corners(world, handle, part.geom)
        points, faces = np.unique(corners.reshape(-1, 3).round(9), axis=0, return_inverse=True)
        label = connected(points.astype(np.float32), faces.reshape(-1, 3).astype(np.int32))
        parts += [(corners[label == each], part.colors[:3]) for each in np.unique(label)]
    if len(parts) < 2:
        return [handle]
    if len(parts) > MOST_PARTS:
        raise CommandError(f"'{item.name}' has {len(parts)} parts; at most {MOST_PARTS} are made shapes")
    position, turn = object_pose(sim, item)
    made: list[int] = []
    for corners, color in parts:
        placed = corners @ np.array(matrix(turn)).T + np.array(position)
        points, faces = np.unique(placed.reshape(-1, 3).round(9), axis=0, return_inverse=True)
        new = create_mesh(world, points, faces.reshape(-1, 3), _stem(item), Body())
        world.shape_colors.set(new, 0, color)
        editing.set_parent(sim, new, item.parent, keep_in_place=True)
        made.append(new)
    editing.remove_object(sim, handle)
    world.object_settings.apply_masks()
    return made


def _parts(world: World, item: SceneObject) -> list[list[int]]:
    """Return the geoms of each part of a shape: the one that is seen, and those that collide in its place."""
    sim = world.simulation
    if item.element != "body":
        raise CommandError(f"'{item.name}' is a part of the world itself; make it a body to ungroup it")
    instant = world.instants.now()
    seen: list[int] = instant.geoms_of([item.handle]).tolist()
    parts = [[geom] for geom in seen]
    start = int(sim.model.body_geomadr[item.body])
    for geom in range(start, start + int(sim.model.body_geomnum[item.body])):
        if geom not in seen:
            away = np.linalg.norm(instant.geom_xpos[seen] - instant.geom_xpos[geom], axis=1)
            parts[int(away.argmin())].append(geom)
    return parts


def _add_parts(world: World, item: SceneObject, parts: list[list[str]], is_free: bool) -> list[int]:
    """Add a shape for each part (names of geoms), with the frame of the shape that has them now."""
    sim = world.simulation
    position, quat = body_pose(sim, item.body)
    addition = mujoco.MjSpec()
    names = [f"{item.element_name}~part{number}" for number in range(len(parts))]
    for name, part in zip(names, parts, strict=True):
        body: Any = addition.worldbody.add_body(name=name, pos=list(position), quat=list(quat))
        if is_free:
            body.add_freejoint()
        for geom in part:
            copy_geom(sim.scene.spec.geom(geom), body.add_geom(), sim.model, geom, IDENTITY)
    stem = _stem(item)
    made = graft(
        sim,
        Graft(
            addition,
            {("body", name): f"{stem}{number}" for number, name in enumerate(names)},
            {},
            copies=True,
        ),
    )
    return [made["body", name] for name in names]


def _share(world: World, handles: list[int], mass: float) -> None:
    """Give shapes the mass and inertia of bodies of one density, of this mass together."""
    sim = world.simulation
    for handle in handles:
        compute_inertia(sim, handle, _WATER)
    weights = {handle: get_inertia(sim, handle) for handle in handles}
    share = mass / sum(weight[0] for weight in weights.values())
    for handle, (own, inertia, centre) in weights.items():
        set_inertia(sim, handle, own * share, inertia * share, centre)


def _stem(item: SceneObject) -> str:
    return f"{alias_of(item.name)}_sub"
