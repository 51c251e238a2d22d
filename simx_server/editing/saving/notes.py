"""The annotations of a saved scene or model that belong to no part of the world: the tree, names, models, settings."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import mujoco

from simx_server.errors import CommandError
from simx_server.scene.formats.annotations import WORLD
from simx_server.scene.formats.annotations.ros2_keys import JOINT_LISTS
from simx_server.scene.naming.names import alias_of
from simx_server.scene.objects import NOT_A_MODEL, ObjectKind, Scene
from simx_server.scene.registered import concerned
from simx_server.scene.saved import Saved
from simx_server.scene.tree import build_scene

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation

_OF_PARTS = ("collection", "collision", "distance", "ik")
"""Kinds of registered entries that parts of the world have written."""

_KEPT = {
    "object": ("mark", "flags"),
    "joint": ("length", "diameter"),
    "vision": ("body",),
    "dummy": ("detectable", "collidable", "measurable"),
}
"""Keys of annotations that stay as they are in the scene: edits write them there at once."""


def noted(sim: Simulation, spec: mujoco.MjSpec, handles: Iterable[int], *, is_model: bool) -> Saved:
    """Return what is saved of these objects, with the notes of all parts of the world.

    Args:
        spec: its elements have their names in the scene's model; sizes of images are written into it.
        is_model: whether the objects are a model, and not the whole scene.
    """
    saved = Saved.of(sim.scene, spec, handles, is_model=is_model)
    sim.joints.saving(saved)
    sim.parts.tell(lambda part: part.saving(saved))
    note_simulation(saved, sim)
    note_objects(saved, sim.scene)
    note_registered(saved, sim)
    return saved


def note_simulation(saved: Saved, sim: Simulation) -> None:
    """Note the settings of the simulation."""
    saved.time_step = None if saved.is_model else sim.time_step
    saved.settings["dynamics"] = sim.dynamics_enabled


def note_objects(saved: Saved, scene: Scene) -> None:
    """Note what is common to all objects: their order, alias, model, and whether shapes are static."""
    for place, handle in enumerate(saved.names):
        item = scene.objects[handle]
        alias = item.alias if item.alias != alias_of(item.name) else None
        saved.put(handle, "object", order=place, alias=alias, parent=None)
        for kind, keys in _KEPT.items():
            note = item.annotations.get(kind, {})
            saved.put(handle, kind, **{key: note.get(key) for key in keys})
        bits = scene.model_property(handle)
        is_base = not bits & NOT_A_MODEL
        saved.put(handle, "model", base=is_base or None, properties=bits if is_base and bits else None)
        if item.kind == ObjectKind.SHAPE:
            static = None
            if item.element == "body" and item.element_name in scene.welded_bodies:
                static = False
            elif item.element == "body" and item.element_name in scene.weightless_bodies:
                static = True
            saved.put(handle, "shape", static=static)


def note_registered(saved: Saved, sim: Simulation) -> None:
    """Keep the registered entries that are alive, and in a model those of its objects; drop dead references."""
    alive = sim.parts.registered_names()
    present = {
        kind: {
            name: note for name, note in notes.items() if kind in _OF_PARTS or name in alive.get(kind, notes)
        }
        for kind, notes in saved.registered.items()
    }
    names = set(saved.names.values())
    found = concerned(present, names)
    for kind in _OF_PARTS:
        found[kind] = present.get(kind, {})
    if not saved.is_model:
        for kind in ("ui", "old_ui"):
            own = present.get(kind, {})
            found[kind] = {
                name: note for name, note in own.items() if note.get("object", WORLD) in {*names, WORLD}
            }
    groups = found["ik"]
    for note in groups.values():
        if note.get("after") not in groups:
            note.pop("after", None)
    saved.registered = {kind: notes for kind, notes in found.items() if notes}
    for handle in saved.names:
        ros2 = saved.objects[handle].get("ros2", {})
        words = [word for key in JOINT_LISTS if key in ros2 for word in str(ros2[key]).split(",")]
        if not names.issuperset(word.partition(":")[0] for word in words):
            saved.drop(handle, "ros2")


def note_parents(saved: Saved, scene: Scene, model: mujoco.MjModel) -> None:
    """Note parents that do not follow from the bodies; check that all objects are in the saved model.

    Raises:
        SceneError: an annotation does not fit what is saved.
        CommandError: an object would not be there again.
    """
    made = build_scene(saved.spec, model, saved.annotations(), None)
    kinds = {item.name: item.kind for item in made.objects.values()}
    wanted = {name: scene.objects[handle].kind for handle, name in saved.names.items()}
    if kinds != wanted:
        different = sorted(
            name for name in kinds.keys() | wanted.keys() if kinds.get(name) != wanted.get(name)
        )
        raise CommandError(f"the file would not have '{different[0]}' as it is; nothing is saved")
    handles = {name: handle for handle, name in saved.names.items()}
    for item in made.objects.values():
        handle = handles[item.name]
        found = None if item.parent == -1 else made.objects[item.parent].name
        parent = saved.name(scene.objects[handle].parent)
        if parent != found:
            saved.put(handle, "object", parent=WORLD if parent is None else parent)
