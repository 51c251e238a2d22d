"""Planned paths of arms and mobile robots, for PyRep."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from simx_client.protocol import constants as c
from simx_client.protocol.nearest import did_you_mean
from simx_server.errors import CommandError
from simx_server.kinematics.planning.states import SpaceKind, StateSpace, Task, coordinates
from simx_server.kinematics.planning.trials import shortest_path
from simx_server.kinematics.search import MOST_STATES
from simx_server.scene.poses.frames import get_pose
from simx_server.sim_api.planning.ompl import ALGORITHMS

if TYPE_CHECKING:
    from simx_server.world.world import World

_LEAST_STATES = 300
"""States of an arm's path."""

_MOST_GOALS = 1000
"""Goals of one plan; each costs a line and a check, and PyRep gives ten."""

_FARTHEST = 6.28
"""rad or m: bound of a joint that may move farther to both sides."""

_RADIUS = 0.1
"""Smallest radius in metres of a mobile robot's turns."""

_WIDEST = 1e4
"""Metres: greatest bound of a mobile robot's places."""


class PlannedPaths:
    """Plans on the scene as it is at the call; nothing moves."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._sim = world.simulation

    def of_arm(self, ints: list[int], floats: list[float], strings: list[str]) -> list[float]:
        """Return a path of joints from where they are to one of several configurations: at least 300 states in
        sequence, or nothing.

        Args:
            ints: collection of the arm, 1 to ignore collisions, number of trials, joints.
            floats: goals, each with a value (rad or m) for each joint.
            strings: the name of an algorithm.

        Raises:
            CommandError: arguments are missing, too many or unknown.
        """
        if len(ints) < 4:
            raise CommandError("getNonlinearPath takes a collection, a flag, the number of trials and joints")
        collection, ignores, trials, *joints = ints
        count = len(joints)
        if not floats or len(floats) % count:
            raise CommandError(f"goals are {count} numbers each, one for each joint, not {len(floats)}")
        if len(floats) > _MOST_GOALS * count:
            raise CommandError(f"at most {_MOST_GOALS} goals are tried, not {len(floats) // count}")
        if not all(map(math.isfinite, floats)):
            raise CommandError("a goal has a number that is not finite")
        if len(set(joints)) < count:
            raise CommandError("a joint is listed twice; list each joint once")
        spaces = [self._joint_space(handle) for handle in joints]
        task = self._task(spaces, collection, ignores, strings)
        task.start = [self._sim.joints.position(handle) for handle in joints]
        task.goals = [floats[at : at + count] for at in range(0, len(floats), count)]
        path = np.array(shortest_path(self._world, task, trials, _LEAST_STATES))
        if len(path):
            # A joint without an end goes the short way round, and PyRep expects it to go on from there.
            cyclic = [self._sim.joints.interval(handle)[0] for handle in joints]
            path[:, cyclic] = np.unwrap(path[:, cyclic], axis=0)
        return path.ravel().tolist()

    def of_mobile(self, ints: list[int], floats: list[float], strings: list[str]) -> list[float]:
        """Return a way on a plane, forwards or backwards, from where a robot is to a target: x, y (m), yaw (rad) of
        each state in sequence, or nothing.

        Args:
            ints: robot, target, collection of the robot, 1 to ignore collisions, number of states.
            floats: places have x and y up to this bound in metres.
            strings: the name of an algorithm.

        Raises:
            CommandError: arguments are missing, or cannot be used.
        """
        robot, target, collection, ignores, count = ints
        (bound,) = floats
        if not 0.0 < bound <= _WIDEST:
            raise CommandError(f"a bound is above 0, up to {_WIDEST:g} m, not {bound:g}")
        if count > MOST_STATES:
            raise CommandError(f"a path has up to {MOST_STATES} states, not {count}")
        high = (bound, bound, math.pi)
        low = (-bound, -bound, -math.pi)
        kind = SpaceKind.DUBINS
        space = StateSpace("plane", kind, robot, low, high, radius=_RADIUS, is_symmetric=True)
        task = self._task([space], collection, ignores, strings)
        task.start = coordinates(kind, get_pose(self._sim, robot))
        task.goals = [coordinates(kind, get_pose(self._sim, target))]
        path = shortest_path(self._world, task, 1, max(2, count))
        return [value for state in path for value in state.tolist()]

    def _task(self, spaces: list[StateSpace], collection: int, ignores: int, strings: list[str]) -> Task:
        name = strings[0] if strings else ""
        if name not in ALGORITHMS:
            raise CommandError(f"'{name}' is no algorithm{did_you_mean(name, ALGORITHMS)}")
        task = Task("PyRep", spaces, algorithm=name)
        if not ignores:
            self._world.meters.collisions.entities(collection, c.sim_handle_all)
            task.pairs = [(collection, c.sim_handle_all)]
        return task

    def _joint_space(self, handle: int) -> StateSpace:
        cyclic, least, extent = self._sim.joints.interval(handle)
        low, high = (-_FARTHEST, _FARTHEST) if cyclic else (least, least + extent)
        if low < -_FARTHEST and high > _FARTHEST:
            low, high = -_FARTHEST, _FARTHEST
        return StateSpace("", SpaceKind.JOINT, handle, (low,), (high,))
