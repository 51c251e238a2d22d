"""Inverse kinematics in V-REP 3's way: the groups of the scene, by handle.

A scene registers its groups with `simx:ik:NAME`, see `simx_server/kinematics`. CoppeliaSim 4's way is in
`sim_ik.py`.
"""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from simx_client.protocol import constants as c
from simx_server.errors import CommandError
from simx_server.kinematics import Calculation, Constraint, Group
from simx_server.kinematics.chain import Joints
from simx_server.kinematics.planning.validity import as_pairs, of_joints
from simx_server.kinematics.sampling import Nearness, sampling_range, turned_back
from simx_server.kinematics.scratch import Array
from simx_server.kinematics.search import find_configs, straight_path
from simx_server.kinematics.solver import Solver
from simx_server.scene.link_constraints import IK
from simx_server.scene.objects import ObjectKind
from simx_server.scene.poses.placing import object_pose
from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.effects import reads

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation

_JACOBIAN, _MANIPULABILITY = 0, 1

_LEAST = 1e-6
"""Least precision and weight of an element."""


class IkFunctions(ApiPart, effect="changes"):
    """Functions for IK groups, by the handles that sim.getIkGroupHandle returns."""

    CONSTANTS = MappingProxyType(
        {
            "ik_x_constraint": 1,
            "ik_y_constraint": 2,
            "ik_z_constraint": 4,
            "ik_alpha_beta_constraint": 8,
            "ik_gamma_constraint": 16,
            "ik_pseudo_inverse_method": 0,
            "ik_damped_least_squares_method": 1,
            "ik_jacobian_transpose_method": 2,
            "ikresult_not_performed": 0,
            "ikresult_success": 1,
            "ikresult_fail": 2,
        }
    )

    @reads
    def getIkGroupHandle(self, name: str) -> int:
        """Return the handle of a group that the scene registers. An unknown name is an error."""
        return self._world.ik_groups.find(self._adjusted(name))

    def handleIkGroup(self, group: int) -> int:
        """Handle a group and return a sim.ikresult_*; with sim.handle_all or sim.handle_all_except_explicit return
        how many groups were handled.

        If the target is out of reach, the joints move as near to it as they can.
        """
        if group == c.sim_handle_all:
            return self._world.ik_groups.handle_all()
        if group == c.sim_handle_all_except_explicit:
            return self._world.ik_groups.handle_automatic()
        return int(self._world.ik_groups.handle(group))

    def checkIkGroup(
        self, group: int, joints: list[int], _joint_options: list[int] | None = None
    ) -> tuple[int, list[float]]:
        """Compute values of these joints that bring the tips of a group to their targets; return a sim.ikresult_* and
        the values, the nearest ones if a target is out of reach. The joints may have any mode, all others are locked;
        nothing moves.

        Partly: joint options are ignored.
        """
        present = {handle: self._sim.joints.position(handle) for handle in joints}
        result, found = self._world.ik_groups.check(self._world.ik_groups.get(group), joints)
        return int(result), [found.get(handle, present[handle]) for handle in joints]

    def setIkGroupProperties(
        self, group: int, method: int, iterations: int, damping: float, _more: Any = None
    ) -> int:
        """Set the method (a sim.ik_*_method), maximum iterations and damping of a group until the simulation stops."""
        self._world.ik_groups.get(group).how = Calculation.checked(method, damping, iterations)
        return 1

    def setIkElementProperties(
        self,
        group: int,
        tip: int,
        constraints: int,
        precision: list[float] | None = None,
        weight: list[float] | None = None,
        _more: Any = None,
    ) -> int:
        """Set constraints (sum of sim.ik_*_constraint), precision {metres, radians} and weights {position,
        orientation}.
        """
        chosen, handle = self._world.ik_groups.get(group), self._self(tip)
        for number, element in enumerate(chosen.elements):
            if element.tip == handle:
                element = replace(element, constraints=as_constraints(constraints))
                if precision:
                    element = replace(element, precision=as_pair(precision, "precision"))
                if weight:
                    element = replace(element, weights=as_pair(weight, "weight"))
                chosen.elements[number] = element
                return 1
        raise CommandError(f"the group '{chosen.name}' has no element with the tip {tip}")

    @reads
    def getLinkDummy(self, dummy: int) -> int:
        """Return the dummy that is linked to a dummy; -1 for none."""
        handle = self._self(dummy)
        self._sim.scene.get(handle)
        for tip, target in self._world.ik_groups.links().items():
            if handle in (tip, target):
                return target if handle == tip else tip
        is_dummy = self._sim.scene.get(handle).kind == ObjectKind.DUMMY
        return self._world.dummy_links.linked(handle) if is_dummy else -1

    def setLinkDummy(self, dummy: int, target: int) -> int:
        """Link a dummy to another one, or with -1 to none, until the simulation stops. Physics holds the two together
        where their type is sim.dummy_linktype_dynamics_loop_closure; the tip of inverse kinematics gets another target.
        """
        tip, goal = self._self(dummy), -1 if target == -1 else self._self(target)
        if goal != -1:
            self._sim.scene.get(goal)
            tips = self._world.ik_groups.links()
            if tip not in tips and goal in tips:
                tip, goal = goal, tip
            if self._world.ik_groups.retarget(tip, goal):
                return 1
        self._world.dummy_links.link(tip, goal)
        return 1

    @reads
    def getDummyLinkType(self, dummy: int) -> tuple[int, int]:
        """Return the type of a dummy's link, sim.dummy_linktype_*, and the linked dummy, -1 for none."""
        handle = self._self(dummy)
        return self._world.dummy_links.type(handle), self.getLinkDummy(handle)

    def setDummyLinkType(self, dummy: int, link_type: int) -> int:
        """Set the type of a dummy's link, sim.dummy_linktype_*, until the simulation stops; return 1."""
        handle, links = self._self(dummy), self._world.dummy_links
        links.set_type(handle, link_type)
        if link_type == IK and (other := links.linked(handle)) != -1:
            for tip, target in ((handle, other), (other, handle)):
                self._world.ik_groups.retarget(tip, target)
        return 1

    def computeJacobian(self, group: int, _options: int = 0) -> int:
        """Compute the Jacobian, which sim.getIkGroupMatrix returns; return 0. A failure is an error.

        Partly: for the constraints of the group; the options are ignored.
        """
        self._matrix(self._world.ik_groups.get(group))
        return 0

    @reads
    def getIkGroupMatrix(self, group: int, options: int = 0) -> tuple[list[float], list[int]]:
        """Return the numbers of a matrix row by row, and {columns, rows}. `options`: 0 the Jacobian, 1 the
        manipulability matrix J J^T. Columns are joints: those of the last sim.checkIkGroup, else those in IK mode.

        Partly: always for the present state; the joints nearest to the base come first (V-REP: last).
        """
        if options not in (_JACOBIAN, _MANIPULABILITY):
            raise CommandError(f"{options} is not known; 0 is the Jacobian, 1 the manipulability matrix")
        found = self._matrix(self._world.ik_groups.get(group))
        if options == _MANIPULABILITY:
            found = found @ found.T
        return found.ravel().tolist(), [found.shape[1], found.shape[0]]

    def getConfigForTipPose(
        self,
        group: int,
        joints: list[int],
        threshold: float,
        milliseconds: int,
        metric: list[float] | None = None,
        collision_pairs: list[int] | None = None,
        _joint_options: list[int] | None = None,
        low: list[float] | None = None,
        ranges: list[float] | None = None,
    ) -> list[float] | None:
        """Return values of these joints that bring the tip to the target, searched from random starts; nil when the
        time runs out. The joints may have any mode, all others are locked; nothing moves.

        `threshold`: how near the tip of a random start must be to the target, in the `metric` {x, y, z, angle}, by
        default {1, 1, 1, 0.1}. `collision_pairs`: {entity, entity, ...} that must not collide; sim.handle_all stands
        for all other objects. `low`, `ranges`: of the random starts; by default the intervals of the joints.

        Partly: joint options are ignored; milliseconds are counted as work, so equal calls have equal results.
        """
        chosen = self._world.ik_groups.get(group)
        usable, solver = self._prepared(chosen, joints)
        listed = ListedJoints(self._sim, usable, joints)
        validity = of_joints(self._world, usable, as_pairs(collision_pairs)) if collision_pairs else None
        found = find_configs(
            solver,
            usable,
            self._world.ik_groups.goals(chosen),
            self._world.ik_groups.random,
            seconds=abs(milliseconds) / 1000,
            sampled=listed.range(low, ranges),
            near=Nearness.checked(threshold, metric),
            accepts=validity,
            may_go_on=self._sim.interruptions.may_go_on,
        )
        with self._at_no_cost():
            values = next(found, None)
        return None if values is None else listed.values(values)

    def generateIkPath(
        self,
        group: int,
        joints: list[int],
        count: int,
        collision_pairs: list[int] | None = None,
        _joint_options: list[int] | None = None,
    ) -> list[float] | None:
        """Return `count` configurations of these joints in sequence that move the tip in a straight line from its
        present pose to the target. The joints may have any mode, all others are locked; nothing moves.

        Returns nil when the line leaves the reach or entities collide.
        """
        chosen = self._world.ik_groups.get(group)
        usable, solver = self._prepared(chosen, joints)
        listed = ListedJoints(self._sim, usable, joints)
        validity = of_joints(self._world, usable, as_pairs(collision_pairs)) if collision_pairs else None
        active = self._world.ik_groups.active(chosen)
        tips = [object_pose(self._sim, self._sim.scene.get(each.tip)) for each in active]
        start = turned_back(usable, self._sim.data.qpos[usable.addresses])
        goals = self._world.ik_groups.goals(chosen)
        with self._at_no_cost():
            path = straight_path(
                solver, start, tips, goals, count, validity, self._sim.interruptions.may_go_on
            )
        return None if path is None else [value for values in path for value in listed.values(values)]

    def _prepared(self, group: Group, joints: list[int]) -> tuple[Joints, Solver]:
        """Return joints and solver of a group for these joints alone. Raises UnknownHandle, WrongKind, CommandError."""
        for handle in joints:
            self._sim.scene.get_kind(handle, ObjectKind.JOINT)
        return self._world.ik_groups.solver(group, joints)

    def _matrix(self, group: Group) -> np.ndarray:
        groups = self._world.ik_groups
        joints, solver = groups.solver(group, group.checked)
        return solver.look(self._sim.data.qpos[joints.addresses], groups.goals(group))[1]


class ListedJoints:
    """The joints that a script lists, in its order, among those that take part in a search."""

    def __init__(self, sim: Simulation, usable: Joints, listed: list[int]) -> None:
        """Find them."""
        self._usable = usable
        self._chosen = [number for number, handle in enumerate(listed) if handle in usable.handles]
        self._order = [usable.handles.index(listed[number]) for number in self._chosen]
        self._present = np.array([sim.joints.position(handle) for handle in listed])

    def values(self, values: Array) -> list[float]:
        """Return the values of all listed joints; one that takes no part stays where it is."""
        found = self._present.copy()
        found[self._chosen] = values[self._order]
        return found.tolist()

    def range(self, low: list[float] | None, ranges: list[float] | None) -> tuple[Array, Array] | None:
        """Return (minimum, range) of random starts for all joints that take part; None when the script passes none.

        Raises:
            CommandError: the number of values is wrong.
        """
        if not low or not ranges:
            return None
        if not len(low) == len(ranges) == len(self._present):
            raise CommandError(
                f"lowest values and ranges of random starts are one for each of the {len(self._present)} joints"
            )
        found = sampling_range(self._usable)
        for mine, asked in zip(found, (low, ranges), strict=True):
            mine[self._order] = [asked[number] for number in self._chosen]
        return found


def joint_order(usable: tuple[int, ...], joints: list[int]) -> list[int]:
    """Return the index of each of the script's joints among those of the group; both must be the same set of
    joints.
    """
    if sorted(usable) != sorted(joints):
        raise CommandError(
            f"the joints {sorted(joints)} are not those that the group moves, {sorted(usable)}; give each of these once"
        )
    return [usable.index(joint) for joint in joints]


def as_constraints(number: int) -> Constraint:
    """Return the sum of constraints x 1, y 2, z 4, alpha_beta 8, gamma 16; 0 for none. Other bits do not count."""
    return Constraint(number & Constraint.POSE)


def as_pair(values: list[float], what: str) -> tuple[float, float]:
    """Return the numbers of position and orientation; those that are too small count as the least one.

    Raises:
        CommandError: there are fewer than two.
    """
    if len(values) < 2:
        raise CommandError(f"a {what} is two numbers, of position and orientation")
    return max(values[0], _LEAST), max(values[1], _LEAST)
