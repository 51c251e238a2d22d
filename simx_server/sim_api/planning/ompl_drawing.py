"""Drawings of ``simOMPL``: CoppeliaSim wrote these functions in Lua."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

from simx_client.protocol import constants as c
from simx_server.kinematics.planning.tasks import SpaceKind
from simx_server.sim_api.looks.drawing import as_color

from .ompl_tasks import OmplTasks

_COORDINATES = {
    SpaceKind.POSITION2D: 2,
    SpaceKind.POSE2D: 2,
    SpaceKind.POSITION3D: 3,
    SpaceKind.POSE3D: 3,
}
"""Number of coordinates at the start of a state of this kind."""


class OmplDrawing(OmplTasks):
    """Functions that draw paths into the scene, for its viewers."""

    def drawPath(
        self, task: int, path: list[float], width: float, color: list[float], _more: Any = None
    ) -> list[int]:
        """Draw the positions of a path's states as a line; return the drawing objects. A path of joints has none."""
        chosen = self._task(task)
        known = _COORDINATES.get(chosen.spaces[0].kind) if chosen.spaces else None
        if known is None:
            return []
        drawing = self._world.drawings.create(
            c.sim_drawing_lines,
            width,
            0.0,
            -1,
            0,
            as_color(color, (0.0, 0.0, 0.0)),
            outlives_run=not self._script.is_of_run,
        )
        ends = range(0, len(path) - chosen.count + 1, chosen.count)
        places = [[*path[start : start + known], 0.0][:3] for start in ends]
        for before, after in pairwise(places):
            self._world.drawings.draw(drawing, [*before, *after])
        return [drawing]

    def getPlannerData(self, task: int) -> tuple[list[float], list[int], list[float], list[int], list[int]]:
        """Return the states that a search has tried, and how they are joined. Stand-in: none are kept."""
        self._task(task)
        self._say_once("simOMPL keeps no states of its searches, so they are neither returned nor drawn")
        return [], [], [], [], []

    def drawPlannerData(self, task: int, *_how: Any) -> list[int]:
        """Draw what simOMPL.getPlannerData returns. Stand-in: nothing."""
        self.getPlannerData(task)
        return []

    def removeDrawingObjects(self, task: int, drawings: list[int]) -> None:
        """Remove the drawing objects of simOMPL.drawPath."""
        self._task(task)
        for each in drawings:
            self._world.drawings.remove(each)
