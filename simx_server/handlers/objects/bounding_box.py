"""The box that encloses an object's geoms, in the object's own frame (V-REP's parameters 15 to 26).

The box is exact for primitives and meshes: the extent of each geom along the axes of the frame is computed from its
shape, not from a box about a box.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.errors import CommandError
from simx_server.scene.geometry.stand_ins import stand_ins
from simx_server.scene.objects import ObjectKind
from simx_server.scene.poses import frames
from simx_server.scene.poses.poses import matrix

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation

Vector = NDArray[np.float64]

_WITH_FORM = (ObjectKind.SHAPE, ObjectKind.OCTREE, ObjectKind.POINT_CLOUD)


def of_object(sim: Simulation, handle: int, *, whole_model: bool = False) -> tuple[list[float], list[float]]:
    """Return least and greatest x, y, z in metres, of the object alone or of everything below it too.

    Raises:
        UnknownHandle: the handle is unknown.
        CommandError: no object there has an extent.
    """
    item = sim.scene.get(handle)
    if item.element == "site" and not whole_model and item.kind == ObjectKind.DUMMY:
        return _of_site(sim.model, item.id)
    handles = {handle, *sim.scene.descendants(handle)} if whole_model else {handle}
    wanted = [h for h in handles if sim.scene.objects[h].kind in _WITH_FORM]
    owners = np.array([sim.scene.owner_of_geom(g, sim.model) for g in range(sim.model.ngeom)], np.int64)
    of_wanted = np.isin(owners, wanted) & ~stand_ins(sim.scene, sim.model, owners)
    geoms: list[int] = np.flatnonzero(of_wanted).tolist()
    if not geoms:
        raise CommandError(
            f"'{item.name}', a {item.kind.text}, has no extent; shapes have, and dummies that are sites"
        )
    position, quat = frames.get_pose(sim, handle)
    axes = np.array(matrix(quat)).T
    least, greatest = np.full(3, np.inf), np.full(3, -np.inf)
    for geom in geoms:
        rotation = axes @ sim.data.geom_xmat[geom].reshape(3, 3)
        centre = axes @ (sim.data.geom_xpos[geom] - np.array(position))
        low, high = _reach(sim.model, geom, rotation)
        least, greatest = np.minimum(least, centre + low), np.maximum(greatest, centre + high)
    return least.tolist(), greatest.tolist()


def _of_site(model: mujoco.MjModel, site: int) -> tuple[list[float], list[float]]:
    """Return the box about the mark of a dummy; its sizes have the same meaning as a geom's."""
    radius, half_length, _ = size = model.site_size[site].tolist()
    match mujoco.mjtGeom(int(model.site_type[site])):
        case mujoco.mjtGeom.mjGEOM_SPHERE:
            half = [radius, radius, radius]
        case mujoco.mjtGeom.mjGEOM_CAPSULE:
            half = [radius, radius, radius + half_length]
        case mujoco.mjtGeom.mjGEOM_CYLINDER:
            half = [radius, radius, half_length]
        case _:
            half = size
    return [-side for side in half], half


def _reach(model: mujoco.MjModel, geom: int, rotation: Vector) -> tuple[Vector, Vector]:
    """Return the extent of a geom from its centre along each axis, down and up. Rows of `rotation` are the axes."""
    kind = mujoco.mjtGeom(int(model.geom_type[geom]))
    size = model.geom_size[geom]
    along = np.abs(rotation)
    match kind:
        case mujoco.mjtGeom.mjGEOM_SPHERE:
            half = np.full(3, size[0])
        case mujoco.mjtGeom.mjGEOM_CAPSULE:
            half = size[0] + size[1] * along[:, 2]
        case mujoco.mjtGeom.mjGEOM_CYLINDER:
            half = size[0] * np.hypot(along[:, 0], along[:, 1]) + size[1] * along[:, 2]
        case mujoco.mjtGeom.mjGEOM_ELLIPSOID:
            half = np.sqrt((rotation**2) @ (size**2))
        case mujoco.mjtGeom.mjGEOM_PLANE:
            # An infinite plane has size 0 and counts as a point: V-REP's floors are finite.
            half = along[:, :2] @ size[:2]
        case mujoco.mjtGeom.mjGEOM_MESH:
            return _mesh_reach(model, int(model.geom_dataid[geom]), rotation)
        case _:
            centre, extent = model.geom_aabb[geom, :3], model.geom_aabb[geom, 3:]
            shift, half = rotation @ centre, along @ extent
            return shift - half, shift + half
    return -half, half


def _mesh_reach(model: mujoco.MjModel, mesh: int, rotation: Vector) -> tuple[Vector, Vector]:
    start = int(model.mesh_vertadr[mesh])
    vertices = model.mesh_vert[start : start + int(model.mesh_vertnum[mesh])] @ rotation.T
    return vertices.min(axis=0), vertices.max(axis=0)
