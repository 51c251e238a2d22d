"""A separate world for `simIK`: joint values and poses that are changed and solved without moving the scene.

Objects have the same handles as in the scene. Joints and poses that were not set here are those of the scene.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from copy import deepcopy
from dataclasses import dataclass, field, replace
from enum import IntFlag
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from simx_server.scene.poses.frames import get_pose
from simx_server.scene.poses.placing import carrier_body, object_pose
from simx_server.scene.poses.poses import Pose, compose, inverse
from simx_server.simulation.sleepers import kinematics

from ..errors import CommandError
from ..joints import JointMode
from ..scene.objects import ObjectKind
from .chain import Arm, Element, Joints, fixed_pose, make_arms
from .group import must_stay
from .least_squares.problem import pose_of_body
from .own_objects import OwnJoint, OwnObjects
from .scratch import Array, Positions, Scratch
from .solver import Calculation, Method, Result, Solution, Solver

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation

_START = Calculation(Method.PSEUDO_INVERSE, 0.0, 6)
"""The calculation of CoppeliaSim's new groups."""


class GroupFlag(IntFlag):
    """Options of a group."""

    ENABLED = 1
    IGNORE_MAX_STEPS = 2
    """One iteration may move a joint as far as it likes."""
    RESTORE_ON_BAD_LINEAR = 4
    RESTORE_ON_BAD_ANGULAR = 8
    """The joints stay where they are when the tips do not reach this part of their targets."""
    AVOID_LIMITS = 64
    """Joints keep their margins from their limits; no solution leaves the limits in any case."""

    @property
    def restore(self) -> frozenset[str]:
        """Return the parts of a pose that must be reached, as `must_stay` names them."""
        parts = {self.RESTORE_ON_BAD_LINEAR: "position", self.RESTORE_ON_BAD_ANGULAR: "orientation"}
        return frozenset(part for flag, part in parts.items() if self & flag)


_INTERVALS = {OwnJoint.REVOLUTE: (True, -math.pi, 2 * math.pi), OwnJoint.PRISMATIC: (False, -0.5, 1.0)}
"""Intervals of new joints: whether they are cyclic, the least value, and the range."""


@dataclass
class EnvironmentGroup:
    """Elements that are solved together."""

    name: str
    how: Calculation = _START
    elements: dict[int, Element] = field(default_factory=dict[int, Element])
    flags: GroupFlag = GroupFlag.ENABLED | GroupFlag.IGNORE_MAX_STEPS
    solution: Solution | None = None
    """The result of the last handling."""

    @property
    def counting(self) -> list[Element]:
        """Return the elements that are enabled."""
        return [element for element in self.elements.values() if element.enabled]


@dataclass(frozen=True)
class Kept:
    """Differences of an environment from the scene, by handle."""

    poses: dict[int, Pose]
    values: dict[int, float]
    """Positions of joints, rad or m."""
    intervals: dict[int, tuple[bool, float, float]]
    steps: dict[int, float]
    margins: dict[int, float]
    weights: dict[int, float]

    def by_joint(self) -> dict[str, dict[int, Any]]:
        """Return by name what belongs to joints."""
        names = ("values", "intervals", "steps", "margins", "weights")
        return {name: getattr(self, name) for name in names}


class Environment:
    """One environment."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._scratch = Scratch(sim)
        self.groups: dict[int, EnvironmentGroup] = {}
        self.passive: set[int] = set()
        """Handles of joints that take no part."""
        self.own = OwnObjects(self._world_pose)
        """The objects that exist in this environment only."""
        self.targets: dict[int, int] = {}
        """The target of a tip, as a script has linked them."""
        self._values: dict[int, float] = {}
        self._poses: dict[int, Pose] = {}
        self._intervals: dict[int, tuple[bool, float, float]] = {}
        self.steps: dict[int, float] = {}
        """How far one iteration moves a joint at most, rad or m, where a script has set it."""
        self.margins: dict[int, float] = {}
        """How far joints stay away from their limits, rad or m, in groups with `GroupFlag.AVOID_LIMITS`."""
        self.weights: dict[int, float] = {}
        """How readily a joint moves beside the others, where a script has set it."""

    def copied(self) -> Environment:
        """Return an environment with the same content, which changes on its own from now on."""
        twin = Environment(self._sim)
        twin.own.copy_from(self.own)
        for name, value in vars(self).items():
            if name not in ("_sim", "_scratch", "own"):
                setattr(twin, name, deepcopy(value))
        return twin

    @classmethod
    def like(cls, other: Environment) -> Environment:
        """Return an empty environment of the same scene."""
        return cls(other._sim)

    def become(self, other: Environment) -> None:
        """Take over the content of another environment, which is not used any more."""
        self.own.copy_from(other.own)
        for name, value in vars(other).items():
            if name not in ("_sim", "_scratch", "own"):
                setattr(self, name, value)

    def kept(self) -> Kept:
        """Return what differs from the scene; changes of it are changes of the environment."""
        return Kept(self._poses, self._values, self._intervals, self.steps, self.margins, self.weights)

    def joint_position(self, joint: int) -> float:
        """Return the position of a joint, rad or m.

        Raises:
            UnknownHandle, WrongKind, CommandError: the joint has no single value.
        """
        if joint in self.own:
            return self.own.joint(joint).value
        self._address(joint)
        return self._values.get(joint, self._sim.joints.position(joint))

    def set_joint_position(self, joint: int, value: float) -> None:
        """Set the position of a joint, limited to its interval as in the scene."""
        self._check_joint(joint)
        cyclic, least, extent = self.interval(joint)
        if not cyclic and extent < 1e9:
            value = min(max(value, least), least + extent)
        self._keep(joint, value)

    def interval(self, joint: int) -> tuple[bool, float, float]:
        """Return (cyclic, minimum, range)."""
        if joint in self._intervals:
            return self._intervals[joint]
        kind = self.own.joint(joint).joint if joint in self.own else None
        return self._sim.joints.interval(joint) if kind is None else _INTERVALS[kind]

    def joint_type(self, joint: int) -> int:
        """Return V-REP's number of a joint's type."""
        kind = self.own.joint(joint).joint if joint in self.own else None
        return self._sim.joints.joint_type(joint) if kind is None else int(kind)

    def set_interval(self, joint: int, cyclic: bool, least: float, extent: float) -> None:
        self._check_joint(joint)
        self._intervals[joint] = cyclic, least, extent

    def pose(self, handle: int, relative_to: int = -1) -> Pose:
        """Return an object's pose with the joints where this environment has them.

        Raises:
            UnknownHandle: the object does not exist.
        """
        world = self._world_pose(handle)
        return world if relative_to == -1 else compose(inverse(self._world_pose(relative_to)), world)

    def set_pose(self, handle: int, relative_to: int, pose: Pose) -> None:
        """Set the pose of an object; the children of one of the scene stay where they are.

        Raises:
            UnknownHandle: the object does not exist.
        """
        world = pose if relative_to == -1 else compose(self._world_pose(relative_to), pose)
        if handle in self.own:
            self.own.place(handle, world)
        else:
            self._sim.scene.get(handle)
            self._poses[handle] = world

    def erase(self, handle: int) -> None:
        """Erase an object that exists in this environment only.

        Raises:
            CommandError: a group uses it.
        """
        self.own[handle]
        for group in self.groups.values():
            for element in group.elements.values():
                if handle in (element.tip, element.target, element.base):
                    raise CommandError(f"the group '{group.name}' needs '{self.own[handle].name}'")
        self.own.erase(handle)
        self.targets = {tip: target for tip, target in self.targets.items() if handle not in (tip, target)}

    def add(self, group: EnvironmentGroup, element: Element) -> int:
        """Add an element, one of the scene with its present joints and poses; return its number.

        Raises:
            CommandError: no joint takes part, the base is not above the tip, or the other elements of the group
                move joints of the other kind, of the scene or of this environment.
        """
        others = [each.tip in self.own for each in group.elements.values()]
        if not all(others) if element.tip in self.own else any(others):
            raise CommandError(
                "a group moves joints of the scene, or joints made in its environment, not both"
            )
        self.check(element)
        number = max(group.elements, default=-1) + 1
        group.elements[number] = element
        if element.tip in self.own:
            return number
        for handle in self.joints(group).handles:
            self._values.setdefault(handle, self._sim.joints.position(handle))
        if element.target not in self.own:
            self._poses[element.target] = get_pose(self._sim, element.target)
        return number

    def check(self, element: Element) -> None:
        """Look whether an element can be solved.

        Raises:
            CommandError: no joint takes part, or the base is not above the tip.
        """
        if element.tip in self.own:
            self.own.chain(element, self._takes_part)
        elif element.axes in self.own:
            raise CommandError(
                "the constraints of an element of the scene are relative to an object of the scene"
            )
        else:
            make_arms(self._sim, [element], self._takes_part)

    def take_over(self, groups: Iterable[EnvironmentGroup]) -> None:
        """Copy the scene's present state: values of the groups' joints, poses of their tips' targets."""
        self._sim.refresh()
        for group in groups:
            for handle in self._of_scene(group):
                self._values[handle] = self._sim.joints.position(handle)
            for element in group.elements.values():
                self._poses.pop(element.tip, None)
                if element.target not in self.own:
                    self._poses[element.target] = get_pose(self._sim, element.target)

    def give_back(self, groups: Iterable[EnvironmentGroup]) -> None:
        """Move the scene's joints to the values of the groups here: by their motors where they have any."""
        for group in groups:
            for handle in self._of_scene(group):
                move_joint(self._sim, handle, self._values[handle])

    def joints(self, group: EnvironmentGroup) -> Joints:
        """Return the joints that the group moves.

        Raises:
            CommandError: there are none.
        """
        return self._prepared(group)[1]

    def solver(
        self, group: EnvironmentGroup, only: tuple[int, ...] | None = None, limits: bool = True
    ) -> tuple[Joints, Solver]:
        """Return joints and solver of a group on the environment's state.

        Args:
            group: the group.
            only: handles of the joints that move; the others stay.
            limits: whether the limits of the joints count.
        """
        place, joints, arms = self._prepared(group, only, limits)
        if place is self._scratch:
            self._load()
        return joints, Solver(place, joints, arms)

    def _prepared(
        self, group: EnvironmentGroup, only: tuple[int, ...] | None = None, limits: bool = True
    ) -> tuple[Positions, Joints, list[Arm]]:
        """Return what a solver needs."""
        elements = group.counting
        if not elements:
            if group.elements:
                raise CommandError(f"the elements of the group '{group.name}' are all disabled")
            raise CommandError(
                f"the group '{group.name}' has no element; add one with simIK.addElementFromScene"
            )

        def takes_part(handle: int) -> bool:
            return self._takes_part(handle) and (only is None or handle in only)

        if elements[0].tip in self.own:
            place, joints, arms = self.own.arms(elements, takes_part)
        else:
            joints, arms = make_arms(self._sim, elements, takes_part)
            place = self._scratch
        with_margin = bool(group.flags & GroupFlag.AVOID_LIMITS)
        bounds = [
            self._limits(handle, with_margin) if limits else (-math.inf, math.inf)
            for handle in joints.handles
        ]
        low, high = np.array(bounds, dtype=float).T
        joints = replace(
            joints, low=low, high=high, max_step=self._steps(group, joints), weights=self._weighted(joints)
        )
        return place, joints, arms

    def goals(self, group: EnvironmentGroup) -> list[Pose]:
        """Return the world poses of the targets."""
        return [self._world_pose(element.target) for element in group.counting]

    def tips(self, group: EnvironmentGroup) -> list[Pose]:
        """Return the world poses of the tips."""
        return [self._world_pose(element.tip) for element in group.counting]

    def handle(self, group: EnvironmentGroup) -> Solution:
        """Solve, and keep the result, even if it is only the nearest, unless the group's flags say otherwise."""
        goals = self.goals(group)
        joints, solver = self.solver(group)
        start = np.array([self.joint_position(handle) for handle in joints.handles])
        if not group.flags & GroupFlag.ENABLED:
            return Solution(start, Result.NOT_PERFORMED, 0.0, 0.0)
        group.solution = solver.solve(start, goals, group.how)
        if not must_stay(group.counting, group.flags.restore, group.solution):
            for handle, value in zip(joints.handles, group.solution.values.tolist(), strict=True):
                self._keep(handle, value)
        return group.solution

    def _of_scene(self, group: EnvironmentGroup) -> list[int]:
        """Return the joints of the scene that a group moves."""
        return [handle for handle in self.joints(group).handles if handle not in self.own]

    def _steps(self, group: EnvironmentGroup, joints: Joints) -> Array:
        if group.flags & GroupFlag.IGNORE_MAX_STEPS:
            return np.full(len(joints.handles), math.inf)
        return np.array(
            [
                self.steps.get(each, usual)
                for each, usual in zip(joints.handles, joints.max_step.tolist(), strict=True)
            ]
        )

    def _weighted(self, joints: Joints) -> Array:
        return np.array(
            [
                self.weights.get(each, usual)
                for each, usual in zip(joints.handles, joints.weights.tolist(), strict=True)
            ]
        )

    def _keep(self, joint: int, value: float) -> None:
        if joint in self.own:
            self.own.joint(joint).value = value
        else:
            self._values[joint] = value

    def _check_joint(self, joint: int) -> None:
        """Raise CommandError for an object other than a joint with a single value."""
        if joint in self.own:
            self.own.joint(joint)
        else:
            self._address(joint)

    def _takes_part(self, handle: int) -> bool:
        return handle not in self.passive

    def _limits(self, handle: int, with_margin: bool) -> tuple[float, float]:
        cyclic, least, extent = self.interval(handle)
        if cyclic or extent >= 1e9:
            return -math.inf, math.inf
        margin = min(self.margins.get(handle, 0.0), extent / 2) if with_margin else 0.0
        return least + margin, least + extent - margin

    def _address(self, joint: int) -> int:
        item = self._sim.scene.get_kind(joint, ObjectKind.JOINT)
        self._sim.joints.state(joint)
        if item.element != "joint":
            raise CommandError(f"'{item.name}' is driven through a tendon and takes no part in kinematics")
        return int(self._sim.model.jnt_qposadr[item.id])

    def _load(self) -> mujoco.MjData:
        data = self._scratch.load()
        for handle, value in self._values.items():
            if handle in self._sim.scene.objects:
                data.qpos[self._address(handle)] = value
        return data

    def _world_pose(self, handle: int) -> Pose:
        if handle in self.own:
            return self.own.pose(handle)
        if handle in self._poses:
            return self._poses[handle]
        item = self._sim.scene.get(handle)
        if item.element == "tendon":
            return object_pose(self._sim, item)
        self._sim.refresh()
        body, local = carrier_body(self._sim, item), fixed_pose(self._sim, item)
        data = self._load()
        kinematics(self._sim.model, data)
        return compose(pose_of_body(data, body), local)


def move_joint(sim: Simulation, handle: int, value: float) -> None:
    """Move a joint of the scene: by its motor if one drives it to targets, else at once."""
    if sim.is_running and sim.joints.mode(handle) == JointMode.FORCE:
        sim.joints.set_target_position(handle, value)
    else:
        sim.joints.set_position(handle, value)
