"""The one table of API 2: the properties of each class, by name."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from types import MappingProxyType
from typing import TYPE_CHECKING

from simx_server.sim_api.object_model.classes import super_classes
from simx_server.sim_api.properties import property_types as t
from simx_server.sim_api.properties.entry import Property

from .app import APP
from .custom import CONSOLE, CUSTOM_OBJECT, TEXT_EDITOR
from .instances import IK, IK_ELEMENT, IK_GROUP, IK_JOINT, IK_OBJECT
from .joints import JOINT
from .making import by_name, constant
from .others import COLLECTION, DUMMY, GRAPH, LIGHT, MARKER, OC_TREE, POINT_CLOUD, SCRIPT
from .scene import SCENE
from .scene_objects import SCENE_OBJECT
from .sensors import CAMERA, FORCE_SENSOR, PROXIMITY_SENSOR, VISION_SENSOR
from .shapes import SHAPE

if TYPE_CHECKING:
    from simx_server.world.world import World

_OF_CLASS: Mapping[str, tuple[Property, ...]] = MappingProxyType(
    {
        "app": APP,
        "scene": SCENE,
        "sceneObject": SCENE_OBJECT,
        "shape": SHAPE,
        "joint": JOINT,
        "dummy": DUMMY,
        "light": LIGHT,
        "script": SCRIPT,
        "graph": GRAPH,
        "ocTree": OC_TREE,
        "pointCloud": POINT_CLOUD,
        "proximitySensor": PROXIMITY_SENSOR,
        "visionSensor": VISION_SENSOR,
        "camera": CAMERA,
        "forceSensor": FORCE_SENSOR,
        "collection": COLLECTION,
        "marker": MARKER,
        "IK": IK,
        "IKGroup": IK_GROUP,
        "IKElement": IK_ELEMENT,
        "IKObject": IK_OBJECT,
        "IKJoint": IK_JOINT,
        "customObject": CUSTOM_OBJECT,
        "console": CONSOLE,
        "textEditor": TEXT_EDITOR,
    }
)

_GROUPS = {"app": ["customData", "signal", "namedParam"], "scene": ["customData", "signal"]}


_WITHOUT_GROUPS = frozenset(
    (
        *("Path", "IK", "IKGroup", "IKElement", "IKObject", "IKJoint"),
        *("customObject", "console", "textEditor"),
    )
)


def namespaces(name: str) -> list[str]:
    """Return the groups of a class to which programs add properties."""
    if name in _WITHOUT_GROUPS:
        return []
    more = ["refs"] if "sceneObject" in super_classes(name) else []
    return _GROUPS.get(name, ["customData", "signal", *more])


def _of_object(name: str) -> tuple[Property, ...]:
    """Return the properties that every object has."""
    above = super_classes(name)

    def class_name(world: World, handle: int) -> str:
        instance = world.instances.find(handle)
        return name if instance is None else instance.type

    return (
        Property("handle", t.LONG, lambda _world, handle: handle),
        Property("type", t.STRING, class_name),
        Property("objectType", t.STRING, class_name),  # that clients know an object's properties by
        constant("metaInfo.isClass", t.BOOL, False),
        constant("metaInfo.isSceneObject", t.BOOL, "sceneObject" in above),
        constant("metaInfo.namespaces", t.STRING_ARRAY, namespaces(name)),
        constant("metaInfo.superClass", t.STRING_ARRAY, above),
    )


@cache
def of_class(name: str) -> Mapping[str, Property]:
    """Return the properties of a class with those of the classes above it: its own first."""
    above = (_OF_CLASS.get(each, ()) for each in reversed(super_classes(name)))
    own = _OF_CLASS.get(name, ())
    return MappingProxyType(by_name([*own, *(each for group in above for each in group), *_of_object(name)]))


def with_object(name: str, properties: tuple[Property, ...]) -> Mapping[str, Property]:
    """Return properties with those that every object has."""
    return MappingProxyType(by_name([*properties, *_of_object(name)]))


@cache
def groups_of(name: str) -> frozenset[str]:
    """Return the starts of the names of a class's properties, such as `simulation` and `dynamics.mujoco`."""
    found: set[str] = set(namespaces(name))
    for full in of_class(name):
        parts = full.split(".")
        found |= {".".join(parts[:length]) for length in range(1, len(parts))}
    return frozenset(found)
