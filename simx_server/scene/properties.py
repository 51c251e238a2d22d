"""The properties of models that `simxSetModelProperty` sets, and their effects.

Bits of a model base restrict every object below it, as in V-REP, regardless of the object's properties.
This module applies the bits that concern physics, start and stop; sensors read `Scene.overridden` when they measure.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from simx_client.protocol import constants as c
from simx_server.errors import CommandError

from .cameras.visibility import SENSORS_GROUP, USERS_GROUP, VISIBLE_GROUPS
from .colliding.respondable import collect_masks
from .editing.welding import set_static
from .formats.annotations.annotation import Value
from .objects import NOT_A_MODEL, ObjectKind, Scene, SceneObject
from .poses.placing import free_joint

if TYPE_CHECKING:
    from .live import LiveScene

SCRIPTS_INACTIVE = 0x200
"""`sim_modelproperty_scripts_inactive`, which the legacy constants lack."""

_NOT_SHOWN_INSIDE = 0x400
"""`sim_modelproperty_not_showasinsidemodel`, another one: it concerns the display of the hierarchy."""

_UNSEEN_GROUP = 5
"""A geom group that is hidden from all cameras."""

_ON_GEOMS = (
    c.sim_modelproperty_not_respondable | c.sim_modelproperty_not_renderable | c.sim_modelproperty_not_visible
)

_ARRAYS = ("geom_contype", "geom_conaffinity", "geom_group")
"""Model arrays that these bits change."""

FIRST_LAYER = 0x0001
"""The layer of an object without others."""

SHOWN_LAYERS = 0x00FF
"""Visibility layers that the views of a new scene show."""

_KNOWN = 0x1FF | SCRIPTS_INACTIVE | _NOT_SHOWN_INSIDE


def set_model_property(sim: LiveScene, handle: int, bits: int) -> None:
    """Make an object a model base with these bits; with any bit of 0xF000, an ordinary object.

    Raises UnknownHandle, CommandError for bits without a meaning here.
    """
    item, before = sim.scene.get(handle), sim.scene.own_model_bits(handle)
    if bits & NOT_A_MODEL:
        sim.scene.set_model_property(handle, NOT_A_MODEL)
    else:
        if bits & ~_KNOWN:
            raise CommandError(
                f"'{item.name}' cannot be a model with property 0x{bits & 0xFFFFFFFF:x}; "
                f"valid are the bits 0x{_KNOWN:x}, and 0x{NOT_A_MODEL:x} for no model"
            )
        sim.scene.set_model_property(handle, bits)
    apply(sim, before ^ sim.scene.own_model_bits(handle))
    sim.changed()


def apply(sim: LiveScene, changed: int = _KNOWN) -> None:
    """Apply the properties of all models. Call this after they, or the tree, have changed.

    `changed`: bits that differ from before; only their effects are applied again.
    """
    if not changed & (_ON_GEOMS | c.sim_modelproperty_not_dynamic):
        return
    bits = 0
    for handle in {*sim.scene.model_properties, *_annotated_models(sim.scene)}:
        bits |= sim.scene.overridden(handle) if handle in sim.scene.objects else 0
    if changed & _ON_GEOMS and (bits & _ON_GEOMS or sim.scene.withheld or _are_any_hidden(sim.scene)):
        _restrict_geoms(sim)
    if changed & c.sim_modelproperty_not_dynamic and (
        bits & c.sim_modelproperty_not_dynamic or sim.scene.made_static or sim.joints.has_inert
    ):
        _restrict_motion(sim)


def _annotated_models(scene: Scene) -> list[int]:
    """Return the handles of the model bases that the file gives properties to."""
    notes = scene.annotations.objects
    names = [name for name, kinds in notes.items() if "model" in kinds and kinds["model"].get("properties")]
    return [handle for handle in map(scene.by_name, names) if handle is not None]


def is_unseen(item: SceneObject) -> bool:
    """Return whether a shape itself was set to be left out of images, regardless of its models."""
    return not item.annotations.get("shape", {}).get("renderable", True)


def _are_any_hidden(scene: Scene) -> bool:
    """Return whether any shape is left out of images; few of many objects have annotations."""
    return not _is_on_shown_layer(scene, {}) or any(
        not notes.get("shape", {}).get("renderable", True) or not _is_on_shown_layer(scene, notes)
        for notes in scene.annotations.objects.values()
    )


def _is_on_shown_layer(scene: Scene, notes: Mapping[str, Mapping[str, Value]]) -> bool:
    """Return whether the visibility layers of an object, by its annotations, are among those that views show."""
    shown = int(scene.annotations.scene.get("layers", SHOWN_LAYERS))
    return bool(int(notes.get("object", {}).get("layers", FIRST_LAYER)) & shown)


def _restrict_geoms(sim: LiveScene) -> None:
    """Apply the bits to the geoms of restricted models, and restore the values of all others."""
    scene, model = sim.scene, sim.model
    for geom in range(model.ngeom):
        owner = scene.owner_of_geom(geom, model)
        name, bits = model.geom(geom).name, scene.overridden(owner)
        if owner != -1 and is_unseen(scene.objects[owner]):
            bits |= c.sim_modelproperty_not_renderable
        before = scene.withheld.get((name, "geom_group"), int(model.geom_group[geom]))
        is_on_layer = owner == -1 or _is_on_shown_layer(scene, scene.objects[owner].annotations)
        values = _values(bits, before, is_on_layer=is_on_layer)
        for array in _ARRAYS:
            numbers = getattr(model, array)
            if array in values:
                scene.withheld.setdefault((name, array), int(numbers[geom]))
                numbers[geom] = values[array]
            elif (name, array) in scene.withheld:
                numbers[geom] = scene.withheld.pop((name, array))
    collect_masks(model)
    sim.model_edited()


def _values(bits: int, group: int, *, is_on_layer: bool) -> dict[str, int]:
    """Return the numbers that bits set in a geom, by array.

    In V-REP too, vision sensors do not see shapes that are invisible because of their model, but see those that are
    invisible by their layers; users see what is not renderable, unless its layers hide it.

    Args:
        bits: of the models around the geom's shape, and of the shape itself.
        group: the geom's group in the file.
        is_on_layer: whether its visibility layers are shown.
    """
    values: dict[str, int] = {}
    if bits & c.sim_modelproperty_not_respondable:
        values |= {"geom_contype": 0, "geom_conaffinity": 0}
    if bits & (c.sim_modelproperty_not_renderable | c.sim_modelproperty_not_visible):
        for_users = group in VISIBLE_GROUPS and is_on_layer and not bits & c.sim_modelproperty_not_visible
        values["geom_group"] = USERS_GROUP if for_users else _UNSEEN_GROUP
    elif group in VISIBLE_GROUPS and not is_on_layer:
        values["geom_group"] = SENSORS_GROUP
    return values


def _restrict_motion(sim: LiveScene) -> None:
    """Fix the free bodies of models that are not dynamic and hold their joints; release the others."""

    def still(handle: int) -> bool:
        return bool(sim.scene.overridden(handle) & c.sim_modelproperty_not_dynamic)

    for handle, item in list(sim.scene.objects.items()):
        if item.element == "body" and item.kind in (ObjectKind.SHAPE, ObjectKind.DUMMY):
            body = sim.scene.objects[handle].id
            if still(handle) and free_joint(sim.model, body) >= 0:
                set_static(sim, handle, True)
                sim.scene.made_static.add(item.element_name)
            elif not still(handle) and item.element_name in sim.scene.made_static:
                set_static(sim, handle, False)
                sim.scene.made_static.discard(item.element_name)
    sim.joints.hold_inert({handle for handle in sim.scene.of_kind(ObjectKind.JOINT) if still(handle)})
