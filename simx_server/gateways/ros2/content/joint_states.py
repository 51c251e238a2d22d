"""``/joint_states``: position, velocity and force of every joint with a single value."""

from __future__ import annotations

from collections.abc import Iterable

from simx_server.joints.joints import JOINT_TYPES
from simx_server.scene.objects import ObjectKind

from ..endpoints import Content, Context, Message, Moment, Offer, Published
from .naming import joint_name

_SPHERICAL = JOINT_TYPES["ball"]


class JointStates(Content):
    """Publishes all joints in one message, in the order of the scene's objects.

    Positions (rad, m) and velocities (rad/s, m/s) are those of the remote API. Efforts (N m, N) have the sign of ROS:
    a positive one pushes to greater positions. The remote API has the reverse, as V-REP.
    """

    def __init__(self, context: Context) -> None:
        self._simulation = context.world.simulation
        self._names: tuple[str, ...] = ()
        self._handles: tuple[int, ...] = ()

    def offers(self) -> Iterable[Offer]:
        scene, joints = self._simulation.scene, self._simulation.joints
        handles = [each for each in scene.of_kind(ObjectKind.JOINT) if joints.joint_type(each) != _SPHERICAL]
        self._handles = tuple(handles)
        self._names = tuple(joint_name(scene.objects[handle]) for handle in handles)
        if handles:
            yield Published("/joint_states", "sensor_msgs/msg/JointState", self._message)

    def _message(self, moment: Moment) -> Message:
        joints, handles = self._simulation.joints, self._handles
        return {
            "header": moment.header(""),
            "name": self._names,
            "position": [*map(joints.position, handles)],
            "velocity": [*map(joints.velocity, handles)],
            "effort": [-force for force in map(joints.force, handles)],
        }
