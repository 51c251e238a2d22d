"""Motion planning of V-REP 3 up to 3.2: tasks that the scene registers, for the joints of a robot and its tip."""

from __future__ import annotations

from collections.abc import Sequence

from simx_server.errors import CommandError
from simx_server.kinematics.planning.scene_tasks.planned_chain import PlannedChain, TipPath
from simx_server.scene.poses.frames import xyzw_from_wxyz
from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.effects import reads
from simx_server.sim_api.values.matrices import as_pose

_THROUGH_POSES = 512
"""Option of getMpConfigTransition: the tip moves on straight lines."""

_HIGHEST_BEHAVIOUR = 7
"""Greatest behaviour of a joint in getMpConfigTransition."""

_IGNORES_TURNS = 256
"""Option: the lengths of the tip's way leave its orientation out."""

Told = tuple[list[float], list[float], list[float], list[float], list[float]] | None
"""States in sequence, their lengths, positions and quaternions of the tip, and the lengths of its way."""


class MotionPlanningFunctions(ApiPart, effect="changes"):
    """Functions for motion planning tasks; a text simx:motion_planning:NAME registers one. A path is a table of
    configurations in sequence; with it come the distance of each configuration from the one before, positions and
    quaternions of the tip, and the tip's distances. Without a path the result is nil.

    Options are a sum: 16 the robot may touch itself, 32 it may touch obstacles, 256 distances of the tip leave its
    orientation out; those for drawing are ignored. Milliseconds of 0 mean a minute. The server answers others
    meanwhile.
    """

    @reads
    def getMotionPlanningHandle(self, name: str) -> int:
        return self._world.motion_plannings.find(self._adjusted(name))

    @reads
    def getMpConfigForTipPose(
        self,
        task: int,
        options: int,
        _distance: float,
        trials: int,
        pose: list[float],
        milliseconds: int = 0,
        references: list[float] | None = None,
        weights: list[float] | None = None,
        _behaviour: list[int] | None = None,
        _passes: int = 0,
    ) -> tuple[int, list[float]] | int:
        """Return 1 and a configuration that brings the tip to a pose {x, y, z, qx, qy, qz, qw} of the world, searched
        from random starts; 0 without one. With reference configurations: the nearest one to any of them.

        Partly: the number of trials before success is always 1; distance, behaviours and correction passes are ignored.
        """
        chain = self._chain(task, options)
        count = len(chain.handles)
        ends = [chain.checked(each) for each in _rows(references or [], count)]
        with self._at_no_cost():
            found = chain.find_config(
                as_pose(pose), milliseconds / 1000, trials, ends, chain.checked(weights or [1.0] * count)
            )
        return 0 if found is None else (1, found)

    def findMpPath(
        self,
        task: int,
        start: list[float],
        goal: list[float],
        options: int,
        step: float,
        milliseconds: int = 0,
        _more: list[int] | None = None,
        _further: list[float] | None = None,
    ) -> Told:
        """Return a path from one configuration to another that touches nothing. `step`: longest distance of two
        states.
        """
        chain = self._chain(task, options)
        with self._at_no_cost():
            return _told(
                chain.find_path(chain.checked(start), chain.checked(goal), step, milliseconds / 1000)
            )

    def simplifyMpPath(
        self,
        task: int,
        path: list[float],
        options: int,
        step: float,
        _increment: int = 1,
        milliseconds: int = 0,
        _more: list[int] | None = None,
        _further: list[float] | None = None,
    ) -> Told:
        """Return a shorter path with the same ends. Partly: the increment is ignored."""
        chain = self._chain(task, options)
        states = [chain.checked(each) for each in _rows(path, len(chain.handles))]
        if len(states) < 2:
            raise CommandError("a path has at least two configurations")
        with self._at_no_cost():
            return _told(chain.simplified(states, step, milliseconds / 1000))

    def findIkPath(
        self,
        task: int,
        start: list[float],
        pose: list[float],
        options: int,
        step: float,
        _more: list[int] | None = None,
        _further: list[float] | None = None,
    ) -> Told:
        """Return a path on which the tip moves from a configuration on a straight line to a pose {x, y, z, qx, qy, qz,
        qw} of the world, and touches nothing. `step`: longest distance of the tip between two states.
        """
        chain = self._chain(task, options)
        with self._at_no_cost():
            return _told(chain.straight(chain.checked(start), as_pose(pose), step))

    @reads
    def getMpConfigTransition(
        self,
        task: int,
        start: list[float],
        goal: list[float],
        options: int,
        select: list[int] | None,
        step: float,
        out_step: float,
        poses: list[float] | None = None,
    ) -> Told:
        """Return a path from one configuration to another without planning: all joints change evenly; with 512 in the
        options the tip moves on straight lines through the poses {x, y, z, qx, qy, qz, qw, ...} of the world, or on one
        to its last pose.

        `select`: {joint, behaviour, ...}, perhaps with their number in front: how joints keep the tip on its way. A
        joint of behaviour 0 changes evenly; 1 to 7 halve its weight once to seven times.
        """
        chain = self._chain(task, options)
        through = [as_pose(each) for each in _rows(poses or [], 7)] if options & _THROUGH_POSES else None
        eagerness = _eagerness(select or [])
        with self._at_no_cost():
            found = chain.transition(
                chain.checked(start), chain.checked(goal), through, eagerness, step, out_step
            )
            return _told(found)

    def _chain(self, task: int, options: int) -> PlannedChain:
        tip_turns = not options & _IGNORES_TURNS
        return self._world.motion_plannings.chain(self._world, task, options, with_turns=tip_turns)


def _rows(values: Sequence[float], count: int) -> list[list[float]]:
    """Split values into rows. Raises CommandError."""
    if len(values) % count:
        raise CommandError(f"{len(values)} numbers are not rows of {count}")
    return [list(values[place : place + count]) for place in range(0, len(values), count)]


def _eagerness(select: Sequence[int]) -> dict[int, float]:
    """Return how readily joints move, by their handles: 0 for behaviour 0, and half as much with each higher one."""
    listed = select[1:] if len(select) % 2 and select[0] == len(select) // 2 else select
    found: dict[int, float] = {}
    for joint, behaviour in _rows(listed, 2):
        if not 0 <= behaviour <= _HIGHEST_BEHAVIOUR:
            raise CommandError(f"a joint's behaviour is from 0 to {_HIGHEST_BEHAVIOUR}, not {behaviour:g}")
        found[int(joint)] = 0.5**behaviour if behaviour else 0.0
    return found


def _told(path: TipPath | None) -> Told:
    if path is None:
        return None
    return (
        [value for state in path.states for value in state],
        path.lengths,
        [value for position, _ in path.tips for value in position],
        [value for _, turn in path.tips for value in xyzw_from_wxyz(turn)],
        path.tip_lengths,
    )
