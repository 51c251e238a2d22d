"""``/joint_command``: moves joints by name, as Isaac Sim's topic of that name and topic-based ros2_control do."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from simx_client.protocol.nearest import did_you_mean
from simx_server.errors import CommandError
from simx_server.joints.joints import JOINT_TYPES, Joints
from simx_server.joints.servo import Rule
from simx_server.joints.state import JointMode
from simx_server.scene.objects import ObjectKind

from ..annotated.notes import Names
from ..endpoints import Commanded, Content, Context, Offer
from ..table_call import Call
from ..wire.qos import Qos

TYPE = "sensor_msgs/msg/JointState"
FIELDS = ("position", "velocity", "effort")
"""The first of them that has a number for a joint says how it is moved."""

QOS = Qos(depth=100)
"""Several nodes may command a part of the joints each, many times between two simulation steps."""

LARGEST = 1e9
"""The greatest magnitude of a number, as limits of V-REP's joints have."""

FULL_SPEED = 1e4
"""Target velocity, rad/s or m/s, of a joint that is moved by an effort: its force is the limit."""


class JointCommands(Content):
    """Takes JointState messages with the names of joints.

    Each of the arrays is empty or as long as the names. A number that is NaN leaves the joint alone.
    """

    def __init__(self, context: Context) -> None:
        self._robots = context.robots
        self._simulation = context.world.simulation
        self._handles: dict[str, int] = {}

    def offers(self) -> Iterable[Offer]:
        scene, joints = self._simulation.scene, self._simulation.joints
        names = Names(scene, self._robots)
        self._handles = {
            names.joint(scene.objects[handle]): handle
            for handle in scene.of_kind(ObjectKind.JOINT)
            if joints.joint_type(handle) != JOINT_TYPES["ball"]
        }
        if self._handles:
            yield Commanded("/joint_command", TYPE, self._calls, QOS)

    def _calls(self, message: Mapping[str, Any]) -> Iterator[Call]:
        return joint_calls(self._simulation.joints, self._handles, message)


def joint_calls(joints: Joints, handles: Mapping[str, int], message: Mapping[str, Any]) -> Iterator[Call]:
    """Yield the calls of a JointState that is a command.

    Args:
        joints: those of the scene.
        handles: of the joints that may be commanded, by name.
        message: its numbers are arrays.

    Raises:
        CommandError: a name is unknown, or the arrays do not fit; then nothing of it is executed.
    """
    names: Sequence[str] = message["name"]
    given = {field: values for field in FIELDS if len(values := message[field])}
    for field, values in given.items():
        if len(values) != len(names):
            raise CommandError(
                f"{field} has {len(values)} numbers for {len(names)} names; give each array as many numbers as names, "
                "NaN for a joint that stays as it is, or none"
            )
    if not names:
        raise CommandError("the message names no joints")
    if len(set(names)) < len(names):  # otherwise a message could have very many calls
        twice, _ = Counter(names).most_common(1)[0]
        raise CommandError(f"'{twice[:80]}' is named twice; name each joint once")
    wanted: list[tuple[int, str, float]] = []
    columns = [(field, values.tolist()) for field, values in given.items()]
    for position, name in enumerate(names):
        handle = handles.get(name)
        if handle is None:
            raise CommandError(f"there is no joint '{name[:80]}'{did_you_mean(name[:80], list(handles))}")
        for field, values in columns:
            value = values[position]
            if abs(value) > LARGEST:
                raise CommandError(
                    f"the {field} of '{name[:80]}' is {value:g}; valid: numbers up to {LARGEST:g}, or NaN for none"
                )
            if value == value:
                wanted.append((handle, field, value))
                break
    return _calls(joints, wanted)


def _calls(joints: Joints, wanted: Iterable[tuple[int, str, float]]) -> Iterator[Call]:
    for handle, field, value in wanted:
        if field == "position":
            command = "simxSetJointTargetPosition" if has_target(joints, handle) else "simxSetJointPosition"
            yield Call(command, [handle, value])
        elif field == "velocity":
            yield Call("simxSetJointTargetVelocity", [handle, value])
        else:
            yield Call("simxSetJointTargetVelocity", [handle, math.copysign(FULL_SPEED, value)])
            yield Call("simxSetJointForce", [handle, abs(value)])


def has_target(joints: Joints, handle: int) -> bool:
    """Return whether a motor or a motion profile moves a joint to positions; else it is put there at once."""
    if joints.rule(handle) is Rule.KINEMATIC:  # in V-REP's force mode too, where physics does not move it
        return False
    if joints.mode(handle) is JointMode.FORCE or joints.is_hybrid(handle):
        return True
    return joints.moves_by_profile(handle)
