"""Joints of one robot on separate topics, as topic-based ros2_control has them.

An object with `states` publishes its joints there, and one with `command` takes commands for them. Its joints are those
that `joints` lists with names and offsets, or else itself and all joints below it.
"""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from simx_server.joints.joints import JOINT_TYPES, Joints
from simx_server.scene.formats.annotations import Annotation
from simx_server.scene.formats.annotations.ros2_keys import read_joints
from simx_server.scene.objects import ObjectKind, Scene, SceneObject

from ..content.joint_commands import QOS, joint_calls
from ..content.joint_states import joint_message
from ..endpoints import Commanded, Content, Context, Message, Moment, Offer, Published
from ..table_call import Call
from .notes import Names, annotated, joints_below, period_of

logger = logging.getLogger(__name__)

TYPE = "sensor_msgs/msg/JointState"


class Group(NamedTuple):
    """The joints of an object."""

    names: tuple[str, ...]
    handles: tuple[int, ...]
    offsets: tuple[float, ...]
    """Positions in ROS 2 minus those in the scene, rad or m."""


class JointGroups(Content):
    """Publishes and takes JointState for the joints of each annotated object."""

    def __init__(self, context: Context) -> None:
        self._robots = context.robots
        self._simulation = context.world.simulation

    def offers(self) -> Iterable[Offer]:
        scene = self._simulation.scene
        names = Names(scene, self._robots)
        for item, note in annotated(scene, self._robots, "states", "command"):
            group = group_of(scene, self._simulation.joints, names, item, note)
            if not group.handles:
                continue
            if "states" in note:
                make, period = partial(self._message, group), period_of(note)
                yield Published(names.topic(item, str(note["states"])), TYPE, make, period=period)
            if "command" in note:
                calls = partial(self._calls, group)
                yield Commanded(names.topic(item, str(note["command"])), TYPE, calls, QOS)

    def _message(self, group: Group, moment: Moment) -> Message:
        made = dict(joint_message(self._simulation.joints, group.names, group.handles, moment))
        made["position"] = [
            position + offset for position, offset in zip(made["position"], group.offsets, strict=True)
        ]
        return made

    def _calls(self, group: Group, message: Mapping[str, Any]) -> Iterator[Call]:
        handles = dict(zip(group.names, group.handles, strict=True))
        positions: Sequence[float] = message["position"]
        if len(positions) == len(message["name"]):
            offsets = dict(zip(group.names, group.offsets, strict=True))
            shifts = [offsets.get(name, 0.0) for name in message["name"]]
            message = {**message, "position": np.asarray(positions) - np.array(shifts)}
        return joint_calls(self._simulation.joints, handles, message)


def group_of(scene: Scene, joints: Joints, names: Names, item: SceneObject, note: Annotation) -> Group:
    """Return the joints of an annotated object."""
    found: list[tuple[str, int, float]] = []
    if "joints" in note:
        for joint, name, offset in read_joints(str(note["joints"])):
            handle = scene.by_name(joint)
            if handle is None or scene.objects[handle].kind is not ObjectKind.JOINT:
                logger.warning("ROS 2: joint %s of %s is missing", joint, item.name)
            else:
                found.append((names.prefixed(item, name), handle, offset))
    else:
        found = [(names.joint(joint), joint.handle, 0.0) for joint in joints_below(scene, item)]
    scalar = [each for each in found if joints.joint_type(each[1]) != JOINT_TYPES["ball"]]
    return Group(
        tuple(name for name, _, _ in scalar),
        tuple(handle for _, handle, _ in scalar),
        tuple(offset for _, _, offset in scalar),
    )
