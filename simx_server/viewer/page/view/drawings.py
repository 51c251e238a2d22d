"""Show drawing objects in the browser: points, lines and triangles that scripts draw."""

from __future__ import annotations

import numpy as np
import viser

from simx_server.parts.drawing import CYCLIC, LINES, STRIP, TRIANGLES
from simx_server.viewer.messages import Drawing

_KIND = 0x1F
_PATH = "/drawings"
_POINT_SIZE = 0.008
"""Metres; V-REP gives sizes of points in pixels of its window, which does not exist here."""


class Drawings:
    """All drawing objects, made again after each change."""

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self.frame = scene.add_frame(_PATH, show_axes=False)
        """The parent frame of all of them, which hides and shows them."""

    def update(self, drawings: list[Drawing]) -> None:
        """Show these, and no others."""
        is_visible = self.frame.visible
        self.frame.remove()
        self.frame = self._scene.add_frame(_PATH, show_axes=False, visible=is_visible)
        for drawing in drawings:
            if drawing["items"]:
                self._draw(drawing)

    def _draw(self, drawing: Drawing) -> None:
        path = f"{_PATH}/{drawing['handle']}"
        color = np.clip(drawing["color"], 0.0, 1.0)
        count = drawing["points"]
        places = np.array([item[: 3 * count] for item in drawing["items"]], np.float32).reshape(-1, count, 3)
        kind = drawing["flags"] & _KIND
        if kind == LINES:
            self._add_lines(path, places, drawing)
        elif kind == STRIP:
            joined = places[:, 0]
            ends = np.roll(joined, -1, axis=0) if drawing["flags"] & CYCLIC else joined[1:]
            pairs = np.stack([joined[: len(ends)], ends], axis=1)
            if len(pairs):
                self._add_lines(path, pairs, drawing)
        elif kind == TRIANGLES:
            corners = places.reshape(-1, 3)
            faces = np.arange(len(corners), dtype=np.uint32).reshape(-1, 3)
            self._scene.add_mesh_simple(path, corners, faces, color=color, side="double")
        else:
            # For kinds that are bodies at points (spheres, cubes, discs) the size is in metres, for plain points in
            # pixels.
            size = drawing["size"] if kind else _POINT_SIZE
            self._scene.add_point_cloud(path, places[:, 0], color, point_size=size, point_shape="circle")

    def _add_lines(self, path: str, places: np.ndarray, drawing: Drawing) -> None:
        """Add lines, whose size is a width in pixels."""
        color, width = np.clip(drawing["color"], 0.0, 1.0), max(1.0, drawing["size"])
        self._scene.add_line_segments(path, places, color, thickness=width, thickness_units="screen")
