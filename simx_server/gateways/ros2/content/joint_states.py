"""``/joint_states``: position, velocity and force of every joint with a single value."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import partial

from simx_server.joints.joints import JOINT_TYPES, Joints
from simx_server.scene.objects import ObjectKind

from ..annotated.notes import Names, scene_period, unpublished
from ..endpoints import Content, Context, Message, Moment, Offer, Published

TYPE = "sensor_msgs/msg/JointState"

_SPHERICAL = JOINT_TYPES["ball"]


class JointStates(Content):
    """Publishes all joints in one message, in the order of the scene's objects."""

    def __init__(self, context: Context) -> None:
        self._robots = context.robots
        self._simulation = context.world.simulation

    def offers(self) -> Iterable[Offer]:
        scene, joints = self._simulation.scene, self._simulation.joints
        names, hidden = Names(scene, self._robots), unpublished(scene)
        handles = [
            each
            for each in scene.of_kind(ObjectKind.JOINT)
            if joints.joint_type(each) != _SPHERICAL and each not in hidden
        ]
        if handles:
            shown = tuple(names.joint(scene.objects[handle]) for handle in handles)
            make = partial(joint_message, joints, shown, tuple(handles))
            yield Published("/joint_states", TYPE, make, period=scene_period(scene))


def joint_message(joints: Joints, names: Sequence[str], handles: Sequence[int], moment: Moment) -> Message:
    """Return the JointState of some joints.

    Positions (rad, m) and velocities (rad/s, m/s) are those of the remote API. Efforts (N m, N) have the sign of ROS:
    a positive one pushes to greater positions. The remote API has the reverse, as V-REP.
    """
    return {
        "header": moment.header(""),
        "name": names,
        "position": [*map(joints.position, handles)],
        "velocity": [*map(joints.velocity, handles)],
        "effort": [-force for force in map(joints.force, handles)],
    }
