"""Show one body in the browser: its geoms as meshes below a frame that moves."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import mujoco
import numpy as np
import trimesh
import trimesh.visual
import viser
from mjviser.conversions import get_geom_texture_id, group_geoms_by_visual_compat, merge_geoms
from PIL import Image

from simx_server.scene.cameras.visibility import OPAQUE_ALPHA

from .smoothing import smoothed

_SELECTED = (255, 140, 0)
_DEFAULT_RGBA = (0.5, 0.5, 0.5, 1.0)
_ENDLESS = 20.0
"""Half the side in metres at which an infinite plane is drawn."""

_GAMMA = 2.2
"""Exponent from colours of the screen to linear ones."""

_SEEN_GROUPS = (0, 1, 2, 6)
"""Geoms of other groups only collide; the last group is that of shapes which vision sensors do not see."""

_CONVERTED = frozenset(
    int(kind)
    for kind in (
        mujoco.mjtGeom.mjGEOM_PLANE,
        mujoco.mjtGeom.mjGEOM_HFIELD,
        mujoco.mjtGeom.mjGEOM_SPHERE,
        mujoco.mjtGeom.mjGEOM_CAPSULE,
        mujoco.mjtGeom.mjGEOM_ELLIPSOID,
        mujoco.mjtGeom.mjGEOM_CYLINDER,
        mujoco.mjtGeom.mjGEOM_BOX,
        mujoco.mjtGeom.mjGEOM_MESH,
    )
)


def meshes_of(model: mujoco.MjModel, body: int) -> Iterator[trimesh.Trimesh]:
    """Yield the visible meshes of a body, in the body's frame; opaque geoms without a texture are one mesh."""
    first, count = int(model.body_geomadr[body]), int(model.body_geomnum[body])
    seen = [geom for geom in range(first, first + count) if _is_seen(model, geom)]
    papered = {geom: texture for geom in seen if (texture := _paper(model, geom)) >= 0}
    for geom, texture in papered.items():
        yield _papered_plane(model, geom, texture)
    plain = [geom for geom in seen if geom not in papered]
    with _own_colors(model, plain):
        for group in group_geoms_by_visual_compat(model, plain):
            # Merged textures would be parts of one image, and could not be repeated.
            if get_geom_texture_id(model, group[0]) >= 0:
                for geom in group:
                    yield _in_linear_colors(smoothed(merge_geoms(model, [geom])))
                continue
            if opaque := [geom for geom in group if _rgba(model, geom)[3] >= OPAQUE_ALPHA]:
                yield smoothed(merge_geoms(model, opaque))
            for geom in group:
                if geom not in opaque:
                    yield _see_through(smoothed(merge_geoms(model, [geom])), _rgba(model, geom))


def _see_through(mesh: trimesh.Trimesh, rgba: np.ndarray) -> trimesh.Trimesh:
    """Return the mesh with a material that lets see through: colours of its points do not."""
    material = trimesh.visual.material.PBRMaterial(
        baseColorFactor=np.asarray(rgba, float), metallicFactor=0.0, roughnessFactor=1.0
    )
    mesh.visual = trimesh.visual.TextureVisuals(material=material)
    return _in_linear_colors(mesh)


def _in_linear_colors(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """Return the mesh; the colour by which its texture is multiplied is now in glTF's linear numbers."""
    material: Any = getattr(mesh.visual, "material", None)  # trimesh declares little of it
    factor = getattr(material, "baseColorFactor", None)
    if factor is not None:
        rgba = np.asarray(factor, float) / 255
        material.baseColorFactor = [*rgba[:3] ** _GAMMA, rgba[3]]
        if rgba[3] < 1:
            material.alphaMode = "BLEND"
    return mesh


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
    of_materials = (model.mat_rgba, model.mat_texid, model.mat_texrepeat)
    return b"".join(
        [each[geoms].tobytes() for each in parts]
        + [each[materials[materials >= 0]].tobytes() for each in of_materials]
    )


def _is_seen(model: mujoco.MjModel, geom: int) -> bool:
    return (
        _rgba(model, geom)[3] > 0
        and int(model.geom_group[geom]) in _SEEN_GROUPS
        and int(model.geom_type[geom]) in _CONVERTED
    )


def _has_own_color(model: mujoco.MjModel, geom: int) -> bool:
    """Return whether a geom has its own colour: MuJoCo uses the material's while the own one is the default."""
    return int(model.geom_matid[geom]) < 0 or not np.allclose(model.geom_rgba[geom], _DEFAULT_RGBA)


def _rgba(model: mujoco.MjModel, geom: int) -> np.ndarray:
    return model.geom_rgba[geom] if _has_own_color(model, geom) else model.mat_rgba[model.geom_matid[geom]]


@contextmanager
def _own_colors(model: mujoco.MjModel, geoms: Sequence[int]) -> Generator[None]:
    """Remove the material of geoms with their own colour within the block: the converter prefers the material."""
    kept = model.geom_matid.copy()
    for geom in geoms:
        if _has_own_color(model, geom):
            model.geom_matid[geom] = -1
    try:
        yield
    finally:
        model.geom_matid[:] = kept


def _paper(model: mujoco.MjModel, geom: int) -> int:
    """Return the texture of a plane, which the converter leaves out; -1 if it has none."""
    material = int(model.geom_matid[geom])
    if material < 0 or int(model.geom_type[geom]) != mujoco.mjtGeom.mjGEOM_PLANE.value:
        return -1
    texture = int(model.mat_texid[material, mujoco.mjtTextureRole.mjTEXROLE_RGB])
    flat = mujoco.mjtTexture.mjTEXTURE_2D
    is_color = texture >= 0 and int(model.tex_type[texture]) == flat and int(model.tex_nchannel[texture]) == 3
    return texture if is_color else -1


def _papered_plane(model: mujoco.MjModel, geom: int, texture: int) -> trimesh.Trimesh:
    """Return a rectangle with an image, repeated as the material defines."""
    material = int(model.geom_matid[geom])
    half = np.where(model.geom_size[geom, :2] > 0, model.geom_size[geom, :2], _ENDLESS)
    unit = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], float)
    repeats = model.mat_texrepeat[material] * (2 * half if model.mat_texuniform[material] else 1.0)
    first, height, width = (int(a[texture]) for a in (model.tex_adr, model.tex_height, model.tex_width))
    pixels = model.tex_data[first : first + height * width * 3].reshape(height, width, 3)
    paper = trimesh.visual.material.PBRMaterial(
        baseColorFactor=_rgba(model, geom),
        baseColorTexture=Image.fromarray(np.ascontiguousarray(pixels[::-1])),
        metallicFactor=0.0,
        roughnessFactor=1.0,
    )
    mesh = trimesh.Trimesh(
        np.column_stack([unit * half, np.zeros(4)]),
        [[0, 1, 2], [0, 2, 3]],
        visual=trimesh.visual.TextureVisuals(uv=(unit + 1) / 2 * repeats, material=paper),
        process=False,
    )
    pose = np.eye(4)
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, model.geom_quat[geom])
    pose[:3, :3], pose[:3, 3] = turn.reshape(3, 3), model.geom_pos[geom]
    mesh.apply_transform(pose)  # pyright: ignore[reportUnknownMemberType]  # trimesh declares no result
    return _in_linear_colors(mesh)


class Body:
    """One body; `number` is its id in the model."""

    def __init__(self, scene: viser.SceneApi, number: int, meshes: Sequence[trimesh.Trimesh]) -> None:
        self._scene, self._number = scene, number
        self._path = f"/scene/body_{number}"
        self._frame = scene.add_frame(self._path, show_axes=False)
        self._meshes = [
            scene.add_mesh_trimesh(f"{self._path}/mesh_{index}", mesh) for index, mesh in enumerate(meshes)
        ]
        self._low = np.min([mesh.bounds[0] for mesh in meshes], axis=0)
        self._high = np.max([mesh.bounds[1] for mesh in meshes], axis=0)
        self._box: viser.LineSegmentsHandle | None = None

    def on_click(self, act: Callable[[int], None]) -> None:
        """Call `act` with the body's number after a click, on a thread of viser's."""
        for mesh in self._meshes:
            mesh.on_click(lambda _: act(self._number))

    def move(self, position: np.ndarray, quat_wxyz: np.ndarray) -> None:
        """Move the body to a pose in the world."""
        self._frame.position, self._frame.wxyz = position, quat_wxyz

    def mark(self, is_selected: bool) -> None:
        """Draw a box around it, or none."""
        if is_selected == (self._box is not None):
            return
        if self._box is not None:
            self._box.remove()
            self._box = None
            return
        margin = 0.02 * float(np.linalg.norm(self._high - self._low))
        edges = _edges(self._low - margin, self._high + margin)
        self._box = self._scene.add_line_segments(
            f"{self._path}/selected", edges, _SELECTED, thickness=2.0, thickness_units="screen"
        )

    def remove(self) -> None:
        self._frame.remove()  # with everything below it


def _edges(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return the twelve edges of a box, shape (12, 2, 3)."""
    corners = np.array([[(low, high)[(index >> axis) & 1][axis] for axis in range(3)] for index in range(8)])
    pairs = [(one, one | 1 << axis) for one in range(8) for axis in range(3) if not one & 1 << axis]
    return corners[np.array(pairs)]
