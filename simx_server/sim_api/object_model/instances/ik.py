"""The classes of `simIK-2`: worlds of inverse kinematics, their groups, elements and objects, over `kinematics/`."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from simx_server.errors import CommandError
from simx_server.kinematics import Calculation, Element, Method, Result, Solution
from simx_server.kinematics.environment import Environment, EnvironmentGroup, GroupFlag
from simx_server.parts.instances import Instance, Instances
from simx_server.scene.objects import ObjectKind

if TYPE_CHECKING:
    from collections.abc import Hashable

    from simx_server.world.world import World

NOT_PERFORMED, OUT_OF_TOLERANCE, BOUNDS_HIT = 1, 16, 64
"""Flags of a result: `simIK.calc_*`."""

_Instance = TypeVar("_Instance", bound=Instance)

METHODS = {
    "pseudoInverse": Method.PSEUDO_INVERSE,
    "undampedPseudoInverse": Method.PSEUDO_INVERSE,  # the plain one has no damping either
    "dampedLeastSquares": Method.DAMPED_LEAST_SQUARES,
    "jacobianTranspose": Method.JACOBIAN_TRANSPOSE,
}


@dataclass(eq=False)
class IkObject(Instance):
    """An object of the scene in a world of inverse kinematics, where it may have another pose."""

    kind = "IKObject"

    world: IkWorld
    scene_handle: int


@dataclass(eq=False)
class IkJoint(IkObject):
    """A joint, which may have another position there."""

    kind = "IKJoint"


@dataclass(eq=False)
class IkElement(Instance):
    """A tip that follows a target."""

    kind = "IKElement"

    group: IkGroup
    number: int
    joints: list[IkJoint]
    """From the base to the tip."""
    base: IkObject | None
    """None: the world."""
    tip: IkObject
    target: IkObject

    @property
    def element(self) -> Element:
        """Return what the solver knows of it."""
        return self.group.group.elements[self.number]

    def change(self, **what: Any) -> None:
        """Change fields of the element."""
        self.group.group.elements[self.number] = replace(self.element, **what)


@dataclass(eq=False)
class IkGroup(Instance):
    """Elements that are solved together."""

    kind = "IKGroup"

    world: IkWorld
    group: EnvironmentGroup
    method: str = "pseudoInverse"
    elements: list[IkElement] = field(default_factory=list[IkElement])

    @property
    def is_enabled(self) -> bool:
        """Return whether it is solved."""
        return bool(self.group.flags & GroupFlag.ENABLED)

    def enable(self, enabled: bool) -> None:
        """Solve it, or leave it out."""
        flags = self.group.flags & ~GroupFlag.ENABLED
        self.group.flags = flags | GroupFlag.ENABLED if enabled else flags

    def calculate(self, method: str, damping: float, iterations: int) -> None:
        """Choose how it is solved. Raises CommandError."""
        if method not in METHODS:
            raise CommandError(f"'{method[:40]}' is no method; those are {', '.join(METHODS)}")
        self.group.how = Calculation.checked(int(METHODS[method]), damping, iterations)
        self.method = method

    @property
    def joints(self) -> list[IkJoint]:
        """Return the joints of all elements, each once."""
        return list(dict.fromkeys(joint for element in self.elements for joint in element.joints))

    @property
    def can_solve(self) -> bool:
        """Return whether an enabled element has a joint that may move."""
        passive = self.world.environment.passive
        return self.is_enabled and any(
            element.element.enabled and any(joint.scene_handle not in passive for joint in element.joints)
            for element in self.elements
        )


@dataclass(eq=False)
class IkWorld(Instance):
    """A world of inverse kinematics: joints and objects of the scene, with positions and poses in this world."""

    kind = "IK"

    environment: Environment
    groups: list[IkGroup] = field(default_factory=list[IkGroup])
    objects: dict[int, IkObject] = field(default_factory=dict[int, IkObject])
    """By handle in the scene."""

    def objects_of(self, world: World, handles: Iterable[int]) -> None:
        """Make the objects for objects of the scene that have none yet."""
        scene = world.simulation.scene
        for handle in handles:
            if handle not in self.objects:
                made = IkJoint if scene.get(handle).kind == ObjectKind.JOINT else IkObject
                self.objects[handle] = _added(world.instances, made(self, handle), self.owner)

    def remove_from(self, instances: Instances) -> None:
        """Remove the world with everything in it."""
        parts: list[Instance] = [*self.objects.values(), *self.groups, self]
        parts += [element for group in self.groups for element in group.elements]
        for each in parts:
            instances.remove(each.handle)


def _added(instances: Instances, instance: _Instance, owner: Hashable) -> _Instance:
    instance.owner = owner
    return instances.add(instance)


def make_world(world: World, owner: Hashable) -> IkWorld:
    """Make an empty world of inverse kinematics."""
    return _added(world.instances, IkWorld(Environment(world.simulation)), owner)


def make_group(world: World, ik: IkWorld) -> IkGroup:
    """Make a group without elements."""
    handle = max(ik.environment.groups, default=0) + 1
    group = EnvironmentGroup(f"group{handle}")
    made = _added(world.instances, IkGroup(ik, group), ik.owner)
    ik.environment.groups[handle] = group
    ik.groups.append(made)
    return made


def add_element(world: World, group: IkGroup, element: Element) -> IkElement:
    """Add an element to a group, with the objects from its tip and its target up to the top of the scene.

    Raises:
        CommandError: no joint lies between base and tip, or an object does not exist.
    """
    ik, scene = group.world, world.simulation.scene
    for handle in (element.tip, element.target, element.base):
        if handle != -1:
            scene.get(handle)
    chain = _above(world, element.tip)
    if element.base not in (-1, *chain):
        raise CommandError(f"'{scene.get(element.base).name}' is not above '{scene.get(element.tip).name}'")
    number = ik.environment.add(group.group, element)
    try:
        ik.objects_of(world, [*chain, *_above(world, element.target)])
        between = chain[: chain.index(element.base)] if element.base != -1 else chain
        found = [ik.objects[handle] for handle in reversed(between)]
        made = IkElement(
            group,
            number,
            [each for each in found if isinstance(each, IkJoint)],
            ik.objects.get(element.base),
            ik.objects[element.tip],
            ik.objects[element.target],
        )
        _added(world.instances, made, ik.owner)
    except CommandError:
        del group.group.elements[number]
        raise
    for joint in made.joints:
        if world.simulation.joints.mode(joint.scene_handle) == _DEPENDENT:
            ik.environment.passive.add(joint.scene_handle)
    group.elements.append(made)
    return made


_DEPENDENT = 4


def _above(world: World, handle: int) -> list[int]:
    """Return an object and those above it."""
    found: list[int] = []
    while handle != -1:
        found.append(handle)
        handle = world.simulation.scene.get(handle).parent
    return found


@dataclass(frozen=True)
class Outcome:
    """The result of solving groups."""

    is_solved: bool
    flags: int
    precision: tuple[float, float]
    """Greatest distance (m) and angle (rad) that are left."""


def solve(groups: Sequence[IkGroup], *, syncs: bool, any_precision: bool) -> Outcome:
    """Solve groups of one world in sequence.

    Args:
        groups: the groups.
        syncs: take the scene's state before, and move its joints after a success.
        any_precision: tips that do not reach their targets are a success too.

    Raises:
        CommandError: no group can be solved.
    """
    wanted = [each for each in groups if each.can_solve]
    if not wanted:
        raise CommandError(
            "nothing to solve: no enabled group has an enabled element with a joint that may move"
        )
    environment, parts = wanted[0].world.environment, [each.group for each in wanted]
    if syncs:
        environment.take_over(parts)
    solutions = [environment.handle(each) for each in parts]
    outcome = _outcome(solutions, any_precision=any_precision)
    if syncs and outcome.is_solved:
        environment.give_back(parts)
    elif syncs:
        environment.take_over(parts)
    return outcome


def _outcome(solutions: Sequence[Solution], *, any_precision: bool) -> Outcome:
    reached = all(each.result == Result.SUCCESS for each in solutions)
    flags = 0 if reached else OUT_OF_TOLERANCE
    flags |= BOUNDS_HIT if not reached and any(each.is_at_limit for each in solutions) else 0
    left = max(each.distance for each in solutions), max(each.angle for each in solutions)
    return Outcome(reached or any_precision, flags, left)


def positions(joints: Sequence[IkJoint]) -> np.ndarray:
    """Return the positions of joints of one world (n,)."""
    return np.array(
        [each.world.environment.joint_position(each.scene_handle) for each in joints], dtype=float
    )
