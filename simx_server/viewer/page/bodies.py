"""One body in the browser: its geoms as meshes below a frame that moves."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import mujoco
import numpy as np
import trimesh
import viser
from mjviser.conversions import group_geoms_by_visual_compat, merge_geoms

_SELECTED = (255, 140, 0)
_MOVED = 1e-5
"""Metres, or a unit quaternion's difference, below which nothing is sent."""

_FIRST_HIDDEN_GROUP = 3
"""Geoms of this group and above only collide; MuJoCo's own viewer leaves them out, too."""

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
    """What of a body is to be seen, in the body's frame; those of one texture are one mesh."""
    first, count = int(model.body_geomadr[body]), int(model.body_geomnum[body])
    seen = [geom for geom in range(first, first + count) if _is_seen(model, geom)]
    for group in group_geoms_by_visual_compat(model, seen):
        yield merge_geoms(model, group)


def _is_seen(model: mujoco.MjModel, geom: int) -> bool:
    material = int(model.geom_matid[geom])
    alpha = float(model.geom_rgba[geom, 3] if material < 0 else model.mat_rgba[material, 3])
    return (
        alpha > 0
        and int(model.geom_group[geom]) < _FIRST_HIDDEN_GROUP
        and int(model.geom_type[geom]) in _CONVERTED
    )


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
        self._position, self._quat = np.full(3, np.nan), np.full(4, np.nan)

    def on_click(self, act: Callable[[int], None]) -> None:
        """`act` is given the body's number, on a thread of viser's."""
        for mesh in self._meshes:
            mesh.on_click(lambda _: act(self._number))

    def move(self, data: mujoco.MjData) -> None:
        """To where it is in `data`; nothing is sent when it is there already."""
        position, quat = data.xpos[self._number], data.xquat[self._number]
        if not np.allclose(position, self._position, rtol=0, atol=_MOVED):
            self._position = position.copy()
            self._frame.position = self._position
        if not np.allclose(quat, self._quat, rtol=0, atol=_MOVED):
            self._quat = quat.copy()
            self._frame.wxyz = self._quat

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
        self._frame.remove()  # with all that is below it


def _edges(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """The twelve edges of a box: (12, 2, 3)."""
    corners = np.array([[(low, high)[(index >> axis) & 1][axis] for axis in range(3)] for index in range(8)])
    pairs = [(one, one | 1 << axis) for one in range(8) for axis in range(3) if not one & 1 << axis]
    return corners[np.array(pairs)]
