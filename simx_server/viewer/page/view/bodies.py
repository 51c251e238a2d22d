"""Show one body in the browser: its meshes below a frame that moves."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import trimesh
import viser

_SELECTED = (255, 140, 0)

_SHADOW = 0.35
"""Darkness of a shadow, the same for all lights: viser spreads a light over three, each with its own shadow."""


class Body:
    """One body; `number` is its id in the model."""

    def __init__(
        self,
        scene: viser.SceneApi,
        number: int,
        meshes: Sequence[trimesh.Trimesh],
        *,
        is_ground: bool = False,
    ) -> None:
        self._scene, self._number = scene, number
        self._path = f"/scene/body_{number}"
        self._frame = scene.add_frame(self._path, show_axes=False)
        clear = [mesh for mesh in meshes if _lets_see_through(mesh)]
        opaque = [mesh for mesh in meshes if not _lets_see_through(mesh)]
        parts = [(opaque, True)] if opaque else []
        self._meshes = [
            scene.add_glb(
                f"{self._path}/mesh_{index}",
                _glb(part),
                cast_shadow=casts and not is_ground,
                receive_shadow=_SHADOW if is_ground else False,
            )
            for index, (part, casts) in enumerate([*parts, *(([mesh], False) for mesh in clear)])
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


def _lets_see_through(mesh: trimesh.Trimesh) -> bool:
    material: Any = getattr(mesh.visual, "material", None)  # trimesh declares little of it
    return getattr(material, "alphaMode", None) == "BLEND"


def _glb(meshes: Sequence[trimesh.Trimesh]) -> bytes:
    """Return meshes as one file, which the browser shows as one object."""
    scene: Any = trimesh.Scene(list(meshes))
    content: bytes = scene.export(file_type="glb", include_normals=True)
    return content


def _edges(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return the twelve edges of a box, shape (12, 2, 3)."""
    corners = np.array([[(low, high)[(index >> axis) & 1][axis] for axis in range(3)] for index in range(8)])
    pairs = [(one, one | 1 << axis) for one in range(8) for axis in range(3) if not one & 1 << axis]
    return corners[np.array(pairs)]
