"""Joints: single ones, and several that are read and set together.

Units: radians, rad/s and N m for revolute joints; metres, m/s and N for prismatic joints.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, NoReturn, SupportsFloat, overload

from simx_client.calls.answers import Answer
from simx_client.calls.strict import Strict
from simx_client.connection.calls import Calls
from simx_client.protocol import constants as c

from .objects import SceneObject

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from simx_client.client.channel import Channel

    from .poses import Array, Numbers

_TARGETS = "targets are write only: the legacy API has no call that reads them; keep what was set"


class Joint(SceneObject):
    """A joint and its motor."""

    __slots__ = ()
    object_type = c.sim_object_joint_type

    @property
    def position(self) -> float:
        """Return the joint position in rad or m. Setting it moves the joint at once, within its limits; its
        motor may then move it again."""
        return self._request(lambda calls: calls.simxGetJointPosition(self.handle))

    @position.setter
    def position(self, position: SupportsFloat) -> None:
        self._send(lambda calls: calls.simxSetJointPosition(self.handle, position))

    @property
    def velocity(self) -> float:
        """Return the joint velocity in rad/s or m/s."""
        return self._request(
            lambda calls: calls.simxGetObjectFloatParameter(self.handle, c.sim_jointfloatparam_velocity)
        )

    @property
    def force(self) -> float:
        """Return the motor's force in N or torque in N m, mean over the last simulation step; 0 while stopped.

        The sign is V-REP's, as in `simxGetJointForce`: negative while the motor pushes towards greater positions.
        """
        return self._request(lambda calls: calls.simxGetJointForce(self.handle))

    @property
    def max_force(self) -> float:
        """Return the motor's maximum force in N or torque in N m."""
        return self._request(lambda calls: calls.simxGetJointMaxForce(self.handle))

    @max_force.setter
    def max_force(self, force: SupportsFloat) -> None:
        self._send(lambda calls: calls.simxSetJointMaxForce(self.handle, force))

    @property
    def target_position(self) -> NoReturn:
        """Set the motor's target position in rad or m, for position control. Write only."""
        raise AttributeError(_TARGETS)

    @target_position.setter
    def target_position(self, position: SupportsFloat) -> None:
        self._send(lambda calls: calls.simxSetJointTargetPosition(self.handle, position))

    @property
    def target_velocity(self) -> NoReturn:
        """Set the motor's target velocity in rad/s or m/s, for velocity control. Write only."""
        raise AttributeError(_TARGETS)

    @target_velocity.setter
    def target_velocity(self, velocity: SupportsFloat) -> None:
        self._send(lambda calls: calls.simxSetJointTargetVelocity(self.handle, velocity))


class Joints(Strict, Sequence[Joint]):
    """Several joints. Each property is one message and an array, in the order of the names."""

    __slots__ = ("_channel", "_joints")

    def __init__(self, channel: Channel, joints: Sequence[Joint]) -> None:
        self._channel = channel
        self._joints = tuple(joints)

    def __len__(self) -> int:
        return len(self._joints)

    @overload
    def __getitem__(self, index: int) -> Joint: ...
    @overload
    def __getitem__(self, index: slice) -> Joints: ...
    def __getitem__(self, index: int | slice) -> Joint | Joints:
        if isinstance(index, slice):
            return Joints(self._channel, self._joints[index])
        return self._joints[index]

    def __iter__(self) -> Iterator[Joint]:
        return iter(self._joints)

    def __repr__(self) -> str:
        return f"<Joints {', '.join(joint.label for joint in self)}, {self._channel.state}>"

    @property
    def positions(self) -> Array:
        """Return all joint positions of one instant, float64, one per joint. Setting them moves the joints at
        once."""
        return self._read(lambda calls, joint: calls.simxGetJointPosition(joint.handle))

    @positions.setter
    def positions(self, positions: Numbers) -> None:
        self._write(positions, lambda calls, joint, value: calls.simxSetJointPosition(joint.handle, value))

    @property
    def velocities(self) -> Array:
        """Return all joint velocities of one instant in rad/s or m/s."""
        return self._read(
            lambda calls, joint: calls.simxGetObjectFloatParameter(
                joint.handle, c.sim_jointfloatparam_velocity
            )
        )

    @property
    def forces(self) -> Array:
        """Return the motors' forces in N or torques in N m, with the sign of `Joint.force`."""
        return self._read(lambda calls, joint: calls.simxGetJointForce(joint.handle))

    @property
    def target_positions(self) -> NoReturn:
        """Set the motors' target positions in rad or m. Write only."""
        raise AttributeError(_TARGETS)

    @target_positions.setter
    def target_positions(self, positions: Numbers) -> None:
        self._write(
            positions, lambda calls, joint, value: calls.simxSetJointTargetPosition(joint.handle, value)
        )

    @property
    def target_velocities(self) -> NoReturn:
        """Set the motors' target velocities in rad/s or m/s. Write only."""
        raise AttributeError(_TARGETS)

    @target_velocities.setter
    def target_velocities(self, velocities: Numbers) -> None:
        self._write(
            velocities, lambda calls, joint, value: calls.simxSetJointTargetVelocity(joint.handle, value)
        )

    def _read(self, note: Callable[[Calls, Joint], Answer[float]]) -> NDArray[np.float64]:
        import numpy as np

        answers = self._channel.gather(lambda calls: [note(calls, joint) for joint in self], *self)
        return np.array([answer.value for answer in answers], dtype=np.float64)

    def _write(self, values: Numbers, note: Callable[[Calls, Joint, float], object]) -> None:
        numbers = [float(value) for value in values]
        if len(numbers) != len(self):
            raise ValueError(f"{len(self)} joints need as many numbers, got {len(numbers)}")
        self._channel.send(
            lambda calls: [note(calls, joint, value) for joint, value in zip(self, numbers, strict=True)],
            *self,
        )
