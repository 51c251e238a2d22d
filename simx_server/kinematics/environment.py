"""A separate world for `simIK`: joint values and poses that are changed and solved without moving the scene.

Objects have the same handles as in the scene. Joints and poses that were not set here are those of the scene.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from simx_server.scene.geometry.frames import get_pose
from simx_server.scene.geometry.placing import carrier_body, object_pose
from simx_server.scene.geometry.poses import IDENTITY, Pose, compose, inverse
from simx_server.world.sleepers import kinematics

from ..errors import CommandError
from ..joints import JointMode
from ..scene.objects import ObjectKind
from .chain import Element, Joints, fixed_pose, make_arms
from .scratch import Scratch
from .solver import Calculation, Method, Solution, Solver, pose_of_body

if TYPE_CHECKING:
    from simx_server.world.simulation import Simulation

_FIRST_DUMMY = 1_000_000
"""First handle of an environment's dummies, above all handles of a scene's objects."""

_START = Calculation(Method.PSEUDO_INVERSE, 0.0, 6)
"""The calculation of CoppeliaSim's new groups."""


@dataclass
class EnvironmentGroup:
    """Elements that are solved together."""

    name: str
    how: Calculation = _START
    elements: dict[int, Element] = field(default_factory=dict[int, Element])
    solution: Solution | None = None
    """The result of the last handling."""


class Environment:
    """One environment."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._scratch = Scratch(sim)
        self.groups: dict[int, EnvironmentGroup] = {}
        self.passive: set[int] = set()
        """Handles of joints that take no part."""
        self.dummies: dict[int, str] = {}
        """Handles and names of the dummies that exist in this environment only."""
        self._values: dict[int, float] = {}
        self._poses: dict[int, Pose] = {}
        self._intervals: dict[int, tuple[bool, float, float]] = {}

    def joint_position(self, joint: int) -> float:
        """Return the position of a joint, rad or m.

        Raises:
            UnknownHandle, WrongKind, CommandError: the joint has no single value.
        """
        self._address(joint)
        return self._values.get(joint, self._sim.joints.position(joint))

    def set_joint_position(self, joint: int, value: float) -> None:
        """Set the position of a joint, limited to its interval as in the scene."""
        self._address(joint)
        cyclic, least, extent = self.interval(joint)
        if not cyclic and extent < 1e9:
            value = min(max(value, least), least + extent)
        self._values[joint] = value

    def interval(self, joint: int) -> tuple[bool, float, float]:
        """Return (cyclic, minimum, range)."""
        return self._intervals.get(joint) or self._sim.joints.interval(joint)

    def set_interval(self, joint: int, cyclic: bool, least: float, extent: float) -> None:
        self._address(joint)
        self._intervals[joint] = cyclic, least, extent

    def pose(self, handle: int, relative_to: int = -1) -> Pose:
        """Return an object's pose with the joints where this environment has them.

        Raises:
            UnknownHandle: the object does not exist.
        """
        world = self._world_pose(handle)
        return world if relative_to == -1 else compose(inverse(self._world_pose(relative_to)), world)

    def set_pose(self, handle: int, relative_to: int, pose: Pose) -> None:
        """Set the pose of a target; the object's children stay where they are.

        Raises:
            UnknownHandle: the object does not exist.
        """
        if handle not in self.dummies:
            self._sim.scene.get(handle)
        self._poses[handle] = pose if relative_to == -1 else compose(self._world_pose(relative_to), pose)

    def create_dummy(self, name: str) -> int:
        """Create a pose that the scene does not have; return its handle."""
        handle = _FIRST_DUMMY + len(self.dummies)
        self.dummies[handle] = name or f"dummy{handle}"
        self._poses[handle] = IDENTITY
        return handle

    def add(self, group: EnvironmentGroup, element: Element) -> int:
        """Add an element of the scene, with its present joints and poses; return its number.

        Raises:
            CommandError: no joint takes part, or the base is not above the tip.
        """
        make_arms(self._sim, [element], self._takes_part)
        number = max(group.elements, default=-1) + 1
        group.elements[number] = element
        for handle in self.joints(group).handles:
            self._values.setdefault(handle, self._sim.joints.position(handle))
        if element.target not in self.dummies:
            self._poses[element.target] = get_pose(self._sim, element.target)
        return number

    def take_over(self, groups: Iterable[EnvironmentGroup]) -> None:
        """Copy the scene's present state: values of the groups' joints, poses of their tips' targets."""
        self._sim.refresh()
        for group in groups:
            for handle in self.joints(group).handles:
                self._values[handle] = self._sim.joints.position(handle)
            for element in group.elements.values():
                self._poses.pop(element.tip, None)
                if element.target not in self.dummies:
                    self._poses[element.target] = get_pose(self._sim, element.target)

    def give_back(self, groups: Iterable[EnvironmentGroup]) -> None:
        """Move the scene's joints to the values of the groups here: by their motors where they have any."""
        for group in groups:
            for handle in self.joints(group).handles:
                move_joint(self._sim, handle, self._values[handle])

    def joints(self, group: EnvironmentGroup) -> Joints:
        """Return the joints that the group moves.

        Raises:
            CommandError: there are none.
        """
        return self.solver(group)[0]

    def solver(
        self, group: EnvironmentGroup, only: tuple[int, ...] | None = None, limits: bool = True
    ) -> tuple[Joints, Solver]:
        """Return joints and solver of a group on the environment's state.

        Args:
            group: the group.
            only: handles of the joints that move; the others stay.
            limits: whether the limits of the joints count.
        """
        if not group.elements:
            raise CommandError(
                f"the group '{group.name}' has no element; add one with simIK.addElementFromScene"
            )

        def takes_part(handle: int) -> bool:
            return self._takes_part(handle) and (only is None or handle in only)

        joints, arms = make_arms(self._sim, list(group.elements.values()), takes_part)
        bounds = [self._limits(handle) if limits else (-math.inf, math.inf) for handle in joints.handles]
        low, high = np.array(bounds, dtype=float).T
        joints = replace(joints, low=low, high=high)
        self._load()
        return joints, Solver(self._scratch, self._sim.model, joints, arms)

    def goals(self, group: EnvironmentGroup) -> list[Pose]:
        """Return the world poses of the targets."""
        return [self._world_pose(element.target) for element in group.elements.values()]

    def tips(self, group: EnvironmentGroup) -> list[Pose]:
        """Return the world poses of the tips."""
        return [self._world_pose(element.tip) for element in group.elements.values()]

    def handle(self, group: EnvironmentGroup) -> Solution:
        """Solve, and keep the result, even if it is only the nearest."""
        goals = self.goals(group)
        joints, solver = self.solver(group)
        start = np.array([self._values[handle] for handle in joints.handles])
        group.solution = solver.solve(start, goals, group.how)
        self._values.update(zip(joints.handles, group.solution.values.tolist(), strict=True))
        return group.solution

    def _takes_part(self, handle: int) -> bool:
        return handle not in self.passive

    def _limits(self, handle: int) -> tuple[float, float]:
        cyclic, least, extent = self.interval(handle)
        return (-math.inf, math.inf) if cyclic or extent >= 1e9 else (least, least + extent)

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
