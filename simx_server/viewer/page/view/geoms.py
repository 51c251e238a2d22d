"""Make the meshes of one body for the browser: a mesh for each colour, texture and see-through geom.

The geometry of primitives is mjviser's; normals are the model's or those of `smoothing`, colours those of `tones`.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TypeVar

import mujoco
import numpy as np
import trimesh
import trimesh.visual
from mjviser.conversions import create_primitive_mesh
from numpy.typing import NDArray

from simx_server.scene.cameras.visibility import OPAQUE_ALPHA

from .materials import Look, look_of, textured
from .smoothing import SHARP, smoothed

T = TypeVar("T", bound=np.generic)

_ENDLESS = 20.0
"""Half the side in metres at which an infinite plane is drawn."""

_SEEN_GROUPS = (0, 1, 2, 6)
"""Geoms of other groups only collide; the last group is that of shapes which vision sensors do not see."""

_PLANE = int(mujoco.mjtGeom.mjGEOM_PLANE.value)
_MESH = int(mujoco.mjtGeom.mjGEOM_MESH.value)
_FIELD = int(mujoco.mjtGeom.mjGEOM_HFIELD.value)
_ROUND_AND_BOX = (
    mujoco.mjtGeom.mjGEOM_SPHERE,
    mujoco.mjtGeom.mjGEOM_CAPSULE,
    mujoco.mjtGeom.mjGEOM_ELLIPSOID,
    mujoco.mjtGeom.mjGEOM_CYLINDER,
    mujoco.mjtGeom.mjGEOM_BOX,
)
_CONVERTED = frozenset((_PLANE, _MESH, _FIELD, *(int(kind.value) for kind in _ROUND_AND_BOX)))


def meshes_of(model: mujoco.MjModel, body: int) -> Iterator[trimesh.Trimesh]:
    """Yield the visible meshes of a body, in the body's frame.

    Opaque geoms of one look are one mesh; each see-through geom is a mesh, so that the browser can sort them.
    """
    first, count = int(model.body_geomadr[body]), int(model.body_geomnum[body])
    groups: dict[tuple[Look, int], list[int]] = {}
    for geom in range(first, first + count):
        if int(model.geom_group[geom]) not in _SEEN_GROUPS or int(model.geom_type[geom]) not in _CONVERTED:
            continue
        look = look_of(model, geom)
        if look.rgba[3] > 0:
            is_opaque = look.rgba[3] >= OPAQUE_ALPHA
            groups.setdefault((look, -1 if is_opaque else geom), []).append(geom)
    for (look, _), geoms in groups.items():
        yield _joined([_in_body(model, geom, _shape(model, geom, look)) for geom in geoms], look)


def appearance(model: mujoco.MjModel, body: int) -> bytes:
    """Return a key that changes with everything that `meshes_of` depends on, in one model."""
    first, count = int(model.body_geomadr[body]), int(model.body_geomnum[body])
    geoms = slice(first, first + count)
    materials = model.geom_matid[geoms]
    parts = (
        model.geom_pos,
        model.geom_quat,
        model.geom_size,
        model.geom_rgba,
        model.geom_group,
        model.geom_matid,
    )
    of_materials = (
        model.mat_rgba, model.mat_texid, model.mat_texrepeat, model.mat_specular, model.mat_shininess,
        model.mat_emission,
    )  # fmt: skip
    return b"".join(
        [each[geoms].tobytes() for each in parts]
        + [each[materials[materials >= 0]].tobytes() for each in of_materials]
    )


def _joined(shapes: list[trimesh.Trimesh], look: Look) -> trimesh.Trimesh:
    """Return the shapes as one mesh with a look; only a single shape may have a texture."""
    begins = np.cumsum([0, *(len(shape.vertices) for shape in shapes[:-1])])
    uvs: list[NDArray[np.float64] | None] = [getattr(shape.visual, "uv", None) for shape in shapes]
    whole = [uv for uv in uvs if uv is not None]
    return trimesh.Trimesh(
        vertices=np.concatenate([shape.vertices for shape in shapes]),
        faces=np.concatenate([shape.faces + begin for shape, begin in zip(shapes, begins, strict=True)]),
        vertex_normals=np.concatenate([shape.vertex_normals for shape in shapes]),
        visual=textured(look, np.concatenate(whole) if len(whole) == len(shapes) else None),
        process=False,
    )


def _in_body(model: mujoco.MjModel, geom: int, shape: trimesh.Trimesh) -> trimesh.Trimesh:
    """Return the shape in the body's frame."""
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, model.geom_quat[geom])
    turn = turn.reshape(3, 3)
    return trimesh.Trimesh(
        vertices=shape.vertices @ turn.T + model.geom_pos[geom],
        faces=shape.faces,
        vertex_normals=shape.vertex_normals @ turn.T,
        visual=shape.visual,
        process=False,
    )


def _shape(model: mujoco.MjModel, geom: int, look: Look) -> trimesh.Trimesh:
    """Return a geom's shape in its own frame, with normals, and with places in the texture if it has one."""
    kind = int(model.geom_type[geom])
    if kind == _MESH:
        return _mesh(model, int(model.geom_dataid[geom]))
    if kind == _PLANE:
        shape = _plane(model, geom)
    else:
        shape = create_primitive_mesh(model, geom)
        shape.visual = trimesh.visual.ColorVisuals()
        shape = smoothed(shape)
    if look.texture is None:
        return shape
    # MuJoCo projects an image along the geom's z axis.
    size = model.geom_size[geom, :2] if kind != _FIELD else model.hfield_size[model.geom_dataid[geom], :2]
    half = np.where(size > 0, size, _ENDLESS)
    is_in_metres = bool(model.mat_texuniform[model.geom_matid[geom]]) | (size <= 0)
    repeats = model.mat_texrepeat[model.geom_matid[geom]] * np.where(is_in_metres, half, 1.0)
    shape.visual = trimesh.visual.TextureVisuals(uv=(shape.vertices[:, :2] / half + 1) / 2 * repeats)
    return shape


def _plane(model: mujoco.MjModel, geom: int) -> trimesh.Trimesh:
    half = np.where(model.geom_size[geom, :2] > 0, model.geom_size[geom, :2], _ENDLESS)
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], float) * half
    return trimesh.Trimesh(
        vertices=np.column_stack([corners, np.zeros(4)]),
        faces=[[0, 1, 2], [0, 2, 3]],
        vertex_normals=np.tile([0.0, 0.0, 1.0], (4, 1)),
        process=False,
    )


def _mesh(model: mujoco.MjModel, mesh: int) -> trimesh.Trimesh:
    """Return a mesh of the model with the normals of its file, or `smoothed` if they round its edges."""
    faces = _part(model.mesh_face, model.mesh_faceadr, model.mesh_facenum, mesh)
    points = _part(model.mesh_vert, model.mesh_vertadr, model.mesh_vertnum, mesh)[faces.ravel()]
    columns: list[NDArray[np.float64]] = [points.astype(float)]
    if model.mesh_texcoordnum[mesh] > 0:
        own = _part(model.mesh_facetexcoord, model.mesh_faceadr, model.mesh_facenum, mesh)
        uv = _part(model.mesh_texcoord, model.mesh_texcoordadr, model.mesh_texcoordnum, mesh)
        columns.append(uv[own.ravel()].astype(float))
    normals = _own_normals(model, mesh, points.reshape(-1, 3, 3))
    if normals is not None:
        columns.append(normals)
    corners, inverse = np.unique(np.column_stack(columns), axis=0, return_inverse=True)
    has_uv = model.mesh_texcoordnum[mesh] > 0
    shape = trimesh.Trimesh(
        vertices=corners[:, :3],
        faces=inverse.reshape(-1, 3),
        vertex_normals=None if normals is None else corners[:, -3:],
        visual=trimesh.visual.TextureVisuals(uv=corners[:, 3:5]) if has_uv else None,
        process=False,
    )
    return smoothed(shape) if normals is None else shape


def _own_normals(
    model: mujoco.MjModel, mesh: int, triangles: NDArray[np.float32]
) -> NDArray[np.float64] | None:
    """Return the normals of a mesh's corners (3 faces, 3), None if one is turned from its face by a sharp angle.

    A file of V-REP has normals for the shading angle of its shape; MuJoCo makes one for each point of a mesh without.
    """
    own = _part(model.mesh_facenormal, model.mesh_faceadr, model.mesh_facenum, mesh)
    normals = _part(model.mesh_normal, model.mesh_normaladr, model.mesh_normalnum, mesh)[own.ravel()]
    flat = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]).astype(float)
    lengths = np.linalg.norm(flat, axis=1)
    cosines = np.einsum("fci,fi->fc", normals.reshape(-1, 3, 3), flat)
    return normals.astype(float) if bool((cosines >= SHARP * lengths[:, None]).all()) else None


def _part(whole: NDArray[T], begins: NDArray[np.int32], counts: NDArray[np.int32], mesh: int) -> NDArray[T]:
    return whole[int(begins[mesh]) : int(begins[mesh]) + int(counts[mesh])]
