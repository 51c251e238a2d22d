"""The one table: the properties of each kind of target, by name."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache
from types import MappingProxyType

from simx_server.parts.custom_data import APPLICATION, SCENE
from simx_server.scene.objects import ObjectKind

from .entry import Property
from .tables.clouds import OCTREES, POINT_CLOUDS
from .tables.joints import JOINTS
from .tables.objects import OBJECTS
from .tables.others import DUMMIES, LIGHTS, SCRIPTS
from .tables.places import PLACES
from .tables.scene import OF_APP, OF_SCENE
from .tables.sensors import FORCE, PROXIMITY
from .tables.shapes import SHAPES
from .tables.vision import CAMERAS, VISION

_COMMON = (*OBJECTS, *PLACES)

_BY_KIND: Mapping[ObjectKind, tuple[Property, ...]] = MappingProxyType(
    {
        ObjectKind.SHAPE: SHAPES,
        ObjectKind.JOINT: JOINTS,
        ObjectKind.DUMMY: DUMMIES,
        ObjectKind.PROXIMITY_SENSOR: PROXIMITY,
        ObjectKind.FORCE_SENSOR: FORCE,
        ObjectKind.VISION_SENSOR: VISION,
        ObjectKind.CAMERA: CAMERAS,
        ObjectKind.LIGHT: LIGHTS,
        ObjectKind.SCRIPT: SCRIPTS,
        ObjectKind.POINT_CLOUD: POINT_CLOUDS,
        ObjectKind.OCTREE: OCTREES,
    }
)


@cache
def of_kind(kind: ObjectKind) -> Mapping[str, Property]:
    """Return the properties of a kind of object: those of the kind first."""
    return _by_name((*_BY_KIND.get(kind, ()), *_COMMON))


@cache
def of_target(target: int) -> Mapping[str, Property]:
    """Return the properties of `sim_handle_scene` or `sim_handle_app`."""
    return _by_name({SCENE: OF_SCENE, APPLICATION: OF_APP}[target])


def is_common(name: str) -> bool:
    """Return whether all kinds of objects have a property."""
    return any(each.name == name for each in _COMMON)


def kinds_with(name: str) -> list[str]:
    """Return the targets that have a property, in words."""
    kinds = [f"a {kind.text}" for kind in ObjectKind if name in of_kind(kind)]
    return [
        *(["the scene (sim.handle_scene)"] if name in of_target(SCENE) else []),
        *(["the server (sim.handle_app)"] if name in of_target(APPLICATION) else []),
        *kinds,
    ]


def by_target() -> dict[str, tuple[Property, ...]]:
    """Return the properties by what has them, in words; those of a kind of object without the common ones."""
    return {
        "every object": _COMMON,
        **{kind.text: found for kind, found in _BY_KIND.items()},
        "the scene": OF_SCENE,
        "the server": OF_APP,
    }


def _by_name(properties: Iterable[Property]) -> Mapping[str, Property]:
    found: dict[str, Property] = {}
    for each in properties:
        found.setdefault(each.name, each)
    return MappingProxyType(found)
