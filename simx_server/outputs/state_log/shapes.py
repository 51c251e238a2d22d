"""Describe a scene as primitives of Foxglove's `SceneUpdate`: one entity for each visible body.

The geoms are the same as for cameras. A capsule is a cylinder with two spheres, an infinite plane a square of `PLANE`
metres; height fields, flexes, skins and textures have no primitive and are left out.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from simx_server.scene.cameras.visibility import USERS_GROUP, VISIBLE_GROUPS

from .messages import plain

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation

PLANE = 10.0
"""Side in metres of the square that stands for an infinite plane."""

_THIN = 0.001
_GEOM = mujoco.mjtGeom

SEEN_BY_USERS = (*VISIBLE_GROUPS, USERS_GROUP)


def scene_update(sim: Simulation, root: str, update: Any) -> Any:
    """Fill a `SceneUpdate` that deletes everything and adds all visible bodies. Times are left open.

    Args:
        root: the frame of geoms that are fixed to the world. Other visible bodies are V-REP objects.
    """
    update.deletions.add().type = 1  # all
    model, entities = sim.model, {}
    for geom in range(model.ngeom):
        body = int(model.geom_bodyid[geom])
        handle = sim.scene.by_element("body", body)
        is_placed = body == 0 or handle is not None
        if not is_placed or int(model.geom_group[geom]) not in SEEN_BY_USERS or not _colour(model, geom)[3]:
            continue
        if body not in entities:
            frame = root if handle is None else plain(sim.scene.get(handle).name)
            entities[body] = update.entities.add(id=f"body {body}", frame_id=frame, frame_locked=True)
        _add(model, geom, entities[body])
    return update


def _add(model: mujoco.MjModel, geom: int, entity: Any) -> None:
    position, quat = model.geom_pos[geom].tolist(), model.geom_quat[geom].tolist()
    size, colour = model.geom_size[geom].tolist(), _colour(model, geom)
    match int(model.geom_type[geom]):
        case _GEOM.mjGEOM_BOX:
            _fill(entity.cubes.add(), position, quat, colour, [2 * side for side in size])
        case _GEOM.mjGEOM_PLANE:
            sides = [2 * side if side > 0 else PLANE for side in size[:2]]
            below = _beside(position, quat, -_THIN / 2)
            _fill(entity.cubes.add(), below, quat, colour, [*sides, _THIN])
        case _GEOM.mjGEOM_SPHERE:
            _fill(entity.spheres.add(), position, quat, colour, [2 * size[0]] * 3)
        case _GEOM.mjGEOM_ELLIPSOID:
            _fill(entity.spheres.add(), position, quat, colour, [2 * side for side in size])
        case _GEOM.mjGEOM_CYLINDER | _GEOM.mjGEOM_CAPSULE as kind:
            cylinder = entity.cylinders.add(bottom_scale=1.0, top_scale=1.0)
            _fill(cylinder, position, quat, colour, [2 * size[0], 2 * size[0], 2 * size[1]])
            if kind == _GEOM.mjGEOM_CAPSULE.value:
                for end in (-size[1], size[1]):
                    _fill(entity.spheres.add(), _beside(position, quat, end), quat, colour, [2 * size[0]] * 3)
        case _GEOM.mjGEOM_MESH:
            _add_mesh(model, int(model.geom_dataid[geom]), entity.triangles.add(), position, quat, colour)
        case _:
            pass


def _add_mesh(
    model: mujoco.MjModel,
    mesh: int,
    triangles: Any,
    position: list[float],
    quat: list[float],
    colour: list[float],
) -> None:
    _fill(triangles, position, quat, colour, None)
    first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
    for x, y, z in model.mesh_vert[first : first + count].tolist():
        triangles.points.add(x=x, y=y, z=z)
    first, count = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
    triangles.indices.extend(model.mesh_face[first : first + count].ravel().tolist())


def _fill(
    primitive: Any,
    position: list[float],
    quat_wxyz: list[float],
    colour: list[float],
    size: list[float] | None,
) -> None:
    for message, values in (
        (primitive.pose.position, position),
        (primitive.pose.orientation, [*quat_wxyz[1:], quat_wxyz[0]]),
    ):
        for name, value in zip("xyzw", values, strict=False):
            setattr(message, name, value)
    for name, value in zip("rgba", colour, strict=True):
        setattr(primitive.color, name, value)
    for name, value in zip("xyz", size or (), strict=False):
        setattr(primitive.size, name, value)


def _beside(position: list[float], quat: list[float], along_z: float) -> list[float]:
    """Return a point on a geom's z axis."""
    shifted = np.empty(3)
    mujoco.mju_rotVecQuat(shifted, np.array((0.0, 0.0, along_z)), np.array(quat))
    return (shifted + position).tolist()


def _colour(model: mujoco.MjModel, geom: int) -> list[float]:
    """Return RGBA, each 0..1: the material's, unless the geom's own was set to other than MuJoCo's grey."""
    material = int(model.geom_matid[geom])
    own = model.geom_rgba[geom].tolist()
    return model.mat_rgba[material].tolist() if material >= 0 and own == [0.5, 0.5, 0.5, 1.0] else own
