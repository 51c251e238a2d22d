"""State spaces of joints, and projections of states on points with few coordinates."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from simx_server.errors import CommandError
from simx_server.kinematics.planning.states import Projection, SpaceKind, StateSpace
from simx_server.scripting.interpreter import Function

from .ompl_tasks import OmplTasks, numbers_of

_PROJECTED = {
    SpaceKind.POSITION2D: 2,
    SpaceKind.POSE2D: 2,
    SpaceKind.DUBINS: 2,
    SpaceKind.POSITION3D: 3,
    SpaceKind.POSE3D: 3,
    SpaceKind.JOINT: 1,
}
"""Coordinates at the start of a space's states that belong to the default projection."""

_MOST_PROJECTED = 100


class OmplSpaces(OmplTasks, effect="changes"):
    """Functions for state spaces of joints, and for projections."""

    def createStateSpaceForJoint(
        self, name: str, joint: int, use_for_projection: int = 0, weight: float = 1.0
    ) -> int:
        """Create the state space of a joint, with its interval as bounds."""
        cyclic, low, extent = self._sim.joints.interval(self._self(joint))
        if cyclic:
            low, extent = -math.pi, 2 * math.pi
        if weight <= 0:
            raise CommandError("a weight is above 0")
        space = StateSpace(
            name,
            SpaceKind.JOINT,
            self._self(joint),
            (low,),
            (low + extent,),
            weight,
            is_projected=bool(use_for_projection),
        )
        return self._add(self._spaces, space)

    def setStateSpaceForJoints(
        self,
        task: int,
        joints: list[int],
        use_for_projection: list[int] | None = None,
        weights: list[float] | None = None,
    ) -> bool:
        """Give a task a space for each joint. Without `use_for_projection` the first three are projected on."""
        chosen = self._task(task)
        flags = use_for_projection or [int(index < 3) for index in range(len(joints))]
        factors = weights or [1.0] * len(joints)
        if not len(joints) == len(flags) == len(factors):
            raise CommandError(
                f"{len(joints)} joints need as many flags and weights, not {len(flags)} and {len(factors)}"
            )
        handles = [
            self.createStateSpaceForJoint(f"{chosen.name}_joint_{index}", *each)
            for index, each in enumerate(zip(joints, flags, factors, strict=True), 1)
        ]
        self._set_spaces(task, [self._space(handle) for handle in handles])
        return True

    def getStateSpaceDimension(self, task: int) -> int:
        """Return the number of coordinates of a state."""
        return self._task(task).count

    def enforceBounds(self, task: int, state: list[float]) -> list[float]:
        """Return the nearest state within the bounds; angles without an end become those from -pi to pi."""
        values, space = np.array(self._state(task, state)), self._solving(task).space
        turned = np.remainder(values + np.pi, 2 * np.pi) - np.pi
        values = np.where(space.endless, turned, values)
        inside = [False] * len(values)
        for part in space.quaternions:
            inside[part] = [True] * 4
        clipped = np.clip(values, space.low, space.high)
        return space.normalised(np.where(inside, values, clipped)).tolist()

    def setProjectionEvaluationCallback(self, task: int, callback: str | Function, size: int) -> bool:
        """Set a function(state) that returns a point with `size` coordinates, in place of the default projection.

        Partly: a search does not use projections; OMPL's algorithms choose theirs.
        """
        if not 1 <= size <= _MOST_PROJECTED:
            raise CommandError(f"a projection has 1 to {_MOST_PROJECTED} coordinates, not {size}")
        function = self._function(callback)

        def project(state: list[float]) -> list[float]:
            found = numbers_of(function(state), "a projection")
            if len(found) != size:
                raise CommandError(f"the projection returns {size} numbers, not {len(found)}")
            return found

        self._task(task).projection = Projection(project, size)
        return True

    def projectionSize(self, task: int) -> int:
        """Return the number of coordinates of a projected state."""
        chosen = self._task(task)
        if chosen.projection is not None:
            return chosen.projection.size
        return sum(_PROJECTED[space.kind] for space in chosen.spaces if space.is_projected)

    def projectStates(self, task: int, states: list[float]) -> list[float]:
        """Return the projections of one or more states, one after the other. The default projection is the positions
        of the spaces that were created with a flag for it.
        """
        return self._projected(task, states).ravel().tolist()

    def getProjectedPathLength(self, task: int, path: list[float]) -> float:
        """Return the length of a path that is projected."""
        steps = np.diff(self._projected(task, path), axis=0)
        return float(np.linalg.norm(steps, axis=1).sum())

    def _projected(self, task: int, states: list[float]) -> NDArray[np.float64]:
        """Return the projections of states, (states, coordinates)."""
        chosen = self._task(task)
        if chosen.projection is not None:
            rows = self._rows(task, states)
            return np.array([chosen.projection.function(state) for state in rows], float)
        count = self._count_of(task, states)
        columns: list[int] = []
        at = 0
        for space in chosen.spaces:
            if space.is_projected:
                columns += range(at, at + _PROJECTED[space.kind])
            at += space.count
        return np.array(states, float).reshape(-1, count)[:, columns]
