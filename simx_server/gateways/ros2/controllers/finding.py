"""Find the arms and grippers of a scene by its joints.

An arm is a chain of at least three joints of one robot, each below the one before, without a branch and without a motor
that keeps a velocity, as wheels have. Sliding joints at its end belong to a gripper. A gripper is the other driven
joints below the last joint of an arm.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from simx_server.joints.joints import JOINT_TYPES, Joints
from simx_server.joints.servo import Rule
from simx_server.scene.objects import ObjectKind, Scene, SceneObject

LEAST_JOINTS = 3
"""Joints of an arm; shorter chains are wheels, fingers and cameras that turn."""

_FOLLOWING = (Rule.DEPENDENT, Rule.FREE)
"""Rules of joints that nothing drives."""

_DRIVEN = (Rule.POSITION, Rule.SPRING, Rule.STIFF_SPRING), (Rule.VELOCITY, Rule.HOLD)
"""Rules of the joints that open a gripper: of the first kind, else of the second."""


@dataclass(frozen=True, slots=True)
class Arm:
    """The joints of an arm, from its base on, and the gripper below them.

    Attributes:
        robot: the model, or the object at the top.
        is_alone: the robot has no other arm.
        gripper: handles of the joints that open and close it; empty for none.
        has_targets: the joints of the gripper move to positions; else their motors keep velocities.
    """

    robot: SceneObject
    joints: Sequence[int]
    is_alone: bool
    gripper: Sequence[int]
    has_targets: bool


def find_arms(scene: Scene, joints: Joints) -> list[Arm]:
    """Return the arms in the order of the scene."""
    chains: list[tuple[int, list[int]]] = []
    scalar = [
        handle
        for handle in scene.of_kind(ObjectKind.JOINT)
        if joints.joint_type(handle) != JOINT_TYPES["ball"]
    ]
    known = set(scalar)
    above = {handle: _joint_above(scene, handle, known) for handle in scalar}
    below: dict[int, list[int]] = {}
    for handle, parent in above.items():
        below.setdefault(parent, []).append(handle)
    for handle in scalar:
        parent = above[handle]
        is_first = parent == -1 or len(below[parent]) > 1
        if not is_first or joints.rule(handle) in _FOLLOWING:
            continue
        chain = [handle]
        while len(following := below.get(chain[-1], [])) == 1 and joints.rule(following[0]) not in _FOLLOWING:
            chain += following
        chain = _without_gripper(joints, chain)
        if len(chain) >= LEAST_JOINTS and not any(joints.rule(each) in _DRIVEN[1] for each in chain):
            chains.append((_robot(scene, handle), chain))
    return [*_with_grippers(scene, joints, chains)]


def _with_grippers(scene: Scene, joints: Joints, chains: list[tuple[int, list[int]]]) -> Iterator[Arm]:
    of_arms = {handle for _, chain in chains for handle in chain}
    robots = [robot for robot, _ in chains]
    for robot, chain in chains:
        others = [
            handle
            for handle in scene.descendants(chain[-1])
            if scene.objects[handle].kind is ObjectKind.JOINT
            and handle not in of_arms
            and joints.joint_type(handle) != JOINT_TYPES["ball"]
        ]
        by_rule = [[handle for handle in others if joints.rule(handle) in rules] for rules in _DRIVEN]
        gripper = by_rule[0] or by_rule[1]
        yield Arm(scene.objects[robot], chain, robots.count(robot) == 1, gripper, bool(by_rule[0]))


def _without_gripper(joints: Joints, chain: list[int]) -> list[int]:
    """Return a chain without sliding joints at its end, if enough others are left."""
    end = len(chain)
    while end and joints.joint_type(chain[end - 1]) == JOINT_TYPES["slide"]:
        end -= 1
    return chain[:end] if end >= LEAST_JOINTS else chain


def _joint_above(scene: Scene, handle: int, joints: set[int]) -> int:
    """Return the nearest joint above one in the same robot; -1 for none."""
    robot = _robot(scene, handle)
    each = scene.objects[handle].parent
    while each in scene.objects:
        if each in joints:
            return each if _robot(scene, each) == robot else -1
        each = scene.objects[each].parent
    return -1


def _robot(scene: Scene, handle: int) -> int:
    """Return the model to which an object belongs, or the object at the top above it."""
    while not scene.is_model_base(handle) and scene.objects[handle].parent in scene.objects:
        handle = scene.objects[handle].parent
    return handle
