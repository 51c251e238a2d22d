"""The objects of the loaded scene by name. Each is looked up once and gets the class of its kind."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TypeVar, cast

from simx_client.calls.strict import Strict
from simx_client.client.channel import Channel, Generation
from simx_client.connection.calls import Calls
from simx_client.errors import NoSuchObject, WrongKind
from simx_client.protocol import constants as c

from .camera import Camera
from .joints import Joint
from .listing import Objects
from .objects import KINDS, Dummy, Object, SceneObject, Shape
from .sensors import ForceSensor, ProximitySensor

S = TypeVar("S", bound=SceneObject)

CLASSES: Mapping[int | None, type[SceneObject]] = MappingProxyType(
    {each.object_type: each for each in (Shape, Joint, Camera, Dummy, ProximitySensor, ForceSensor)}
)
"""Class by V-REP's object type; other types are an ``Object``."""

_EVERY = c.sim_appobj_object_type
_NAMES, _TYPES = 0, 1
"""Data types of simxGetObjectGroupData."""


class Scene(Strict):
    """Objects by name. A known object is found without a message, until it or its scene was removed."""

    __slots__ = ("_found", "_generation", "channel")

    def __init__(self, channel: Channel) -> None:
        self.channel = channel
        self._found: dict[tuple[type[SceneObject], str], SceneObject] = {}
        self._generation: Generation = channel.generation

    def find(self, kind: type[S], name: str) -> S:
        """Return the object with this name or path.

        Raises:
            NoSuchObject: no object has this name.
            WrongKind: the object is of another kind.
        """
        self._forget_other_scenes()
        found = self._found.get((kind, name))
        if found is None:
            found = self._found[kind, name] = self._look_up(kind, name)
            self._generation = self.channel.generation
        return cast(S, found)

    def every(self, kind: type[S]) -> Objects[S]:
        """Return all objects of a class and its subclasses; one message."""
        listing = self.listing()
        self._forget_other_scenes()
        objects = [self._listed(*each) for each in listing]
        self._generation = self.channel.generation
        return Objects([each for each in objects if isinstance(each, kind)], self.channel.where)

    def _listed(self, handle: int, name: str, object_type: int) -> SceneObject:
        kind = CLASSES.get(object_type, Object)
        found = self._found.get((kind, name))
        if found is None or found.handle != handle:
            found = self._found[kind, name] = kind(self, handle, name, object_type)
        return found

    def _forget_other_scenes(self) -> None:
        if self._generation != self.channel.generation:
            self._found.clear()

    def forget(self, gone: SceneObject) -> None:
        """Forget an object: another one may get its name."""
        self._found = {key: found for key, found in self._found.items() if found.handle != gone.handle}

    def _look_up(self, kind: type[S], name: str) -> S:
        def note(calls: Calls):
            return calls.simxGetObjectHandle(name), calls.simxGetObjectGroupData(_EVERY, _TYPES)

        handle, typed = self.channel.try_all(note)
        if handle.code:
            raise NoSuchObject([handle.failure])
        handles, types, _, _ = typed.value
        object_type = dict(zip(handles, types, strict=True))[handle.value]
        if kind.object_type not in (None, object_type):
            raise WrongKind(
                f"{name!r} is a {KINDS.get(object_type, 'something else')}, not a {KINDS[kind.object_type]}; "
                f"client.object({name!r}) takes every kind"
            )
        return kind(self, handle.value, name, object_type)

    def names(self) -> dict[int, str]:
        """Return the names of all objects by handle."""
        return {handle: name for handle, name, _ in self.listing()}

    def listing(self) -> list[tuple[int, str, int]]:
        """Return handle, name and sim_object_..._type of all objects, in the scene's order; one message."""
        named, typed = self.channel.gather(
            lambda calls: (
                calls.simxGetObjectGroupData(_EVERY, _NAMES),
                calls.simxGetObjectGroupData(_EVERY, _TYPES),
            )
        )
        handles, _, _, names = named.value
        _, types, _, _ = typed.value
        return list(zip(handles, names, types, strict=True))
