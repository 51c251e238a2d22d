"""Facts about paths, and their records."""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, Any

from simx_client.protocol import constants as c
from simx_server.scene.formats.vrep.decoding.paths import CLOSED
from simx_server.scene.formats.vrep.writing.record_lists import END, RecordList, parse_list

from ..field import Field, Fields, Writing, unwritable

if TYPE_CHECKING:
    from simx_server.scene.formats.vrep.writing.object_records import ObjectRecords
    from simx_server.world.world import World

_RULES = (
    CLOSED
    | c.sim_pathproperty_automatic_orientation
    | c.sim_pathproperty_keep_x_up
    | c.sim_pathproperty_flat_path
)
"""Bits of a path's attributes that the server knows."""

_SHOWN = 1
"""Attribute of a new path: its line is shown."""


def _points(world: World, handle: int) -> tuple[tuple[Any, ...], ...]:
    return tuple(
        (
            *(*point.pose[0], *point.pose[1], point.before, point.after, point.count),
            *(point.velocity, point.virtual, point.flags, *point.channels),
        )
        for point in world.paths.get(handle).curve.control
    )


def _put_points(records: ObjectRecords, points: tuple[tuple[Any, ...], ...], _writing: Writing) -> None:
    with records.own.child("Ntp") as course:
        old = [parse_list("path point", each, course.serialization) for each in course.each("Pat")]
        found = list[bytes]()
        for place, numbers in enumerate(points):
            record = old[place] if place < len(old) else RecordList("path point", course.serialization)
            *pose_and_factors, count, velocity, virtual, flags, one, two, three, four = numbers
            record.put_numbers("At2", *pose_and_factors, count, velocity)
            record.put_numbers("At3", virtual)
            record.put_numbers("At4", flags, one, two, three, four)
            found.append(bytes(record) + END)
        course.put("Pat", *found)


def _rules(world: World, handle: int) -> tuple[Any, ...]:
    rules = world.paths.get(handle).curve.rules
    bits = (
        CLOSED * rules.is_closed
        | c.sim_pathproperty_automatic_orientation * rules.follows_curve
        | c.sim_pathproperty_keep_x_up * rules.keeps_x_up
        | c.sim_pathproperty_flat_path * rules.is_flat
    )
    return bits, int(rules.method), rules.angle_to_length, rules.virtual_to_length


def _put_rules(records: ObjectRecords, value: tuple[Any, ...], _writing: Writing) -> None:
    bits, method, angle_to_length, virtual_to_length = value
    with records.own.child("Ntp") as course:
        if not course.has("At2"):
            course.put("At2", struct.pack("<i", _SHOWN))
        course.put_bits("At2", _RULES, bits)
        course.put_numbers("Av3", angle_to_length, method)
        course.put_numbers("Av9", virtual_to_length)


def _position(world: World, handle: int) -> tuple[float, float]:
    track = world.paths.get(handle)
    return track.position, track.target_velocity


def _put_position(records: ObjectRecords, value: tuple[float, float], _writing: Writing) -> None:
    with records.own.child("Ntp") as course:
        course.put_numbers("Jm2", *value)


def _motion(world: World, handle: int) -> tuple[float, bool]:
    track = world.paths.get(handle)
    return track.acceleration, track.is_explicit


PATHS: Fields = {
    "rules": Field(_rules, _put_rules),
    "control points": Field(_points, _put_points),
    "position and velocity": Field(_position, _put_position),
    "acceleration and handling": Field(
        _motion, unwritable("acceleration and handling"), is_usual=lambda value: value == (0.0, False)
    ),
}
