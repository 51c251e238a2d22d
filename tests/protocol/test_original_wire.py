"""Every number of the original's protocol stands for one command of the table."""

from __future__ import annotations

import pytest

from simx_client.protocol.commands import BY_NAME, CARRIED, TABLE, Place
from simx_client.protocol.table.original_wire import KILL_CONNECTION, RESERVED, wires

IDS = (
    *range(0x0001, 0x000B),
    *range(0x1001, 0x1039),
    0x1801,
    *range(0x2001, 0x2011),
    0x2801,
    *range(0x3001, 0x301A),
    0x3401,
)
"""All numbers of the protocol's newest version, with those that are reserved."""

WIRES = wires((*TABLE, *CARRIED))


def test_every_number_of_the_protocol_is_there() -> None:
    assert {wire.id for wire in WIRES} | {*RESERVED, KILL_CONNECTION} == set(IDS)


def test_every_function_of_the_original_that_travels_has_a_number() -> None:
    reached = {wire.command for wire in WIRES}
    assert {name for name, command in BY_NAME.items() if command.legacy_id is not None} == {
        name for name, command in BY_NAME.items() if command.name in reached
    }
    assert all(command.legacy_id is None for command in TABLE if command.place is Place.LOCAL)


@pytest.mark.parametrize("wire", WIRES, ids=lambda wire: f"{wire.id:#06x} {wire.command}")
def test_each_argument_comes_from_one_place(wire) -> None:
    command = BY_NAME.get(wire.command) or next(each for each in CARRIED if each.name == wire.command)
    places = [
        *(name for name in wire.ident if name),
        *(name for names, _ in wire.request for name in names),
        *wire.fixed,
    ]
    assert sorted(places) == sorted(command.takes)
    assert len(wire.reply) == len(command.gives) or wire.reply in (("lists",), ("group",))


@pytest.mark.parametrize("wire", WIRES, ids=lambda wire: f"{wire.id:#06x}")
def test_identification_data_is_as_long_as_the_range_of_the_number_says(wire) -> None:
    ranges = {0x0000: 0, 0x1000: 1, 0x2000: 2, 0x3000: 1}
    assert len(wire.ident) == (3 if wire.id == 0x3401 else ranges[wire.id & 0xF000])
