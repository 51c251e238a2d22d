"""The arms of a scene: tips that several motors move.

The tips of the scene's inverse kinematics are arms. Without such, the dummy or else the shape behind most joints
is one.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import CommandError
from simx_server.joints.servo import Rule
from simx_server.joints.state import JointMode
from simx_server.kinematics.chain import Arm as Chain
from simx_server.kinematics.chain import Constraint, Element, Joints, NothingMovesError, make_arms
from simx_server.scene.objects import ObjectKind

if TYPE_CHECKING:
    from simx_server.kinematics import IkGroups
    from simx_server.simulation.simulation import Simulation

LEAST_JOINTS = 2
_FOR_A_POSE = 6
"""Joints that a position and an orientation need; the tips of shorter arms keep no orientation."""

_PRECISION = (1e-6, 1e-5)
"""Metres and radians that count as reached: a slow tip moves a fraction of a millimetre in a simulation step."""

BY_VELOCITY = (Rule.VELOCITY, Rule.HOLD, Rule.MOTION)
_IMMOVABLE = (Rule.FREE, Rule.DEPENDENT, Rule.PROFILE)


@dataclass(frozen=True)
class Arm:
    """One arm, as the scene has it now."""

    tip: int
    joints: Joints
    chain: list[Chain]


def arm_of(sim: Simulation, tip: int) -> Arm:
    """Return the arm with a tip. Raises CommandError: less than two motors move it."""
    joints, chain = make_arms(sim, [_element(tip, Constraint.POSE)], lambda joint: _is_moved(sim, joint))
    if len(joints.handles) < LEAST_JOINTS:
        raise NothingMovesError(f"only one joint moves '{sim.scene.get(tip).name}'")
    if len(joints.handles) < _FOR_A_POSE:
        joints, chain = make_arms(
            sim, [_element(tip, Constraint.POSITION)], lambda joint: _is_moved(sim, joint)
        )
    return Arm(tip, joints, chain)


def find_tips(sim: Simulation, groups: IkGroups) -> list[int]:
    """Return the tips of all arms, those of the scene's inverse kinematics first."""
    found: dict[int, None] = {}
    for element in groups.elements():
        if element.tip in sim.scene.objects and _count(sim, element.tip) >= LEAST_JOINTS:
            found.setdefault(element.tip)
    if found:
        return list(found)
    for kind in (ObjectKind.DUMMY, ObjectKind.SHAPE):  # a shape behind a dummy may be a finger
        counts = {handle: _count(sim, handle) for handle in sim.scene.of_kind(kind)}
        longest = max(counts, key=lambda handle: counts[handle], default=-1)
        if counts.get(longest, 0) >= LEAST_JOINTS:
            return [longest]
    return []


def find_tip(sim: Simulation, groups: IkGroups, name: str) -> int:
    """Return the tip of an arm by its name, or by that of an object that carries it; empty: the first arm.

    Raises:
        CommandError: the scene has no such arm; the text lists those that it has.
    """
    tips = find_tips(sim, groups)
    names = ", ".join(sim.scene.get(tip).name for tip in tips)
    if not name:
        if not tips:
            raise CommandError(
                "the scene has no arm: no object that two or more motors move, one behind the other; mobile robots are "
                "driven by ROS 2 (--ros2) or by a program"
            )
        return tips[0]
    handle = sim.scene.resolve(name)
    if handle in tips:
        return handle
    below = sim.scene.descendants(handle)
    carried = next((tip for tip in tips if tip in below), None)
    if carried is not None:
        return carried
    if _count(sim, handle) >= LEAST_JOINTS:
        return handle
    counts = {each: _count(sim, each) for each in below}
    longest = max(counts, key=lambda each: counts[each], default=handle)
    if counts.get(longest, 0) >= LEAST_JOINTS:
        return longest
    raise CommandError(
        f"'{name}' is no arm: less than two motors move it; the arms of this scene: {names or 'none'}"
    )


def commanded(sim: Simulation, joint: int) -> float:
    """Return where a joint is told to be, or where it is, if it has not got there yet; rad or m."""
    present = sim.joints.position(joint)
    if not _obeys_target(sim, joint):
        return present
    target = sim.joints.target_position(joint)
    return target if abs(target - present) < _NEAR else present


def command(sim: Simulation, joint: int, value: float) -> None:
    """Have a joint be at a value, rad or m, at the end of the coming simulation step. Raises CommandError."""
    if sim.joints.rule(joint) in BY_VELOCITY:
        sim.joints.set_target_velocity(joint, (value - sim.joints.position(joint)) / sim.time_step)
    elif _obeys_target(sim, joint):
        sim.joints.set_target_position(joint, value)
    else:
        sim.joints.set_position(joint, value)


_NEAR = 0.2
"""Difference, rad or m, up to which a target position is one that the joint has almost reached."""


def _obeys_target(sim: Simulation, joint: int) -> bool:
    return sim.joints.mode(joint) == JointMode.FORCE or sim.joints.is_hybrid(joint)


def _is_moved(sim: Simulation, joint: int) -> bool:
    return sim.joints.rule(joint) not in _IMMOVABLE


def _count(sim: Simulation, tip: int) -> int:
    """Return how many motors move an object."""
    try:
        joints, _ = make_arms(sim, [_element(tip, Constraint.POSE)], lambda joint: _is_moved(sim, joint))
    except NothingMovesError:
        return 0
    return len(joints.handles)


def _element(tip: int, constraints: Constraint) -> Element:
    return Element(tip, -1, constraints=constraints, precision=_PRECISION)
