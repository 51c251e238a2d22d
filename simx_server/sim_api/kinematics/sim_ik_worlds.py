"""``simIK``: objects of an environment, and searches in it."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import islice
from typing import Any

import numpy as np

from simx_server.errors import CommandError, Unsupported
from simx_server.kinematics.chain_jacobian import chain_jacobian
from simx_server.kinematics.own_objects import OwnJoint
from simx_server.kinematics.sampling import asked_range
from simx_server.kinematics.search import find_configs, straight_path
from simx_server.kinematics.whole_turns import alternatives
from simx_server.scene.poses.frames import (
    euler_from_quat,
    matrix12,
    pose_from_matrix12,
    quat_from_euler,
    wxyz_from_xyzw,
    xyzw_from_wxyz,
)
from simx_server.scene.poses.poses import IDENTITY, Pose
from simx_server.scripting.interpreter import Function, Plain

from .ik import as_constraints, joint_order
from .sim_ik_joints import IkJointFunctions
from .sim_ik_objects import JOINT

_PASSIVE, _IK = 0, 2
_WORLD, _PARENT = -1, -11

_TRIALS = 200
"""Number of starts of findConfigs without a time limit, so that equal runs give equal tables; about 0.5 s for a
UR5.
"""

_SECONDS = 0.5
"""Default search time in seconds."""


_Judge = Callable[[list[float]], bool]


class SimIk(IkJointFunctions, effect="changes"):
    """All functions of ``simIK``."""

    PLUGIN = "simIK"

    def getObjectHandle(self, environment: int, name: str) -> int:
        for handle, known in self._environment(environment).own.all().items():
            if known.name == name:
                return handle
        return self._sim.scene.resolve(self._adjusted(name), self._owner)

    def doesObjectExist(self, environment: int, name: str) -> bool:
        own = self._environment(environment).own.all()
        return any(each.name == name for each in own.values()) or self._sim.scene.by_name(name) is not None

    def getJointPosition(self, environment: int, joint: int) -> float:
        return self._environment(environment).joint_position(joint)

    def setJointPosition(self, environment: int, joint: int, position: float) -> None:
        """Set a joint's position in the environment, within its interval."""
        self._environment(environment).set_joint_position(joint, position)

    def getJointInterval(self, environment: int, joint: int) -> tuple[bool, list[float]]:
        cyclic, least, extent = self._environment(environment).interval(joint)
        return cyclic, [least, extent]

    def setJointInterval(self, environment: int, joint: int, cyclic: bool, interval: list[float]) -> None:
        """Set a joint's interval {least value, range} in the environment."""
        if len(interval) < 2 and (interval or not cyclic):
            raise CommandError("a joint's interval is {least value, range}")
        least, extent = interval[:2] if interval else (-np.pi, 2 * np.pi)
        self._environment(environment).set_interval(joint, cyclic, least, extent)

    def getJointMode(self, environment: int, joint: int) -> int:
        return _PASSIVE if joint in self._environment(environment).passive else _IK

    def setJointMode(self, environment: int, joint: int, mode: int) -> None:
        """Set simIK.jointmode_ik or simIK.jointmode_passive: a passive joint does not move."""
        if mode not in (_PASSIVE, _IK):
            raise Unsupported(f"{mode} is no mode here; give simIK.jointmode_ik or simIK.jointmode_passive")
        passive = self._environment(environment).passive
        passive.discard(joint) if mode == _IK else passive.add(joint)

    def getObjectPose(self, environment: int, handle: int, relative_to: int = _WORLD) -> list[float]:
        """Return {x, y, z, qx, qy, qz, qw}, with the joint positions of the environment."""
        position, quat = self._pose(environment, handle, relative_to)
        return [*position, *xyzw_from_wxyz(quat)]

    def setObjectPose(self, environment: int, handle: int, relative_to: Any, pose: Any = None) -> None:
        """Set the pose of a target or an own object. Arguments 3 and 4: reference and pose in either order; without a
        reference: the world.
        """
        reference, values = _in_order(relative_to, pose)
        x, y, z, *turn = _numbers(values, 7, "a pose is {x, y, z, qx, qy, qz, qw}")
        new = ((x, y, z), wxyz_from_xyzw(turn))
        self._place(environment, handle, _WORLD if reference is None else int(reference), new)

    def getObjectMatrix(self, environment: int, handle: int, relative_to: int = _WORLD) -> list[float]:
        """Return a matrix of 12 numbers, row-major 3 x 4."""
        return matrix12(self._pose(environment, handle, relative_to))

    def setObjectMatrix(self, environment: int, handle: int, relative_to: Any, matrix: Any = None) -> None:
        """Set the matrix of 12 numbers of a target; arguments as for setObjectPose."""
        reference, values = _in_order(relative_to, matrix)
        new = pose_from_matrix12(_numbers(values, 12, "a matrix is a table of 12 numbers"))
        self._place(environment, handle, _WORLD if reference is None else int(reference), new)

    def getObjectTransformation(
        self, environment: int, handle: int, relative_to: int = _WORLD
    ) -> tuple[list[float], list[float], list[float]]:
        """Return position, quaternion {x, y, z, w} and Euler angles."""
        position, quat = self._pose(environment, handle, relative_to)
        return list(position), xyzw_from_wxyz(quat), euler_from_quat(quat)

    def setObjectTransformation(
        self, environment: int, handle: int, relative_to: int, position: list[float], turn: list[float]
    ) -> None:
        """Set the pose of a target; `turn`: three Euler angles or a quaternion {x, y, z, w}."""
        if len(position) < 3 or len(turn) < 3:
            raise CommandError(
                "give a position of 3 numbers, and 3 Euler angles or 4 numbers of a quaternion"
            )
        quat = quat_from_euler(turn) if len(turn) == 3 else wxyz_from_xyzw(turn[:4])
        x, y, z = position[:3]
        self._place(environment, handle, relative_to, ((x, y, z), quat))

    def getJacobian(self, environment: int, group: int) -> tuple[list[float], list[int]]:
        """Return the Jacobian row by row, and {rows, columns}; joints nearest to the base first."""
        found = self._look(environment, group)[1]
        return found.ravel().tolist(), list(found.shape)

    def computeGroupJacobian(self, environment: int, group: int) -> tuple[list[float], list[float]]:
        """Return the Jacobian row by row, and its error vector: coordinates in the base's axes, rotations about the
        tip's axes.
        """
        error, found = self._look(environment, group)
        return found.ravel().tolist(), error.tolist()

    def computeJacobian(
        self,
        environment: int,
        base: int,
        last_joint: int,
        constraints: int,
        tip: list[float],
        target: list[float] | None = None,
        constraints_base: list[float] | None = None,
    ) -> tuple[list[float], list[float]]:
        """Return the Jacobian of a chain row by row, and the error vector, as computeGroupJacobian does. The chain ends
        with a joint and starts below the base (-1: the world); spherical joints have three columns.

        Tip, target (nil: the tip) and the frame of coordinates (nil: the base) are poses or matrices in the world.
        """
        chosen = self._environment(environment)
        at = _pose(tip)
        reference = IDENTITY if base == _WORLD else chosen.pose(base)
        rows, error = chain_jacobian(
            chosen,
            base,
            last_joint,
            lambda handle: self.getObjectParent(environment, handle),
            lambda handle: self.getObjectType(environment, handle) == JOINT,
            int(as_constraints(constraints)),
            at,
            at if target is None else _pose(target),
            reference if constraints_base is None else _pose(constraints_base),
        )
        return [value for row in rows for value in row], error

    def getManipulability(self, environment: int, group: int) -> float:
        """Return sqrt(det(J J^T)), 0 for a singular matrix."""
        found = self._look(environment, group)[1]
        return float(np.sqrt(max(0.0, np.linalg.det(found @ found.T))))

    def getConfigForTipPose(
        self,
        environment: int,
        group: int,
        joints: list[int],
        _threshold: float = 0.1,
        seconds: float = _SECONDS,
        _metric: list[float] | None = None,
        callback: str | Function | None = None,
        data: Any = None,
        _joint_options: list[int] | None = None,
        low: list[float] | None = None,
        ranges: list[float] | None = None,
    ) -> list[float] | None:
        """Return joint values for the targets, searched from random starts; nil when the time runs out.

        `callback`: function(values, data) that returns whether they are valid. `low` and `ranges` are those of the
        random starts. Partly: threshold, metric and joint options are ignored; seconds are counted as work.
        """
        found = self._search(
            environment, group, joints, abs(seconds), self._judge(callback, data), (low, ranges)
        )
        return found[0] if found else None

    def findConfig(
        self,
        environment: int,
        group: int,
        joints: list[int],
        threshold: float = 0.1,
        seconds: float = _SECONDS,
        metric: list[float] | None = None,
        callback: str | Function | None = None,
        data: Any = None,
    ) -> list[float] | None:
        """Return joint values as getConfigForTipPose does. Partly: with the same differences."""
        return self.getConfigForTipPose(
            environment, group, joints, threshold, seconds, metric, callback, data
        )

    def findConfigs(
        self,
        environment: int,
        group: int,
        joints: list[int],
        options: dict[str, Any] | None = None,
        _others: Any = None,
    ) -> list[list[float]]:
        """Return a table of joint values for the targets, those nearest to the present ones first; empty when there
        are none.

        Options: `maxTime` in seconds, `findMultiple`, `cb` a function(values) that returns whether they are valid.
        The first trial starts at the present values. Partly: it ends after 200 trials, even if time is left.
        """
        asked = options or {}
        (seconds,) = _numbers([asked.get("maxTime", 0.1)], 1, "maxTime is a number of seconds")
        many = bool(asked.get("findMultiple"))
        return self._search(
            environment, group, joints, seconds, self._judge(asked.get("cb")), many=many, near=True
        )

    def getAlternateConfigs(
        self,
        environment: int,
        joints: list[int],
        values: list[float],
        low: list[float] | None = None,
        extents: list[float] | None = None,
    ) -> list[float]:
        """Return the joint values that put the joints where the given ones do, in sequence: hinges that can turn
        further take each value that is whole turns away, within their intervals or the given ones.
        """
        chosen = self._environment(environment)
        if len(values) != len(joints):
            raise CommandError(f"{len(joints)} joints need as many values, not {len(values)}")
        intervals: list[tuple[float, float] | None] = []
        for index, joint in enumerate(joints):
            cyclic, least, extent = chosen.interval(joint)
            if low and extents and index < min(len(low), len(extents)) and extents[index] > 0:
                cyclic, least, extent = False, low[index], extents[index]
            turns = not cyclic and chosen.joint_type(joint) == OwnJoint.REVOLUTE
            intervals.append((least, extent) if turns else None)
        return [value for found in alternatives(values, intervals) for value in found]

    def generatePath(
        self,
        environment: int,
        group: int,
        joints: list[int],
        _tip: int,
        count: int,
        callback: str | Function | None = None,
        data: Any = None,
    ) -> list[float] | None:
        """Return `count` configurations in sequence that move the tip in a straight line from its present pose to
        the target.

        Returns nil (CoppeliaSim 4.5: an empty table) when the line leaves the reach or the callback rejects a
        configuration.
        """
        chosen, wanted = self._environment(environment), self._group(environment, group)
        begin, goals = chosen.tips(wanted), chosen.goals(wanted)
        usable, solver = chosen.solver(wanted, tuple(joints))
        order = joint_order(usable.handles, joints)
        start = np.array([chosen.joint_position(handle) for handle in usable.handles])
        accepts = _ordered(self._judge(callback, data), order)
        with self._at_no_cost():
            path = straight_path(
                solver, start, begin, goals, count, accepts, self._sim.interruptions.may_go_on
            )
        return None if path is None else [value for values in path for value in values[order].tolist()]

    def _search(
        self,
        environment: int,
        group: int,
        joints: list[int],
        seconds: float,
        judge: _Judge | None,
        sampled: tuple[list[float] | None, list[float] | None] = (None, None),
        *,
        many: bool = False,
        near: bool = False,
    ) -> list[list[float]]:
        chosen, wanted = self._environment(environment), self._group(environment, group)
        goals = chosen.goals(wanted)
        usable, solver = chosen.solver(wanted, tuple(joints))
        order = joint_order(usable.handles, joints)
        start = np.array([chosen.joint_position(handle) for handle in usable.handles])
        found = find_configs(
            solver,
            usable,
            goals,
            self._world.ik_groups.random,
            seconds=seconds,
            trials=_TRIALS if near else None,
            start=start if near else None,
            sampled=asked_range(*sampled, order),
            accepts=_ordered(judge, order),
            may_go_on=self._sim.interruptions.may_go_on,
        )
        with self._at_no_cost():
            chosen_ones = list(found if many else islice(found, 1))
        chosen_ones.sort(key=lambda values: float(np.linalg.norm(values - start)))
        return [values[order].tolist() for values in chosen_ones]

    def _judge(self, callback: Any, *extra: Any) -> _Judge | None:
        """Return a check of joint values that calls a script's function; None without a function, or with ''."""
        if callback in (None, "", b""):
            return None
        function = self._function(callback)

        def judge(values: list[float]) -> bool:
            answer = function(values, *extra)
            return bool(answer and answer[0])

        return judge

    def _look(self, environment: int, group: int) -> Any:
        chosen, wanted = self._environment(environment), self._group(environment, group)
        goals = chosen.goals(wanted)
        usable, solver = chosen.solver(wanted)
        values = np.array([chosen.joint_position(handle) for handle in usable.handles])
        return solver.look(values, goals)

    def _reference(self, environment: int, handle: int, relative_to: int) -> int:
        return self.getObjectParent(environment, handle) if relative_to == _PARENT else relative_to

    def _pose(self, environment: int, handle: int, relative_to: int) -> Pose:
        return self._environment(environment).pose(handle, self._reference(environment, handle, relative_to))

    def _place(self, environment: int, handle: int, relative_to: int, pose: Pose) -> None:
        self._environment(environment).set_pose(
            handle, self._reference(environment, handle, relative_to), pose
        )


def _pose(numbers: list[float]) -> Pose:
    """Return a pose of 7 numbers, or of a matrix of 12. Raises CommandError: there are others."""
    if len(numbers) == 12:
        return pose_from_matrix12(numbers)
    x, y, z, *turn = _numbers(numbers, 7, "a pose is {x, y, z, qx, qy, qz, qw}, or a matrix of 12 numbers")
    return (x, y, z), wxyz_from_xyzw(turn)


def _ordered(judge: _Judge | None, order: list[int]) -> Callable[[np.ndarray], bool] | None:
    """Return the check for our order of joints; `order`: the index of each of the script's joints among them."""
    return None if judge is None else lambda values: judge(values[order].tolist())


def _in_order(first: Plain, second: Plain) -> tuple[Any, Plain]:
    """Return the reference, then the numbers; a script may give the numbers first."""
    return (second, first) if isinstance(first, list) else (first, second)


def _numbers(values: Plain, count: int, what: str) -> list[float]:
    """Return `count` finite numbers of a value of any type.

    Raises:
        CommandError: the value is something else.
    """
    if isinstance(values, list) and len(values) == count:
        good = [v for v in values if isinstance(v, int | float) and math.isfinite(v)]
        if len(good) == count:
            return [float(value) for value in good]
    raise CommandError(what)
