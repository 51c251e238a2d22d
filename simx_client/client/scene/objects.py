"""Objects of the scene: poses, velocities, parents. SI units, radians, quaternions x, y, z, w."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar, Protocol, TypeVar

from simx_client.calls.answers import Answer
from simx_client.calls.strict import Strict
from simx_client.connection.calls import Calls
from simx_client.protocol import constants as c

from .poses import Place, Pose, as_array, handle_of

if TYPE_CHECKING:
    from simx_client.client.channel import Channel

    from .poses import Array, Numbers

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
"""Names of the kinds of objects in this package: V-REP's vision sensor is a camera."""

_PHYSICAL = 0x400000
"""Added to a handle: return the physical angular velocity instead of Euler rates."""


class SceneOfObjects(Protocol):
    """The part of the scene that its objects use; see `scene.Scene`."""

    @property
    def channel(self) -> Channel: ...
    def names(self) -> dict[int, str]: ...
    def forget(self, gone: SceneObject) -> None: ...


class SceneObject(Strict):
    """Base of all kinds of objects. ``Client`` makes them and looks each up once; equal names return the same
    object."""

    __slots__ = ("__weakref__", "_name", "_scene", "_type", "generation", "handle")

    object_type: ClassVar[int | None] = None
    """The sim_object_..._type of this class; None: any."""

    def __init__(
        self, scene: SceneOfObjects, handle: int, name: str | None = None, object_type: int | None = None
    ) -> None:
        self._scene = scene
        self._name = name
        self._type = self.object_type if object_type is None else object_type
        self.handle = handle
        """Handle for the legacy functions."""

        self.generation = scene.channel.generation

    def __repr__(self) -> str:
        """Return the state that is known without a request."""
        own = self._type == self.object_type
        replaced = (
            "" if self.generation == self._scene.channel.generation else ", of a scene that was replaced"
        )
        return (
            f"<{type(self).__name__} {self.label}{'' if own else f' ({self.kind})'}, handle {self.handle}, "
            f"{self._scene.channel.state}{replaced}>"
        )

    def __str__(self) -> str:
        return f"{self.kind} {self.label}"

    def _hint(self, name: str) -> str:
        """Return which class has an attribute of this name: the one for this kind of object, or another kind."""
        others = [each for each in kinds_of(SceneObject) if hasattr(each, name) and not name.startswith("_")]
        if any(each.object_type == self._type for each in others):
            return f"client.{self.kind.replace(' ', '_')}({self.label}) has it"
        if Object in others:
            return f"client.object({self.label}) has it"
        kinds = [KINDS[each.object_type] for each in others if each.object_type is not None]
        return f"{' and '.join(f'a {kind}' for kind in kinds)} has it; {self} is not one" if kinds else ""

    @property
    def kind(self) -> str:
        """Return the kind: "joint", "shape", "camera", …; "object" if only the handle is known."""
        return "object" if self._type is None else KINDS.get(self._type, "object")

    @property
    def label(self) -> str:
        """Return the name in quotes if it is known without a request, else the handle."""
        return repr(self._name) if self._name else str(self.handle)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, SceneObject) and self._identity == other._identity

    def __hash__(self) -> int:
        return hash(self._identity)

    @property
    def _identity(self) -> tuple[object, ...]:
        return id(self._scene), self.generation, self.handle

    def _gather(self, note: Callable[[Calls], T]) -> T:
        return self._scene.channel.gather(note, self)

    def _request(self, note: Callable[[Calls], Answer[T]]) -> T:
        return self._scene.channel.request(note, self)

    def _send(self, note: Callable[[Calls], object]) -> None:
        self._scene.channel.send(note, self)

    def forget(self) -> None:
        """Look the name up again the next time."""
        self._scene.forget(self)

    @property
    def name(self) -> str:
        """Return the name, as it was looked up or as the scene has it."""
        if self._name is None:
            self._name = self._scene.names().get(self.handle, "")
        return self._name

    @property
    def parent(self) -> Object | None:
        """Return the parent, None for the world. Setting it attaches the object; its pose in the world stays."""
        parent, _ = self._gather(
            lambda calls: (
                calls.simxGetObjectParent(self.handle),
                calls.simxGetObjectPosition(
                    self.handle, -1
                ),  # raises for a removed object, for which the first call returns -1
            )
        )
        return None if parent.value == -1 else Object(self._scene, parent.value)

    @parent.setter
    def parent(self, parent: SceneObject | None) -> None:
        self._send(lambda calls: calls.simxSetObjectParent(self.handle, handle_of(parent), True))

    def relative_to(self, other: SceneObject | None) -> Place:
        """Return the pose of the object in the frame of another object, or of the world (None); it can also
        be set."""
        return Place(self._scene.channel, self, other)

    @property
    def pose(self) -> Pose:
        """Return position and quaternion in the world, of one instant. Setting it moves the object."""
        return self.relative_to(None).pose

    @pose.setter
    def pose(self, pose: tuple[Numbers, Numbers]) -> None:
        self.relative_to(None).pose = pose

    def remove(self) -> None:
        """Remove the object from the scene; its children get its parent. A stop restores objects that the run
        removed."""
        self._send(lambda calls: calls.simxRemoveObject(self.handle))
        self.forget()


class Object(SceneObject):
    """An object of any kind, with a pose in the world and a velocity."""

    __slots__ = ()

    @property
    def position(self) -> Array:
        """Return the position in the world: x, y, z in metres."""
        return self.relative_to(None).position

    @position.setter
    def position(self, position: Numbers) -> None:
        self.relative_to(None).position = position

    @property
    def quaternion(self) -> Array:
        """Return the orientation in the world: quaternion x, y, z, w."""
        return self.relative_to(None).quaternion

    @quaternion.setter
    def quaternion(self, quaternion: Numbers) -> None:
        self.relative_to(None).quaternion = quaternion

    @property
    def velocity(self) -> Array:
        """Return the linear velocity in m/s along world axes, measured over the last simulation step."""
        return as_array(self._request(lambda calls: calls.simxGetObjectVelocity(self.handle))[0])

    @property
    def angular_velocity(self) -> Array:
        """Return the angular velocity in rad/s along world axes, measured over the last simulation step."""
        return as_array(self._request(lambda calls: calls.simxGetObjectVelocity(self.handle | _PHYSICAL))[1])


class Shape(Object):
    """A body with a surface, and possibly a mass."""

    __slots__ = ()
    object_type = c.sim_object_shape_type


class Dummy(Object):
    """A point with a frame."""

    __slots__ = ()
    object_type = c.sim_object_dummy_type


def kinds_of(base: type[SceneObject]) -> list[type[SceneObject]]:
    """Return all classes derived from a class of objects."""
    return [each for direct in base.__subclasses__() for each in (direct, *kinds_of(direct))]
