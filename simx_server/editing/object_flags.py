"""Flags of objects: what they are to calculations (`sim.objectspecialproperty_*`), and what viewers do with them
(`sim.objectproperty_*`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_client.protocol import constants as c
from simx_server.parts.custom_data import HIDDEN
from simx_server.scene import properties
from simx_server.scene.abilities import ability, note_of
from simx_server.scene.editing import renaming
from simx_server.scene.formats.annotations import DETECTABLE_KINDS, Annotation
from simx_server.scene.objects import ObjectKind

if TYPE_CHECKING:
    from simx_server.world.world import World

_SPECIAL = {
    "collidable": c.sim_objectspecialproperty_collidable,
    "measurable": c.sim_objectspecialproperty_measurable,
}
"""Abilities of an object and the bits with the same meaning."""

_FIRST_KIND = c.sim_objectspecialproperty_detectable_ultrasonic
_DETECTABLE = {kind: _FIRST_KIND << place for place, kind in enumerate(DETECTABLE_KINDS)}
"""Bits of the kinds of proximity sensors that detect an object."""

_FLAGS = HIDDEN + "property"
"""Name under which the bits for viewers are stored."""


def special_flags(world: World, handle: int) -> int:
    """Return bits `sim.objectspecialproperty_*`: whether the object itself is collidable, measurable, detectable and
    renderable, without the properties of its models. Raises UnknownHandle.
    """
    item = world.simulation.scene.get(handle)
    if item.kind not in (ObjectKind.SHAPE, ObjectKind.DUMMY):
        return 0
    bits = sum(bit for name, bit in _SPECIAL.items() if ability(item, name))
    detectable = ability(item, "detectable")
    kinds = detectable.split(",") if isinstance(detectable, str) else _DETECTABLE if detectable else ()
    bits |= sum(_DETECTABLE[kind] for kind in kinds)
    if item.kind == ObjectKind.DUMMY:
        return bits
    seen = world.object_settings.is_drawn(handle) and not properties.is_unseen(item)
    return bits | (c.sim_objectspecialproperty_renderable if seen else 0)


def set_special_flags(world: World, handle: int, bits: int) -> None:
    """Set bits `sim.objectspecialproperty_*` of a shape or dummy until the simulation stops.

    A shape that the scene file hides from images stays hidden; images show no dummies. Raises UnknownHandle, WrongKind.
    """
    sim = world.simulation
    item = sim.scene.get_kind(handle, ObjectKind.SHAPE, ObjectKind.DUMMY)
    said: Annotation = {name: bool(bits & bit) for name, bit in _SPECIAL.items()}
    kinds = [kind for kind, bit in _DETECTABLE.items() if bits & bit]
    is_plain = not kinds or (
        len(kinds) == len(_DETECTABLE) and not isinstance(ability(item, "detectable"), str)
    )
    said["detectable"] = bool(kinds) if is_plain else ",".join(kinds)
    if item.kind == ObjectKind.DUMMY:
        renaming.annotate(sim, handle, note_of(item), said)
        return
    said["renderable"] = bool(bits & c.sim_objectspecialproperty_renderable)
    was_unseen = properties.is_unseen(item)
    renaming.annotate(sim, handle, note_of(item), said)
    if properties.is_unseen(item) != was_unseen:
        properties.apply(sim)
        sim.changed()


def flags(world: World, handle: int) -> int:
    """Return bits `sim.objectproperty_*` for viewers of the scene. Raises UnknownHandle.

    The default is that of the file, else `sim.objectproperty_selectable`.
    """
    kept = world.custom_data.read(handle, _FLAGS)
    note = world.simulation.scene.get(handle).annotations.get("object", {})
    return int(kept) if kept and kept.isdigit() else int(note.get("flags", c.sim_objectproperty_selectable))


def set_flags(world: World, handle: int, bits: int) -> None:
    """Store bits `sim.objectproperty_*`; bounding boxes of models depend on one of them. Raises UnknownHandle."""
    world.custom_data.write(handle, _FLAGS, str(bits).encode())
