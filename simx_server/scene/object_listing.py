"""The objects of a scene as plain data, for programs that list or show them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import mujoco

from .live import LiveScene
from .naming.paths import path_parts
from .objects import ObjectKind, Scene, SceneObject

_JOINTS = {
    int(mujoco.mjtJoint.mjJNT_HINGE): "revolute",
    int(mujoco.mjtJoint.mjJNT_SLIDE): "prismatic",
    int(mujoco.mjtJoint.mjJNT_BALL): "spherical",
}


def list_objects(simulation: LiveScene) -> list[dict[str, Any]]:
    """Return all objects in tree order: each after its parent, with its depth."""
    scene = simulation.scene
    return [
        _object(simulation, scene.objects[handle], path, depth)
        for handle, path, depth in _in_tree_order(scene, -1, "", 0)
    ]


def _in_tree_order(scene: Scene, parent: int, above: str, depth: int) -> Iterator[tuple[int, str, int]]:
    """Yield handle, path and depth of all objects below. Building paths from each leaf upwards would take a second."""
    for child, part in path_parts(scene, parent).items():
        path = f"{above}/{part}"
        yield child, path, depth
        yield from _in_tree_order(scene, child, path, depth + 1)


def _object(simulation: LiveScene, item: SceneObject, path: str, depth: int) -> dict[str, Any]:
    scene, model = simulation.scene, simulation.model
    parent = scene.objects.get(item.parent)
    record: dict[str, Any] = {
        "handle": item.handle,
        "name": item.name,
        "path": path,
        "type": item.kind.text,
        "parent": item.parent,
        "parent_name": parent.name if parent is not None else None,
        "depth": depth,
        "is_model": scene.is_model_base(item.handle),
    }
    if item.kind is ObjectKind.JOINT:
        record["joint"] = (
            _JOINTS.get(int(model.jnt_type[item.id]), "") if item.element == "joint" else "prismatic"
        )
    elif item.kind is ObjectKind.VISION_SENSOR:
        record["resolution"] = [int(number) for number in model.cam_resolution[item.id]]
    return record
