"""Facts about dummies and force sensors, and their records."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from simx_server.handlers.quantities.objects import OBJECTS
from simx_server.scene.formats.vrep.chunks import twin
from simx_server.scene.formats.vrep.decoding.joints import (
    BREAKS,
    FOLLOWS,
    IS_OVERLOADED,
    LIMITS_FORCE,
    LIMITS_TORQUE,
    MEDIAN,
)
from simx_server.scene.formats.vrep.writing.colors import put_color

from ..field import Field, Fields, Handle, Writing

if TYPE_CHECKING:
    from simx_server.scene.formats.vrep.writing.object_records import ObjectRecords
    from simx_server.world.world import World


def _link(world: World, handle: int) -> tuple[Handle, int]:
    return Handle(world.dummy_links.linked(handle)), world.dummy_links.type(handle)


def _put_link(records: ObjectRecords, value: tuple[Handle, int], writing: Writing) -> None:
    other, kind = value
    records.own.put_numbers("Lli", writing.number(other))
    records.own.put_numbers("Dl2", kind)


def _offset(world: World, handle: int) -> tuple[float] | tuple[()]:
    """Return how far ahead of its path's position a dummy is, as a tuple; an empty one for no follower."""
    follower = world.paths.follower(handle)
    return () if follower is None else (follower.offset,)


def _put_offset(records: ObjectRecords, value: tuple[float, ...], _writing: Writing) -> None:
    records.own.put_bits("Var", FOLLOWS, FOLLOWS if value else 0)
    if value:
        records.own.put_numbers("Po5", value[0], None)


def _color(world: World, handle: int) -> tuple[float, ...] | None:
    """Return red, green, blue of the mark that shows a dummy; None for a dummy that is a body."""
    sim = world.simulation
    item = sim.scene.objects[handle]
    return tuple(sim.model.site_rgba[item.id, :3].tolist()) if item.element == "site" else None


DUMMIES: Fields = {
    "link": Field(_link, _put_link),
    "size": Field(
        lambda world, handle: OBJECTS["dummyfloatparam_size"].get(world, handle),  # type: ignore[misc]
        lambda records, value, _: records.own.put_numbers("Dy2", value),
    ),
    "offset on a path": Field(_offset, _put_offset),
    "colour": Field(_color, lambda records, value, _: put_color(records.own, "Cl0", diffuse=value)),
}


def _thresholds(world: World, handle: int) -> tuple[Any, ...]:
    note = world.simulation.scene.objects[handle].annotations.get("force", {})
    return (
        *(note.get("max_force"), note.get("max_torque"), note.get("violations", 1)),
        note.get("overload", "break"),
    )


def _put_thresholds(records: ObjectRecords, value: tuple[Any, ...], _writing: Writing) -> None:
    force, torque, violations, overload = value
    tag = BREAKS if overload == "break" else IS_OVERLOADED
    if tag == BREAKS:
        records.own.remove(IS_OVERLOADED, twin(IS_OVERLOADED))  # it would count
    records.own.put_numbers(
        tag, 100.0 if force is None else force, 10.0 if torque is None else torque, violations
    )
    bits = LIMITS_FORCE * (force is not None) | LIMITS_TORQUE * (torque is not None)
    records.own.put_bits("Vab", LIMITS_FORCE | LIMITS_TORQUE, bits)


def _filter(world: World, handle: int) -> tuple[Any, ...]:
    note = world.simulation.scene.objects[handle].annotations.get("force", {})
    return note.get("samples", 1), note.get("filter", "average")


def _put_filter(records: ObjectRecords, value: tuple[Any, ...], _writing: Writing) -> None:
    samples, kind = value
    records.own.put_numbers("Fil", samples, MEDIAN if kind == "median" else 0)


def size_of_site(world: World, handle: int) -> float:
    """Return the size of the mark that shows a sensor, m."""
    sim = world.simulation
    item = sim.scene.objects[handle]
    return 2 * float(sim.model.site_size[item.id, 0]) if item.element == "site" else 0.01


FORCE_SENSORS: Fields = {
    "thresholds": Field(_thresholds, _put_thresholds),
    "filter": Field(_filter, _put_filter),
    "size": Field(size_of_site, lambda records, value, _: records.own.put_numbers("Siz", value)),
}
