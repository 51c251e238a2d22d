"""Readings of sensors in the 3-D view: rays of proximity sensors, forces at force sensors."""

from __future__ import annotations

import numpy as np
import viser

from simx_server.viewer.messages import Sensing

_FREE, _HIT = (120, 160, 120), (230, 80, 20)
_FORCE = (120, 40, 200)
FORCE_LENGTH = 0.01
"""Metres of an arrow for each newton."""

LONGEST_ARROW = 0.5
_SHORTEST_ARROW = 1e-4


class Sensors:
    """Lines and arrows, made again when they change."""

    def __init__(self, scene: viser.SceneApi, gui: viser.GuiApi) -> None:
        self._scene = scene
        self._rays_are_on = gui.add_checkbox(
            "Proximity rays",
            False,
            hint="from each proximity sensor to the point that it detects, else its reach",
        )
        self._forces_are_on = gui.add_checkbox(
            "Forces at sensors", False, hint=f"of force sensors, {FORCE_LENGTH * 100:g} cm for each newton"
        )
        self._drawn: dict[str, tuple[bytes, viser.SceneNodeHandle]] = {}

    @property
    def are_wanted(self) -> bool:
        """Return whether readings are shown."""
        return self._rays_are_on.value or self._forces_are_on.value

    def update(self, sensing: Sensing | None) -> None:
        """Show these readings; None: none."""
        rays = sensing["rays"] if sensing and self._rays_are_on.value else []
        for name, colour, detects in (("free", _FREE, False), ("hit", _HIT, True)):
            lines = [[ray["start"], ray["end"]] for ray in rays if ray["detects"] is detects]
            self._draw(name, np.array(lines, np.float32).reshape(-1, 2, 3), colour)
        forces = sensing["forces"] if sensing and self._forces_are_on.value else []
        self._draw("force", arrows(forces), _FORCE)

    def _draw(self, name: str, points: np.ndarray, colour: tuple[int, int, int]) -> None:
        content = points.tobytes()
        before = self._drawn.get(name)
        if (before[0] if before else b"") == content:
            return
        if before is not None:
            self._drawn.pop(name)[1].remove()
        if not len(points):
            return
        path = f"/sensors/{name}"
        if name == "force":
            node = self._scene.add_arrows(
                path, points, colour, shaft_radius=0.004, head_radius=0.01, head_length=0.02
            )
        else:
            node = self._scene.add_line_segments(
                path, points, colour, thickness=2.0, thickness_units="screen"
            )
        self._drawn[name] = content, node


def arrows(forces: list[list[float]]) -> np.ndarray:
    """Return arrows, shape (N, 2, 3): start and end in the world; forces are positions and newtons."""
    drawn: list[np.ndarray] = []
    for numbers in forces:
        start, arrow = np.array(numbers[:3]), np.array(numbers[3:]) * FORCE_LENGTH
        if (length := float(np.linalg.norm(arrow))) > _SHORTEST_ARROW:
            drawn.append(np.stack([start, start + arrow * min(1.0, LONGEST_ARROW / length)]))
    return np.array(drawn, np.float32).reshape(-1, 2, 3)
