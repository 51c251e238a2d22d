"""Appearance of a shape: its triangles, its primitive type."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.errors import CommandError
from simx_server.scene.geometry.triangles import corners_of
from simx_server.scene.objects import ObjectKind
from simx_server.scene.poses import frames
from simx_server.scene.poses.poses import matrix

if TYPE_CHECKING:
    from simx_server.world.world import World

_GEOM = mujoco.mjtGeom
_PURE: dict[int, int] = {
    int(_GEOM.mjGEOM_PLANE): 1,
    int(_GEOM.mjGEOM_BOX): 3,
    int(_GEOM.mjGEOM_SPHERE): 4,
    int(_GEOM.mjGEOM_ELLIPSOID): 4,
    int(_GEOM.mjGEOM_CYLINDER): 5,
    int(_GEOM.mjGEOM_HFIELD): 7,
    int(_GEOM.mjGEOM_CAPSULE): 8,
}
"""`sim_pure_primitive_*` by type of geom; 0 is none."""


def geoms_of(world: World, handle: int) -> list[int]:
    """Return the ids of a shape's geoms. Raises UnknownHandle, WrongKind."""
    world.simulation.scene.get_kind(handle, ObjectKind.SHAPE)
    return world.instants.now(with_points=False).geoms_of([handle]).tolist()


def triangles(world: World, handle: int) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return points (n, 3) in the shape's frame, metres, and faces (m, 3) of their indices.

    Curved primitives are faceted. Raises UnknownHandle, WrongKind, CommandError: an infinite plane.
    """
    sim = world.simulation
    sim.scene.get_kind(handle, ObjectKind.SHAPE)
    geoms = world.instants.now(with_points=False).geoms_of([handle]).tolist()
    return indexed(np.concatenate([part_corners(world, handle, geom) for geom in geoms]))


def part_corners(world: World, handle: int, geom: int) -> NDArray[np.float64]:
    """Return the triangles (n, 3, 3) of a geom of a shape in the shape's frame, metres; those of a mesh in its order.

    Curved primitives are faceted. Raises CommandError: an infinite plane.
    """
    sim, instant = world.simulation, world.instants.now(with_points=False)
    if sim.model.geom_type[geom] == _GEOM.mjGEOM_PLANE.value:
        raise CommandError(f"'{sim.scene.get(handle).name}' is a plane, which has no triangles")
    position, quat = frames.get_pose(sim, handle)
    corners = corners_of(sim.model, geom)
    placed = corners @ instant.geom_xmat[geom].reshape(3, 3).T + instant.geom_xpos[geom]
    return (placed - np.array(position)) @ np.array(matrix(quat))


def indexed(corners: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return the different points (n, 3) of triangles (m, 3, 3), and faces (m, 3) of their indices."""
    points, index = np.unique(corners.reshape(-1, 3).round(9), axis=0, return_inverse=True)
    return points, index.reshape(-1, 3).astype(np.int64)


def normals(points: NDArray[np.float64], faces: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the unit normals (m, 3) of faces (m, 3); zeros for a face without area."""
    corners = points[faces]
    found = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(found, axis=1, keepdims=True)
    return np.divide(found, lengths, out=np.zeros_like(found), where=lengths > 0)


@dataclass(frozen=True, slots=True)
class PartTexture:
    """The texture of a mesh."""

    number: int
    """MuJoCo's id."""
    pixels: NDArray[np.uint8]
    """(rows, columns, 4) red, green, blue and 255; the first row has v = 0."""
    coordinates: NDArray[np.float32]
    """(m, 3, 2) u and v of the corners of each face."""


def part_texture(model: mujoco.MjModel, geom: int) -> PartTexture | None:
    """Return the texture of a geom that is a mesh with texture coordinates."""
    material, mesh = int(model.geom_matid[geom]), int(model.geom_dataid[geom])
    if material < 0 or model.geom_type[geom] != _GEOM.mjGEOM_MESH.value or model.mesh_texcoordadr[mesh] < 0:
        return None
    number = int(model.mat_texid[material, int(mujoco.mjtTextureRole.mjTEXROLE_RGB)])
    if number < 0 or model.tex_type[number] != mujoco.mjtTexture.mjTEXTURE_2D.value:
        return None
    size = (int(model.tex_height[number]), int(model.tex_width[number]), int(model.tex_nchannel[number]))
    start = int(model.tex_adr[number])
    texels = model.tex_data[start : start + math.prod(size)].reshape(size)
    pixels = np.full((*size[:2], 4), 255, np.uint8)
    pixels[..., :3] = texels[..., :3]
    first, count = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
    places = int(model.mesh_texcoordadr[mesh]) + model.mesh_facetexcoord[first : first + count]
    return PartTexture(number, pixels, model.mesh_texcoord[places])


def pure_type(world: World, handle: int) -> tuple[int, list[float]]:
    """Return `sim_pure_primitive_*` of a shape of one primitive, and its sizes (m); 0 and zeros for others.

    Raises UnknownHandle, WrongKind.
    """
    sim = world.simulation
    geoms = geoms_of(world, handle)
    if len(geoms) != 1:
        return 0, [0.0] * 3
    kind, size = int(sim.model.geom_type[geoms[0]]), sim.model.geom_size[geoms[0]].tolist()
    match mujoco.mjtGeom(kind):
        case _GEOM.mjGEOM_SPHERE:
            size = [size[0]] * 3
        case _GEOM.mjGEOM_CYLINDER:
            size = [size[0], size[0], size[1]]
        case _GEOM.mjGEOM_CAPSULE:
            size = [size[0], size[0], size[1] + size[0]]
        case _GEOM.mjGEOM_HFIELD:
            size = sim.model.hfield_size[sim.model.geom_dataid[geoms[0]]].tolist()
            size = [size[0], size[1], size[2] / 2]
        case _:  # their sizes are those that V-REP has
            pass
    number = _PURE.get(kind, 0)
    return number, [2 * half for half in size[:3]] if number else [0.0] * 3


def is_convex(world: World, handle: int) -> bool:
    """Return whether all parts of a shape are convex. Raises UnknownHandle, WrongKind."""
    surroundings = world.instants.now(with_points=False).surroundings
    return all(surroundings.triangles.is_solid(geom) for geom in geoms_of(world, handle))
