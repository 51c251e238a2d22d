"""Replace a shape by convex parts that fill it, or make a shape of them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.editing.creating import GREY, add
from simx_server.editing.shape_looks import triangles
from simx_server.errors import CommandError
from simx_server.scene.formats.vrep.conversion.geometry.colliding.decomposition import (
    decompose,
    how_to_install,
    is_available,
)
from simx_server.scene.formats.vrep.conversion.geometry.topology import is_closed, welded
from simx_server.scene.geometry.hulls import hull
from simx_server.scene.objects import ObjectKind
from simx_server.scene.poses.placing import object_pose

from .grouping import merge

if TYPE_CHECKING:
    from simx_server.world.world import World


def convex_shape(world: World, handle: int, *, morph: bool) -> int:
    """Make a static shape of convex parts that fill a closed shape; return its handle.

    Args:
        handle: the shape.
        morph: the shape itself gets the parts in place of its geoms, and keeps its mass.

    Raises:
        UnknownHandle, WrongKind, CommandError: the surface is not closed, the library is not installed, or it finds
            nothing within its limits.
    """
    sim = world.simulation
    item = sim.scene.get_kind(handle, ObjectKind.SHAPE)
    if morph and item.element != "body":
        raise CommandError(f"'{item.name}' is a part of the world itself; make it a body to replace its form")
    parts = _parts(world, handle)
    item = sim.scene.get_kind(handle, ObjectKind.SHAPE)  # others were served meanwhile
    position, quat = object_pose(sim, item)

    def build(spec: mujoco.MjSpec, name: str) -> None:
        body: Any = spec.worldbody.add_body(name=name, pos=list(position), quat=list(quat))
        for number, points in enumerate(parts):
            corners, faces = hull(points)
            mesh: Any = spec.add_mesh(name=f"part{number}")
            mesh.uservert, mesh.userface = corners.ravel(), faces.ravel().astype(np.int32)
            geom = body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=mesh.name, rgba=list(GREY))
            geom.contype = geom.conaffinity = 1

    made = add(world, "Convex", "body", build)
    if not morph:
        return made
    model, body = sim.model, sim.scene.get(handle).body
    start = int(model.body_geomadr[body])
    doomed = [model.geom(geom).name for geom in range(start, start + int(model.body_geomnum[body]))]
    merge(world, handle, [made], doomed=doomed, heavier=False)
    return handle


def _parts(world: World, handle: int) -> list[NDArray[np.float64]]:
    """Return the points of the convex parts, in the shape's frame."""
    points, faces = triangles(world, handle)
    used, joined = welded(points.astype(np.float32), faces.astype(np.int32))
    name = world.simulation.scene.get(handle).name
    if not is_closed(used, joined):
        raise CommandError(f"the surface of '{name}' is not closed, so it has no convex parts")
    if not is_available():
        raise CommandError(f"convex parts need a library that is not installed: {how_to_install()}")
    found = decompose(used, joined, name, world.simulation.interruptions.may_go_on)
    if not found:
        raise CommandError(f"the library found no convex parts of '{name}'; the log says why")
    return [np.asarray(part, np.float64) for part in found]
