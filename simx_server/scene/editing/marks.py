"""Sizes of the marks that V-REP draws for objects without a form: they belong to the objects' bounding boxes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import mujoco

from simx_server.scene.formats.annotations import numbers_of
from simx_server.scene.objects import ObjectKind, SceneObject

from . import renaming

if TYPE_CHECKING:
    from simx_server.scene.live import LiveScene

SIZES = {
    ObjectKind.DUMMY: 0.01,
    ObjectKind.PROXIMITY_SENSOR: 0.01,
    ObjectKind.FORCE_SENSOR: 0.05,
    ObjectKind.CAMERA: 0.05,
    ObjectKind.LIGHT: 0.1,
    ObjectKind.GRAPH: 0.1,
    ObjectKind.PATH: 0.01,
}
"""V-REP's sizes of new objects, metres."""

JOINT_LENGTH, JOINT_DIAMETER = 0.15, 0.02
SENSOR_BODY = (0.01, 0.01, 0.03)
"""Width, height and depth of a vision sensor."""

_AT_SITES = (ObjectKind.DUMMY, ObjectKind.PROXIMITY_SENSOR, ObjectKind.FORCE_SENSOR)
"""Kinds whose site has the size; paths and graphs may be sites of any size."""


def mark_size(model: mujoco.MjModel, item: SceneObject) -> float:
    """Return the size in metres of the mark of an object; its kind is one of `SIZES`."""
    if _has_site(item):
        return 2.0 * float(model.site_size[item.id, 0])
    return float(item.annotations.get("object", {}).get("mark", SIZES[item.kind]))


def set_mark_size(sim: LiveScene, item: SceneObject, size: float) -> None:
    """Set the size in metres of the mark of an object; its kind is one of `SIZES`."""
    if _has_site(item):
        sim.model.site_size[item.id] = size / 2
        sim.model_edited()
        sim.changed()
    else:
        renaming.annotate(sim, item.handle, "object", {"mark": size})


def joint_sizes(item: SceneObject) -> tuple[float, float]:
    """Return length and diameter of a joint in metres."""
    note = item.annotations.get("joint", {})
    return float(note.get("length", JOINT_LENGTH)), float(note.get("diameter", JOINT_DIAMETER))


def set_joint_sizes(sim: LiveScene, item: SceneObject, length: float, diameter: float) -> None:
    """Set length and diameter of a joint in metres, above 0."""
    renaming.annotate(sim, item.handle, "joint", {"length": length, "diameter": diameter})


def sensor_body(item: SceneObject) -> tuple[float, ...]:
    """Return width, height and depth of a vision sensor in metres."""
    note = item.annotations.get("vision", {})
    return numbers_of(note["body"]) if "body" in note else SENSOR_BODY


def scale_mark(sim: LiveScene, item: SceneObject, factor: float) -> None:
    """Multiply the sizes of an object's mark by a factor."""
    if item.kind == ObjectKind.JOINT:
        set_joint_sizes(sim, item, *(size * factor for size in joint_sizes(item)))
    elif item.kind == ObjectKind.VISION_SENSOR:
        sides = ",".join(repr(side * factor) for side in sensor_body(item))
        renaming.annotate(sim, item.handle, "vision", {"body": sides})
    elif item.kind in SIZES:
        set_mark_size(sim, item, mark_size(sim.model, item) * factor)


def _has_site(item: SceneObject) -> bool:
    return item.element == "site" and item.kind in _AT_SITES
