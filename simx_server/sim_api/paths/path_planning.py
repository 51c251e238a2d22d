"""Path planning of V-REP 3: tasks that the scene registers write a path for a robot into a path object."""

from __future__ import annotations

from simx_server.kinematics.planning.scene_tasks.path_plannings import Outcome
from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.effects import reads


class PathPlanningFunctions(ApiPart, effect="changes"):
    """Functions for path planning tasks; a text simx:planning:NAME registers one."""

    @reads
    def getPathPlanningHandle(self, name: str) -> int:
        return self._world.path_plannings.find(self._adjusted(name))

    def searchPath(self, task: int, seconds: float = 0.0, _step: float = 0.0) -> int:
        """Search a path for at most this wall time, 0 for that of the task; return 2 when one was found, else 0. The
        path object then has it.

        Partly: paths lead all the way or fail, and are as near to obstacles as they can be.
        """
        with self._at_no_cost():
            found = self._world.path_plannings.search(self._world, task, seconds)
        return int(Outcome.FOUND if found else Outcome.FAILED)

    def initializePathSearch(self, task: int, seconds: float, step: float) -> int:
        """Start a search that lasts for at most this wall time, and return its number. Each step takes about `step`
        seconds of wall time.
        """
        return self._world.path_plannings.begin(self._world, task, seconds, step)

    def performPathSearchStep(self, search: int, abort: bool = False) -> int:
        """Make a step of a search, or end it: return 2 when a path was found, 0 when the search has failed or was
        ended, -2 when it goes on. Partly: as sim.searchPath.
        """
        if abort:
            self._world.path_plannings.end(search)
            return int(Outcome.FAILED)
        with self._at_no_cost():
            return int(self._world.path_plannings.go_on(self._world, search))
