"""A client that behaves as the hardware interface of `topic_based_ros2_control`, without ROS.

It does what that package and its successor `joint_state_topic_hardware_interface` do: `read` takes over the newest
joint state; `write` publishes the commands of all joints, unless positions and commanded positions together differ by
no more than a threshold. Each array has the joints with that command interface only. Commands are 0 until a controller
sets them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ros2_world import JOINT_STATE, Peer, Sent

from simx_server.ros2_messages import BY_NAME

TYPE = BY_NAME["sensor_msgs/msg/JointState"]
INTERFACES = ("position", "velocity", "effort")


class TopicBasedSystem:
    """The joints of a robot, as controllers see them.

    Attributes:
        states, commands: of each interface, the value of each joint.
    """

    def __init__(
        self,
        peer: Peer,
        joints: Mapping[str, Sequence[str]],
        *,
        commands_topic: str = "robot_joint_commands",
        states_topic: str = "robot_joint_states",
        threshold: float = 1e-5,
    ) -> None:
        """Listen to the states.

        Args:
            joints: names, with the command interfaces of each.
            threshold: `trigger_joint_command_threshold`.
        """
        self._peer, self._joints, self.threshold = peer, joints, threshold
        self._names = list(joints)
        self.states, self.commands = (
            {interface: [0.0] * len(joints) for interface in INTERFACES} for _ in range(2)
        )
        self._states_key, self._commands_key = (
            f"0/{states_topic}/{JOINT_STATE}",
            f"0/{commands_topic}/{JOINT_STATE}",
        )
        peer.listen(self._states_key)

    def read(self, stamp: float) -> None:
        """Take over the state of a moment in seconds."""

        def is_wanted(sent: Sent) -> bool:
            return abs(sent.stamp - stamp) < 1e-6

        latest = self._peer.next(self._states_key, is_wanted).value
        for at, name in enumerate(latest["name"]):
            if name in self._joints:
                joint = self._names.index(name)
                self.states["position"][joint] = float(latest["position"][at])
                for interface in INTERFACES[1:]:
                    if len(latest[interface]):
                        self.states[interface][joint] = float(latest[interface][at])

    def write(self) -> bool:
        """Publish the commands, and return whether they were published."""
        pairs = zip(self.states["position"], self.commands["position"], strict=True)
        if sum(abs(state - command) for state, command in pairs) <= self.threshold:
            return False
        message: dict[str, list[Any]] = {"name": [], **{interface: [] for interface in INTERFACES}}
        for joint, (name, interfaces) in enumerate(self._joints.items()):
            message["name"].append(name)
            for interface in interfaces:
                message[interface].append(self.commands[interface][joint])
        self._peer.put(self._commands_key, TYPE.encode(message))
        return True
