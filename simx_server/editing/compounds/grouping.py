"""Make one compound shape of several."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from simx_server.errors import CommandError
from simx_server.scene.editing import editing
from simx_server.scene.editing.recompile import edit
from simx_server.scene.editing.transplant import delete, delete_all
from simx_server.scene.editing.welding import is_link
from simx_server.scene.geometry.inertia import Array, get_inertia, set_inertia
from simx_server.scene.objects import ObjectKind, SceneObject
from simx_server.scene.poses.placing import body_pose
from simx_server.scene.poses.poses import Pose, compose, inverse, matrix

from .geoms import copy_geom, set_aside

if TYPE_CHECKING:
    from simx_server.world.world import World

LEAST_MASS = 1e-9
"""Mass in kilograms below which a body has none."""

Weight = tuple[float, Array, Array]
"""Mass (kg), (3, 3) inertia about the centre of mass (kg m^2), (3,) centre of mass (m)."""


def group(world: World, handles: Sequence[int]) -> int:
    """Make one shape of several; return its handle, which is the last one's.

    It has the name, the parent and the frame of the last, the geoms, the children and the sum of the masses of all. The
    others are removed.

    Raises:
        UnknownHandle, WrongKind, CommandError: a shape is a part of the world, or a link of a mechanism that is not
            the last one.
    """
    sim = world.simulation
    items = [_body_shape(world, handle) for handle in dict.fromkeys(handles)]
    if not items:
        raise CommandError("there are no shapes to group")
    target, others = items[-1], items[:-1]
    for item in others:
        if is_link(sim, item.body):
            raise CommandError(
                f"'{item.name}' is moved by a joint; only the last of the shapes to group may be a link of a mechanism"
            )
    while above := next((each for each in others if sim.scene.is_below(target.handle, each.handle)), None):
        editing.set_parent(sim, target.handle, sim.scene.get(above.handle).parent, keep_in_place=True)
    merge(world, target.handle, [item.handle for item in others])
    return target.handle


def merge(
    world: World, handle: int, others: Collection[int], *, doomed: Collection[str] = (), heavier: bool = True
) -> None:
    """Move the geoms and the children of some shapes to one shape, and remove the others.

    Args:
        handle: the shape; it and the others have bodies.
        others: handles of the shapes that end.
        doomed: names of geoms of the shape that are deleted.
        heavier: the masses are added; otherwise the shape keeps its own.
    """
    sim = world.simulation
    if not others:
        return
    for other in others:
        for child in list(sim.scene.children(other)):
            editing.set_parent(sim, child, handle, keep_in_place=True)
    sim.refresh()
    target = sim.scene.get(handle)
    bodies = [sim.scene.get(other) for other in others]
    away = inverse(body_pose(sim, target.body))
    frames = [compose(away, body_pose(sim, item.body)) for item in bodies]
    own = get_inertia(sim, handle)
    weight = own
    if heavier:
        weight = _sum(
            [own, *(seen(get_inertia(sim, i.handle), f) for i, f in zip(bodies, frames, strict=True))]
        )
    model = sim.model
    names = [[model.geom(geom).name for geom in _geoms(model, item.body)] for item in (target, *bodies)]

    def surgery(spec: mujoco.MjSpec) -> None:
        for item, frame in zip(bodies, frames, strict=True):
            for geom in list(spec.body(item.element_name).geoms):
                name = set_aside(geom)
                copy_geom(geom, spec.body(target.element_name).add_geom(), model, name, frame)
            delete(spec, "body", item.element_name)
        delete_all(spec, [("geom", name) for name in doomed])

    moved = {("geom_", name) for group_names in names[1:] for name in group_names}
    edit(sim, surgery, moved, removed=set(others))
    if weight[0] > LEAST_MASS:
        set_inertia(sim, handle, *weight)
    world.object_settings.apply_masks()


def _body_shape(world: World, handle: int) -> SceneObject:
    item = world.simulation.scene.get_kind(handle, ObjectKind.SHAPE)
    if item.element != "body":
        raise CommandError(f"'{item.name}' is a part of the world itself; make it a body to group it")
    return item


def _geoms(model: mujoco.MjModel, body: int) -> range:
    start = int(model.body_geomadr[body])
    return range(start, start + int(model.body_geomnum[body]))


def seen(weight: Weight, frame: Pose) -> Weight:
    """Return the same in another frame, in which the body's frame has this pose."""
    mass, inertia, centre = weight
    turn = np.array(matrix(frame[1]))
    return mass, turn @ inertia @ turn.T, turn @ centre + np.array(frame[0])


def _sum(weights: Sequence[Weight]) -> Weight:
    mass = sum(each[0] for each in weights)
    if mass <= LEAST_MASS:
        return 0.0, np.zeros((3, 3)), np.zeros(3)
    centre = sum((each[0] * each[2] for each in weights), np.zeros(3)) / mass
    total = np.zeros((3, 3))
    for own, inertia, place in weights:
        away = place - centre
        total += inertia + own * (float(away @ away) * np.eye(3) - np.outer(away, away))
    return mass, total, centre
