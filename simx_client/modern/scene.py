"""The objects of the loaded scene by name: each is looked up once, as what it is."""

from __future__ import annotations

from typing import TypeVar, cast

from ..calls import Calls
from ..errors import NoSuchObject, WrongKind
from ..protocol import constants as c
from .channel import Channel, Generation
from .objects import KINDS, SceneObject

S = TypeVar("S", bound=SceneObject)

_NAMES, _TYPES = 0, 1
"""Data types of simxGetObjectGroupData."""


class Scene:
    """Names to objects. An object is found again without a message, until it or its scene has gone."""

    def __init__(self, channel: Channel) -> None:
        self.channel = channel
        self._found: dict[tuple[type[SceneObject], str], SceneObject] = {}
        self._generation: Generation = channel.generation

    def find(self, kind: type[S], name: str) -> S:
        """The object with this name or path.

        Raises:
            NoSuchObject: there is none. WrongKind: it is something else.
        """
        if self._generation != self.channel.generation:
            self._found.clear()
        found = self._found.get((kind, name))
        if found is None:
            found = self._found[kind, name] = self._look_up(kind, name)
            self._generation = self.channel.generation
        return cast(S, found)

    def forget(self, gone: SceneObject) -> None:
        """Its name may be another's from now on."""
        self._found = {key: found for key, found in self._found.items() if found.handle != gone.handle}

    def _look_up(self, kind: type[S], name: str) -> S:
        wanted = kind.object_type

        def note(calls: Calls):
            every = calls.simxGetObjects(c.sim_handle_all if wanted is None else wanted)
            return calls.simxGetObjectHandle(name), every

        handle, of_kind = self.channel.try_all(note)
        if handle.code:
            raise NoSuchObject([handle.failure])
        if handle.value not in of_kind.value:
            actual = self.kinds().get(handle.value, "something else")
            raise WrongKind(
                f"{name!r} is a {actual}, not a {kind.kind}; client.object({name!r}) takes every kind"
            )
        return kind(self, handle.value, name)

    def names(self) -> dict[int, str]:
        """Of all objects, by handle."""
        return {handle: name for handle, name, _ in self.listing()}

    def kinds(self) -> dict[int, str]:
        """Of all objects, by handle."""
        return {handle: kind for handle, _, kind in self.listing()}

    def listing(self) -> list[tuple[int, str, str]]:
        """Handle, name and kind of all objects, in the scene's order; one message."""
        named, typed = self.channel.gather(
            lambda calls: (
                calls.simxGetObjectGroupData(c.sim_appobj_object_type, _NAMES),
                calls.simxGetObjectGroupData(c.sim_appobj_object_type, _TYPES),
            )
        )
        handles, _, _, names = named.value
        _, types, _, _ = typed.value
        return [
            (handle, name, KINDS.get(each, "object"))
            for handle, name, each in zip(handles, names, types, strict=True)
        ]
