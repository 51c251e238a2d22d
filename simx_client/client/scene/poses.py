"""Poses: metres, quaternions x, y, z, w, and their reference frames."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple, SupportsFloat, TypeVar

from simx_client.calls.strict import Strict, misspelt
from simx_client.client.channel import Channel, Subject
from simx_client.connection.calls import Calls

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]
    Numbers = Sequence[SupportsFloat] | NDArray[np.floating | np.integer]
    """Types accepted for a vector."""

T = TypeVar("T")

_WORLD = -1


class Pose(NamedTuple):
    """Position and orientation of an object."""

    position: Array
    """x, y, z in metres."""

    quaternion: Array
    """x, y, z, w, of unit length."""

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> object:
            raise misspelt(self, name)

    @property
    def matrix(self) -> Array:
        """Return the 4×4 matrix that transforms points of the object's frame to the pose's reference frame."""
        import numpy as np

        x, y, z, w = self.quaternion
        matrix = np.eye(4)
        matrix[:3, :3] = [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
        matrix[:3, 3] = self.position
        return matrix


class Place(Strict):
    """Pose of one object in the frame of another. Each property is one message, and can be set."""

    __slots__ = ("_channel", "_handles", "_subjects")

    def __init__(self, channel: Channel, placed: Subject, frame: Subject | None) -> None:
        self._channel = channel
        self._subjects = (placed,) if frame is None else (placed, frame)
        self._handles = placed.handle, handle_of(frame)

    def __repr__(self) -> str:
        placed, *frame = map(str, self._subjects)
        return f"<Place of {placed} in {f'the frame of {frame[0]}' if frame else 'the world'}>"

    def _gather(self, note: Callable[[Calls], T]) -> T:
        return self._channel.gather(note, *self._subjects)

    def _send(self, note: Callable[[Calls], object]) -> None:
        self._channel.send(note, *self._subjects)

    @property
    def position(self) -> Array:
        """Return the position: x, y, z in metres."""
        return as_array(self._gather(lambda calls: calls.simxGetObjectPosition(*self._handles)).value)

    @position.setter
    def position(self, position: Numbers) -> None:
        self._send(lambda calls: calls.simxSetObjectPosition(*self._handles, _exactly(3, position)))

    @property
    def quaternion(self) -> Array:
        """Return the orientation: unit quaternion x, y, z, w."""
        return as_array(self._gather(lambda calls: calls.simxGetObjectQuaternion(*self._handles)).value)

    @quaternion.setter
    def quaternion(self, quaternion: Numbers) -> None:
        self._send(lambda calls: calls.simxSetObjectQuaternion(*self._handles, _exactly(4, quaternion)))

    @property
    def euler_angles(self) -> Array:
        """Return V-REP's Euler angles alpha, beta, gamma in radians: R = Rx(alpha) Ry(beta) Rz(gamma)."""
        return as_array(self._gather(lambda calls: calls.simxGetObjectOrientation(*self._handles)).value)

    @euler_angles.setter
    def euler_angles(self, angles: Numbers) -> None:
        self._send(lambda calls: calls.simxSetObjectOrientation(*self._handles, _exactly(3, angles)))

    @property
    def pose(self) -> Pose:
        """Return position and quaternion of one instant."""
        position, quaternion = self._gather(
            lambda calls: (
                calls.simxGetObjectPosition(*self._handles),
                calls.simxGetObjectQuaternion(*self._handles),
            )
        )
        return Pose(as_array(position.value), as_array(quaternion.value))

    @pose.setter
    def pose(self, pose: tuple[Numbers, Numbers]) -> None:
        position, quaternion = _exactly(3, pose[0]), _exactly(4, pose[1])
        self._send(
            lambda calls: (
                calls.simxSetObjectQuaternion(*self._handles, quaternion),
                calls.simxSetObjectPosition(*self._handles, position),
            )
        )


def handle_of(frame: Subject | None) -> int:
    """Return the handle that calls take for a frame; -1 for the world."""
    return _WORLD if frame is None else frame.handle


def as_array(numbers: Sequence[float]) -> Array:
    """Return a vector of a legacy call as a float64 array."""
    import numpy as np

    return np.array(numbers, dtype=np.float64)


def _exactly(count: int, numbers: Numbers) -> list[float]:
    """Return the numbers as floats; raise ValueError for another count. The legacy functions would fill up
    with zeros."""
    values = [float(number) for number in numbers]
    if len(values) != count:
        raise ValueError(f"needs {count} numbers, got {len(values)}")
    return values
