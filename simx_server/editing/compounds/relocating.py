"""Move the frame of a shape, while its surface and its children stay where they are."""

from __future__ import annotations

from typing import TYPE_CHECKING

import mujoco
import numpy as np

from simx_server.editing.shape_looks import part_corners
from simx_server.errors import CommandError
from simx_server.scene.editing.recompile import edit
from simx_server.scene.editing.transplant import equality_kind
from simx_server.scene.editing.welding import is_link, set_free, velocity
from simx_server.scene.geometry.inertia import get_inertia, set_inertia
from simx_server.scene.objects import ObjectKind, SceneObject
from simx_server.scene.poses.placing import body_pose, free_joint, object_pose, place, place_all
from simx_server.scene.poses.poses import Pose, Quaternion, compose, conjugate, inverse, matrix, rotate

from .geoms import copy_geom, set_aside
from .grouping import LEAST_MASS, seen

if TYPE_CHECKING:
    from simx_server.world.world import World


def relocate(world: World, handle: int, pose: Pose) -> None:
    """Give a shape another frame.

    Args:
        handle: the shape.
        pose: the new frame in the world, metres; the quaternion is w, x, y, z.

    Raises:
        UnknownHandle, WrongKind, CommandError: the shape is a part of the world, a link of a mechanism, or held by a
            constraint, whose anchors are given in its frame.
    """
    sim = world.simulation
    item = _movable(world, handle)
    sim.refresh()
    old = body_pose(sim, item.body)
    frame = compose(inverse(pose), old)
    children = {child: object_pose(sim, sim.scene.get(child)) for child in sim.scene.children(handle)}
    weight = seen(get_inertia(sim, handle), frame)
    motion = velocity(sim, item.body) if free_joint(sim.model, item.body) >= 0 else None
    model = sim.model
    start = int(model.body_geomadr[item.body])
    names = [model.geom(geom).name for geom in range(start, start + int(model.body_geomnum[item.body]))]

    def surgery(spec: mujoco.MjSpec) -> None:
        body = spec.body(item.element_name)
        for geom in list(body.geoms):
            name = set_aside(geom)
            copy_geom(geom, body.add_geom(), model, name, frame)
            spec.delete(geom)

    edit(sim, surgery, {("geom_", name) for name in names})
    place(sim, sim.scene.get(handle), pose)
    place_all(sim, [(sim.scene.get(child), there) for child, there in children.items()])
    if weight[0] > LEAST_MASS:
        set_inertia(sim, handle, *weight)
    if motion is not None:
        set_free(sim, item.element_name, pose, _seen_motion(motion, old, pose))
    sim.changed()


def middle(world: World, handle: int, turn: Quaternion | None = None) -> Pose:
    """Return the frame in the middle of a shape's bounding box, with the shape's directions or with given ones.

    Args:
        handle: the shape.
        turn: directions of the box in the world, as a quaternion w, x, y, z.

    Raises:
        UnknownHandle, WrongKind, CommandError: it is a plane.
    """
    sim = world.simulation
    item = sim.scene.get_kind(handle, ObjectKind.SHAPE)
    sim.refresh()
    position, own = object_pose(sim, item)
    parts = world.shape_colors.parts(handle)
    points = np.concatenate([part_corners(world, handle, part.geom).reshape(-1, 3) for part in parts])
    placed = points @ np.array(matrix(own)).T + np.array(position)
    chosen = turn or own
    axes = np.array(matrix(chosen))
    along = placed @ axes
    x, y, z = (axes @ ((along.min(axis=0) + along.max(axis=0)) / 2)).tolist()
    return (x, y, z), chosen


def _movable(world: World, handle: int) -> SceneObject:
    sim = world.simulation
    item = sim.scene.get_kind(handle, ObjectKind.SHAPE)
    if item.element != "body":
        raise CommandError(f"'{item.name}' is a part of the world itself; make it a body to move its frame")
    if is_link(sim, item.body):
        raise CommandError(f"'{item.name}' is moved by a joint, so its frame cannot be moved")
    for equality in sim.scene.spec.equalities:
        if equality_kind(equality) == "body" and item.element_name in (equality.name1, equality.name2):
            raise CommandError(f"'{item.name}' is held by a constraint, so its frame cannot be moved")
    if any(sim.scene.get(child).element == "tendon" for child in sim.scene.children(handle)):
        raise CommandError(f"'{item.name}' has a joint on a tendon, so its frame cannot be moved")
    return item


def _seen_motion(motion: list[float], old: Pose, new: Pose) -> list[float]:
    """Return the velocity of a body's new frame; as `velocity` gives it."""
    spin = rotate(old[1], (motion[3], motion[4], motion[5]))
    away = np.array(new[0]) - np.array(old[0])
    linear = np.array(motion[:3]) + np.cross(spin, away)
    return [*linear.tolist(), *rotate(conjugate(new[1]), spin)]
