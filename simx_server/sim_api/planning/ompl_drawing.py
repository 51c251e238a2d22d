"""Drawings of ``simOMPL``: CoppeliaSim wrote these functions in Lua."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

from simx_client.protocol import constants as c
from simx_server.kinematics.planning.states import SpaceKind
from simx_server.sim_api.effects import reads
from simx_server.sim_api.looks.drawing import as_color

from .ompl_tasks import OmplTasks

_COORDINATES = {
    SpaceKind.POSITION2D: 2,
    SpaceKind.POSE2D: 2,
    SpaceKind.DUBINS: 2,
    SpaceKind.POSITION3D: 3,
    SpaceKind.POSE3D: 3,
}
"""Number of coordinates at the start of a state of this kind."""


class OmplDrawing(OmplTasks, effect="changes"):
    """Functions that draw paths into the scene, for its viewers."""

    def drawPath(
        self, task: int, path: list[float], width: float, color: list[float], _more: Any = None
    ) -> list[int]:
        """Draw the positions of a path's states as a line; return the drawing objects. A path of joints has none."""
        places = self._places(task, self._rows(task, path))
        if not places:
            return []
        drawing = self._drawing(c.sim_drawing_lines, width, color)
        for before, after in pairwise(places):
            self._world.drawings.draw(drawing, [*before, *after])
        return [drawing]

    @reads
    def getPlannerData(
        self, task: int
    ) -> tuple[list[float], list[int], list[float], list[int], list[float], list[int], list[int]]:
        """Return the states that the last search has reached, one after the other; two tags of each, 0; the edges, by
        the indices of their ends, from 0; their lengths; the indices of starts and of goals. OMPL's
        BITstar gives none.
        """
        graph, solving = self._task(task).graph, self._solving(task)
        states, count = graph.states, len(graph.states)
        lengths = [solving.space.line(states[a], states[b]).length for a, b in graph.edges]
        return (
            [value for state in states for value in state.tolist()],
            [0] * count,
            [0.0] * count,
            [end for edge in graph.edges for end in edge],
            lengths,
            list(graph.starts),
            list(graph.goals),
        )

    def drawPlannerData(
        self,
        task: int,
        point_size: float,
        width: float,
        color: list[float],
        start_color: list[float] | None = None,
        goal_color: list[float] | None = None,
    ) -> list[int]:
        """Draw the positions of the states that the last search has reached as spheres, with lines between them;
        return the drawing objects. A search with joints alone has none.
        """
        graph = self._task(task).graph
        places = self._places(task, [state.tolist() for state in graph.states])
        if not places:
            return []
        lines = self._drawing(c.sim_drawing_lines, width, color)
        for first, last in graph.edges:
            self._world.drawings.draw(lines, [*places[first], *places[last]])
        ends = {*graph.starts, *graph.goals}
        others = [index for index in range(len(places)) if index not in ends]
        kinds = ((others, color), (graph.starts, start_color or color), (graph.goals, goal_color or color))
        drawn = [lines]
        for indices, shade in kinds:
            drawn.append(self._drawing(c.sim_drawing_spherepoints, point_size, shade))
            for index in indices:
                self._world.drawings.draw(drawn[-1], places[index])
        return drawn

    def _places(self, task: int, states: list[list[float]]) -> list[list[float]]:
        """Return the positions x, y, z of states; none for a task whose first space has no position."""
        spaces = self._task(task).spaces
        known = _COORDINATES.get(spaces[0].kind) if spaces else None
        return [] if known is None else [[*state[:known], 0.0][:3] for state in states]

    def _drawing(self, kind: int, size: float, color: list[float]) -> int:
        return self._world.drawings.create(
            kind,
            size,
            0.0,
            -1,
            0,
            as_color(color, (0.0, 0.0, 0.0)),
            outlives_run=not self._script.is_of_run,
        )

    def removeDrawingObjects(self, task: int, drawings: list[int]) -> None:
        """Remove the drawing objects of simOMPL.drawPath and simOMPL.drawPlannerData."""
        self._task(task)
        for each in drawings:
            self._world.drawings.remove(each)
