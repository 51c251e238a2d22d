"""The extent of geoms and sites along the axes of any frame: exact for primitives and meshes."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.scene.objects import SceneObject
from simx_server.scene.poses.poses import IDENTITY, NO_TURN, Pose, Quaternion, compose, matrix

Array = NDArray[np.float64]

_DIGITS = 12
"""Decimals of a metre: the rounding of turned meshes must not give a flat shape a height."""


def box_of_geoms(
    model: mujoco.MjModel, item: SceneObject, geoms: Sequence[int], turn: Quaternion = NO_TURN
) -> Array | None:
    """Return (2, 3) least and greatest x, y, z of an object's geoms, metres; None without any.

    Args:
        model: the model.
        item: the object.
        geoms: its geoms.
        turn: orientation of the axes in the frame of the object, a quaternion w, x, y, z.
    """
    if not geoms:
        return None
    axes = np.array(matrix(turn)).T
    box = np.array([[np.inf] * 3, [-np.inf] * 3])
    for geom in geoms:
        place, own = _in_frame(model, item, geom)
        centre = axes @ np.array(place)
        low, high = _reach(model, geom, axes @ np.array(matrix(own)))
        box[0], box[1] = np.minimum(box[0], low + centre), np.maximum(box[1], high + centre)
    return box.round(_DIGITS) + 0.0


def _in_frame(model: mujoco.MjModel, item: SceneObject, geom: int) -> Pose:
    """Return the pose of a geom in the frame of its object; bodies between the two move with the object."""
    if item.element == "geom":
        return IDENTITY
    pose, body = _pose(model.geom_pos[geom], model.geom_quat[geom]), int(model.geom_bodyid[geom])
    while body not in (item.body, 0):
        pose = compose(_pose(model.body_pos[body], model.body_quat[body]), pose)
        body = int(model.body_parentid[body])
    return pose


def _pose(place: Array, turn: Array) -> Pose:
    x, y, z = place.tolist()
    w, i, j, k = turn.tolist()
    return (x, y, z), (w, i, j, k)


def half_sides_of_site(model: mujoco.MjModel, site: int) -> list[float]:
    """Return half the sides of a site's box in its own frame; sizes have the same meaning as a geom's."""
    radius, half_length, _ = size = model.site_size[site].tolist()
    match mujoco.mjtGeom(int(model.site_type[site])):
        case mujoco.mjtGeom.mjGEOM_SPHERE:
            return [radius, radius, radius]
        case mujoco.mjtGeom.mjGEOM_CAPSULE:
            return [radius, radius, radius + half_length]
        case mujoco.mjtGeom.mjGEOM_CYLINDER:
            return [radius, radius, half_length]
        case _:
            return size


def _reach(model: mujoco.MjModel, geom: int, rotation: Array) -> tuple[Array, Array]:
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


def _mesh_reach(model: mujoco.MjModel, mesh: int, rotation: Array) -> tuple[Array, Array]:
    start = int(model.mesh_vertadr[mesh])
    vertices = model.mesh_vert[start : start + int(model.mesh_vertnum[mesh])] @ rotation.T
    return vertices.min(axis=0), vertices.max(axis=0)
