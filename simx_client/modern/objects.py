"""Objects of the scene: where they are, how they move, whose children they are. SI units, radians, xyzw."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar, NamedTuple, SupportsFloat, TypeVar

from ..answers import Answer
from ..calls import Calls
from ..protocol import constants as c

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from .channel import Channel
    from .scene import Scene

    Array = NDArray[np.float64]
    Numbers = Sequence[SupportsFloat] | NDArray[np.floating | np.integer]
    """What a vector may be given as."""

T = TypeVar("T")

KINDS: Mapping[int, str] = MappingProxyType(
    {
        c.sim_object_shape_type: "shape",
        c.sim_object_joint_type: "joint",
        c.sim_object_camera_type: "view of the user interface",
        c.sim_object_dummy_type: "dummy",
        c.sim_object_proximitysensor_type: "proximity sensor",
        c.sim_object_visionsensor_type: "camera",
        c.sim_object_forcesensor_type: "force sensor",
        c.sim_object_light_type: "light",
    }
)
"""Kinds of objects in the words of this face: what V-REP calls a vision sensor is a camera."""

_WORLD = -1
_PHYSICAL = 0x400000
"""Added to a handle: the physical angular velocity instead of Euler rates."""


class Pose(NamedTuple):
    """Where something is and how it is turned."""

    position: Array
    """x, y, z in metres."""

    quaternion: Array
    """x, y, z, w, of unit length."""

    @property
    def matrix(self) -> Array:
        """4×4: takes points of the object's frame to the frame that the pose was given in."""
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


class SceneObject:
    """What all kinds of objects have. Made by ``Client``, looked up once; equal names give the same one."""

    object_type: ClassVar[int | None] = None
    """Its sim_object_..._type; None: any."""

    kind: ClassVar[str] = "object"

    def __init__(self, scene: Scene, handle: int, name: str | None = None) -> None:
        self._scene = scene
        self._name = name
        self.handle = handle
        """What the legacy functions know it by."""

        self.generation = scene.channel.generation

    def __repr__(self) -> str:
        return f"<{self}, handle {self.handle}>"

    def __str__(self) -> str:
        return f"{self.kind} {self._name!r}" if self._name else f"{self.kind} {self.handle}"

    def _gather(self, note: Callable[[Calls], T]) -> T:
        return self._scene.channel.gather(note, self)

    def _ask(self, note: Callable[[Calls], Answer[T]]) -> T:
        return self._scene.channel.ask(note, self)

    def _tell(self, note: Callable[[Calls], object]) -> None:
        self._scene.channel.tell(note, self)

    def forget(self) -> None:
        """Look its name up anew the next time."""
        self._scene.forget(self)

    @property
    def name(self) -> str:
        """As it was looked up, or as the scene has it."""
        if self._name is None:
            self._name = self._scene.names().get(self.handle, "")
        return self._name

    @property
    def parent(self) -> Object | None:
        """What it is attached to; None for the world. Set it to attach it where it is, keeping its place."""
        handle = self._ask(lambda calls: calls.simxGetObjectParent(self.handle))
        return None if handle == -1 else Object(self._scene, handle)

    @parent.setter
    def parent(self, parent: SceneObject | None) -> None:
        self._tell(lambda calls: calls.simxSetObjectParent(self.handle, _frame(parent), True))

    def relative_to(self, other: SceneObject | None) -> Place:
        """Where it is as seen from another object's frame, or from the world (None); can be set, too."""
        return Place(self._scene.channel, self, other)

    @property
    def pose(self) -> Pose:
        """Position and quaternion in the world, of one instant. Setting it places the object."""
        return self.relative_to(None).pose

    @pose.setter
    def pose(self, pose: tuple[Numbers, Numbers]) -> None:
        self.relative_to(None).pose = pose

    def remove(self) -> None:
        """Take it out of the scene; its children move up to its parent. What a run removed is back after the stop."""
        self._tell(lambda calls: calls.simxRemoveObject(self.handle))
        self.forget()


class Place:
    """Where one object is, in the frame of another. Each property is one message, and can be set."""

    def __init__(self, channel: Channel, placed: SceneObject, frame: SceneObject | None) -> None:
        self._channel = channel
        self._subjects = (placed,) if frame is None else (placed, frame)
        self._handles = placed.handle, _frame(frame)

    def _gather(self, note: Callable[[Calls], T]) -> T:
        return self._channel.gather(note, *self._subjects)

    def _tell(self, note: Callable[[Calls], object]) -> None:
        self._channel.tell(note, *self._subjects)

    @property
    def position(self) -> Array:
        """x, y, z in metres."""
        return as_array(self._gather(lambda calls: calls.simxGetObjectPosition(*self._handles)).value)

    @position.setter
    def position(self, position: Numbers) -> None:
        self._tell(lambda calls: calls.simxSetObjectPosition(*self._handles, _exactly(3, position)))

    @property
    def quaternion(self) -> Array:
        """x, y, z, w, of unit length."""
        return as_array(self._gather(lambda calls: calls.simxGetObjectQuaternion(*self._handles)).value)

    @quaternion.setter
    def quaternion(self, quaternion: Numbers) -> None:
        self._tell(lambda calls: calls.simxSetObjectQuaternion(*self._handles, _exactly(4, quaternion)))

    @property
    def euler_angles(self) -> Array:
        """alpha, beta, gamma in radians, as V-REP counts them: R = Rx(alpha) Ry(beta) Rz(gamma)."""
        return as_array(self._gather(lambda calls: calls.simxGetObjectOrientation(*self._handles)).value)

    @euler_angles.setter
    def euler_angles(self, angles: Numbers) -> None:
        self._tell(lambda calls: calls.simxSetObjectOrientation(*self._handles, _exactly(3, angles)))

    @property
    def pose(self) -> Pose:
        """Position and quaternion of one instant."""
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
        self._tell(
            lambda calls: (
                calls.simxSetObjectQuaternion(*self._handles, quaternion),
                calls.simxSetObjectPosition(*self._handles, position),
            )
        )


class Object(SceneObject):
    """An object of any kind, as a thing that has a place in the world and a velocity."""

    @property
    def position(self) -> Array:
        """x, y, z in the world, metres."""
        return self.relative_to(None).position

    @position.setter
    def position(self, position: Numbers) -> None:
        self.relative_to(None).position = position

    @property
    def quaternion(self) -> Array:
        """x, y, z, w in the world."""
        return self.relative_to(None).quaternion

    @quaternion.setter
    def quaternion(self, quaternion: Numbers) -> None:
        self.relative_to(None).quaternion = quaternion

    @property
    def velocity(self) -> Array:
        """Linear velocity in world axes, m/s, measured over the last pass."""
        return as_array(self._ask(lambda calls: calls.simxGetObjectVelocity(self.handle))[0])

    @property
    def angular_velocity(self) -> Array:
        """In world axes, rad/s, measured over the last pass."""
        return as_array(self._ask(lambda calls: calls.simxGetObjectVelocity(self.handle | _PHYSICAL))[1])


class Dummy(Object):
    """A point with a frame."""

    object_type = c.sim_object_dummy_type
    kind = "dummy"


def _frame(frame: SceneObject | None) -> int:
    return _WORLD if frame is None else frame.handle


def as_array(numbers: Sequence[float]) -> Array:
    """A vector of a legacy call."""
    import numpy as np

    return np.array(numbers, dtype=np.float64)


def _exactly(count: int, numbers: Numbers) -> list[float]:
    """The legacy functions would fill a short vector with zeros."""
    values = [float(number) for number in numbers]
    if len(values) != count:
        raise ValueError(f"needs {count} numbers, got {len(values)}")
    return values
