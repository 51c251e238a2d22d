"""The classes of API 2, and the class of an object.

Handles of collections and of drawing objects are counted from elsewhere, since API 1's overlap with others.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING

from simx_server.errors import CommandError
from simx_server.parts.custom_data import APPLICATION, SCENE
from simx_server.parts.instances import FIRST_HANDLE as FIRST_INSTANCE
from simx_server.sim_api.properties.tables.objects import kind_word

if TYPE_CHECKING:
    from simx_server.scripting.script import Script
    from simx_server.world.world import World

SELF = -4
"""Stands for the script that calls."""

FIRST_COLLECTION, FIRST_MARKER = 10_000_000, 100_000_000
"""Summands of the handles of API 1: of a collection, of a drawing object, which is a marker here. Between them are
handles of `parts/instances.py`.
"""

SCENE_OBJECTS = (
    *(
        "shape",
        "joint",
        "graph",
        "camera",
        "dummy",
        "proximitySensor",
        "visionSensor",
        "forceSensor",
        "light",
    ),
    *("ocTree", "pointCloud", "script", "path", "mill", "mirror"),
)
"""Classes of scene objects; the last three are V-REP's."""

_ABOVE: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        **dict.fromkeys(SCENE_OBJECTS, ("object", "sceneObject")),
        **dict.fromkeys(("app", "scene", "collection", "detachedScript", "marker"), ("object",)),
        **dict.fromkeys(("Path", "IK", "IKGroup", "IKElement", "IKObject", "customObject"), ("object",)),
        "IKJoint": ("object", "IKObject"),
        **dict.fromkeys(("console", "textEditor"), ("object", "customObject")),
    }
)
"""The classes above each, the root first."""


def classes_of(name: str) -> tuple[str, ...]:
    """Return a class with those above it, the class itself first."""
    return (name, *reversed(_ABOVE[name]))


def is_class(name: str) -> bool:
    """Return whether a name is that of a class of the server."""
    return name in _ABOVE or name in ("object", "sceneObject", "mesh", "drawingObject")


def super_classes(name: str) -> list[str]:
    """Return the classes above one, the root first."""
    return list(_ABOVE[name])


def script_at(world: World, handle: int, caller: Script) -> Script | None:
    """Return the script with a handle, also the caller, which may be a client; None: there is none."""
    if handle in (SELF, caller.handle):
        return caller
    if handle == world.scripts.sandbox.handle:
        return world.scripts.sandbox
    return world.scripts.get(handle)


def class_of(world: World, handle: int, caller: Script) -> str:
    """Return the class of an object. Raises CommandError: no object has this handle."""
    if handle == SCENE:
        return "scene"
    if handle == APPLICATION:
        return "app"
    item = world.simulation.scene.objects.get(handle)
    if item is not None:
        return kind_word(item.kind)
    if handle >= FIRST_MARKER:
        if handle - FIRST_MARKER in world.drawings:
            return "marker"
    elif handle >= FIRST_INSTANCE:
        instance = world.instances.find(handle)
        if instance is not None:
            return instance.kind
    elif handle >= FIRST_COLLECTION:
        if handle - FIRST_COLLECTION in world.collections:
            return "collection"
    elif script_at(world, handle, caller) is not None:
        return "detachedScript"
    raise CommandError(f"target does not exist: no object has the handle {handle}")


def to_api_1(handle: int) -> int:
    """Return the handle that the functions of API 1 know an object by."""
    if handle >= FIRST_MARKER:
        return handle - FIRST_MARKER
    if handle >= FIRST_INSTANCE:
        return handle
    return handle - FIRST_COLLECTION if handle >= FIRST_COLLECTION else handle
