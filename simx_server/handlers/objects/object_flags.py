"""Flags of objects: what they are to calculations (`sim.objectspecialproperty_*`), and what viewers do with them
(`sim.objectproperty_*`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_client.protocol import constants as c
from simx_server.parts.custom_data import HIDDEN
from simx_server.scene import properties
from simx_server.scene.editing import renaming
from simx_server.scene.formats.annotations import DETECTABLE_KINDS, Annotation
from simx_server.scene.objects import ObjectKind

if TYPE_CHECKING:
    from simx_server.world.world import World

_SPECIAL = {
    "collidable": c.sim_objectspecialproperty_collidable,
    "measurable": c.sim_objectspecialproperty_measurable,
}
"""Annotations of a shape in the scene and the bits with the same meaning."""

_FIRST_KIND = c.sim_objectspecialproperty_detectable_ultrasonic
_DETECTABLE = {kind: _FIRST_KIND << place for place, kind in enumerate(DETECTABLE_KINDS)}
"""Bits of the kinds of proximity sensors that detect a shape."""

_FLAGS = HIDDEN + "property"
"""Name under which the bits for viewers are stored."""


def special_flags(world: World, handle: int) -> int:
    """Return bits `sim.objectspecialproperty_*`: whether the object itself is collidable, measurable, detectable and
    renderable, without the properties of its models. Raises UnknownHandle.
    """
    item = world.simulation.scene.get(handle)
    if item.kind != ObjectKind.SHAPE:
        return c.sim_objectspecialproperty_measurable if item.kind == ObjectKind.DUMMY else 0
    note = item.annotations.get("shape", {})
    bits = sum(bit for name, bit in _SPECIAL.items() if note.get(name, True))
    detectable = note.get("detectable", True)
    kinds = detectable.split(",") if isinstance(detectable, str) else _DETECTABLE if detectable else ()
    bits |= sum(_DETECTABLE[kind] for kind in kinds)
    seen = world.object_settings.is_drawn(handle) and not properties.is_unseen(item)
    return bits | (c.sim_objectspecialproperty_renderable if seen else 0)


def set_special_flags(world: World, handle: int, bits: int) -> None:
    """Set bits `sim.objectspecialproperty_*` of a shape until the simulation stops.

    A shape that the scene file hides from images stays hidden. Raises UnknownHandle, WrongKind.
    """
    sim = world.simulation
    item = sim.scene.get_kind(handle, ObjectKind.SHAPE)
    said: Annotation = {name: bool(bits & bit) for name, bit in _SPECIAL.items()}
    said["renderable"] = bool(bits & c.sim_objectspecialproperty_renderable)
    kinds = [kind for kind, bit in _DETECTABLE.items() if bits & bit]
    is_declared = isinstance(item.annotations.get("shape", {}).get("detectable"), str)
    is_plain = not kinds or (len(kinds) == len(_DETECTABLE) and not is_declared)
    said["detectable"] = bool(kinds) if is_plain else ",".join(kinds)
    renaming.annotate(sim, handle, "shape", said)
    properties.apply(sim)
    sim.changed()


def flags(world: World, handle: int) -> int:
    """Return bits `sim.objectproperty_*` for viewers of the scene. Raises UnknownHandle.

    The default is that of the file, else `sim.objectproperty_selectable`.
    """
    kept = world.custom_data.read(handle, _FLAGS)
    note = world.simulation.scene.get(handle).annotations.get("object", {})
    return int(kept) if kept else int(note.get("flags", c.sim_objectproperty_selectable))


def set_flags(world: World, handle: int, bits: int) -> None:
    """Store bits `sim.objectproperty_*`; nothing here depends on them. Raises UnknownHandle."""
    world.custom_data.write(handle, _FLAGS, str(bits).encode())
