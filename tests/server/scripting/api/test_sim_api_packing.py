"""Numbers, tables and pictures as bytes, as scripts pack and change them."""

from __future__ import annotations

import base64
import struct

import pytest
from sim_api_calls import ScriptWorld, world

__all__ = ["world"]

KINDS = [
    ("sim.packUInt8Table(%s)", "sim.unpackUInt8Table(%s)", "B", [0, 1, 255]),
    ("sim.packBytes(%s)", "sim.unpackBytes(%s)", "B", [0, 1, 255]),
    ("sim.packUInt16Table(%s)", "sim.unpackUInt16Table(%s)", "H", [0, 258, 65535]),
    ("sim.packWords(%s)", "sim.unpackWords(%s)", "H", [0, 258, 65535]),
    ("sim.packUInt32Table(%s)", "sim.unpackUInt32Table(%s)", "I", [0, 1, 4294967295]),
    ("sim.packUInts(%s)", "sim.unpackUInts(%s)", "I", [0, 1, 4294967295]),
    ("sim.packInt32Table(%s)", "sim.unpackInt32Table(%s)", "i", [0, -1, 2147483647]),
    ("sim.packInts(%s)", "sim.unpackInts(%s)", "i", [0, -1, 2147483647]),
    ("sim.packFloatTable(%s)", "sim.unpackFloatTable(%s)", "f", [0.0, -1.5, 0.25]),
    ("sim.packFloats(%s)", "sim.unpackFloats(%s)", "f", [0.0, -1.5, 0.25]),
    ("sim.packDoubleTable(%s)", "sim.unpackDoubleTable(%s)", "d", [0.0, 0.1, -1e300]),
    ("sim.packDoubles(%s)", "sim.unpackDoubles(%s)", "d", [0.0, 0.1, -1e300]),
]


def raw(text: str) -> bytes:
    return text.encode("latin-1")


def lua_bytes(data: bytes) -> str:
    return '"' + "".join(f"\\x{byte:02x}" for byte in data) + '"'


@pytest.mark.parametrize(("pack", "unpack", "letter", "numbers"), KINDS)
def test_tables_of_numbers_are_packed_and_unpacked(
    world: ScriptWorld, pack: str, unpack: str, letter: str, numbers: list[float]
) -> None:
    expected = struct.pack(f"<3{letter}", *numbers)
    table = "{" + ",".join(map(repr, numbers)) + "}"
    data = lua_bytes(expected)
    assert raw(world.value(pack % table)) == expected
    assert raw(world.value(pack % f"{table}, 1")) == expected[len(expected) // 3 :]
    assert raw(world.value(pack % f"{table}, 0, 2")) == expected[: len(expected) // 3 * 2]
    assert world.value(unpack % data) == numbers
    assert world.value(unpack % f"{data}, 1, 1") == numbers[1:2]


def test_unpacking_may_begin_some_bytes_later(world: ScriptWorld) -> None:
    assert world.value("sim.unpackInt32Table('x\\1\\0\\0\\0', 0, 0, 1)") == [1]
    assert world.value("sim.unpackUInt8Table('abc', 0, 0, 2)") == [99]


def test_numbers_that_do_not_fit_wrap_and_spans_are_checked(world: ScriptWorld) -> None:
    assert world.value("sim.unpackUInt8Table(sim.packUInt8Table({256, -1, 1.9}))") == [0, 255, 1]
    assert world.value("sim.unpackInt32Table(sim.packInt32Table({4294967295}))") == [-1]
    assert world.value("sim.unpackFloatTable(sim.packFloatTable({1e300}))") == ["inf"]
    world.fails("sim.packInt32Table({1,2}, 1, 2)", "has 2 items, which 2 of them from index 1 do not fit")
    world.fails("sim.packInt32Table({'x'})", "a table with a finite number at index 1")
    world.fails("sim.unpackInt32Table('abcd', 0, 0, 9)", "byte offset must be 0 to 4")


def test_tables_of_anything_are_packed(world: ScriptWorld) -> None:
    assert world.value("sim.unpackTable(sim.packTable({1, 2.5, 'text', true, {3, {}}}))") == [
        1,
        2.5,
        "text",
        True,
        [3, []],
    ]
    assert world.value("sim.unpackTable(sim.packTable({a = 1, b = {c = 'x'}}, 1))") == {
        "a": 1,
        "b": {"c": "x"},
    }
    assert world.value("sim.packTable({a = 1, b = 2}) == sim.packTable({b = 2, a = 1})") is True
    mixed = "{1, 2, x = 3, [-1] = 4, deep = {5, y = {6}}, ['\\xff'] = 7}"
    assert world.value(f"sim.unpackTable(sim.packTable({mixed}))") == {
        1: 1,
        2: 2,
        -1: 4,
        "x": 3,
        "deep": {1: 5, "y": [6]},
        "\xff": 7,
    }
    world.fails("sim.packTable({[0.5] = 1})", "a table with a number with a fraction as a key cannot leave")
    world.fails("sim.packTable(7)", "only a table can be packed")
    world.fails("sim.packTable({}, 9)", "the scheme is 0, 1 or 2")
    world.fails("sim.packTable({print})", "cannot")
    world.fails("sim.unpackTable('x')", "not made by packTable of this server")
    world.fails("sim.unpackTable(sim.packTable({1,2,3}):sub(1, -2))", "the packed table is damaged")


def test_the_list_part_of_a_table_with_names_is_a_list_to_functions_that_want_one(world: ScriptWorld) -> None:
    assert world.value("sim.unpackInt32Table(sim.packInt32Table({1, 2, name = 'x'}))") == [1, 2]
    world.fails("sim.packInt32Table({1, nil, 3})", "must be a table without gaps")
    world.fails("sim.packInt32Table({name = 'x'})", "must be a table, got a table with names")


def test_buffers_change_their_kind_of_numbers(world: ScriptWorld) -> None:
    assert world.value(
        "sim.unpackFloatTable(sim.transformBuffer('\\0\\51\\255', sim.buffer_uint8, 1/255, 0, sim.buffer_float))"
    ) == pytest.approx([0, 0.2, 1])
    assert world.value(
        "sim.unpackUInt8Table(sim.transformBuffer(sim.packFloatTable({-0.1, 0.5, 1.1}), sim.buffer_float, 255, 0,"
        "sim.buffer_uint8 + sim.buffer_clamp))"
    ) == [0, 127, 255]
    assert world.value(
        "sim.unpackUInt8Table(sim.transformBuffer(sim.packUInt8Table({200}), sim.buffer_uint8, 2, 0, sim.buffer_uint8))"
    ) == [400 - 256]
    assert world.value(
        "sim.unpackUInt16Table(sim.transformBuffer(sim.packInt32Table({70000}), sim.buffer_int32, 1, 0, "
        "sim.buffer_uint16))"
    ) == [70000 - 65536]
    world.fails(
        "sim.transformBuffer('abc', sim.buffer_float, 1, 0, sim.buffer_uint8)", "no whole count of numbers"
    )
    world.fails("sim.transformBuffer('abc', 99, 1, 0, sim.buffer_uint8)", "99 is no buffer format")
    world.fails("sim.transformBuffer('abc', 0, 1, 0, 99)", "99 is no buffer format")


def test_pixels_change_their_order(world: ScriptWorld) -> None:
    def change(source: str, target: str) -> bytes:
        return raw(
            world.value(
                f"sim.transformBuffer('rgbRGB', sim.buffer_uint8{source}, 1, 0, sim.buffer_uint8{target})"
            )
        )

    assert change("rgb", "bgr") == b"bgrBGR"
    assert change("rgb", "rgba") == b"rgb\xffRGB\xff"
    assert change("rgb", "argb") == b"\xffrgb\xffRGB"
    assert (
        raw(world.value("sim.transformBuffer('argb', sim.buffer_uint8argb, 1, 0, sim.buffer_uint8rgb)"))
        == b"rgb"
    )
    assert world.value(
        "sim.unpackFloatTable(sim.transformBuffer('\\0\\128\\255', sim.buffer_uint8rgb, 1/255, 0, sim.buffer_float))"
    ) == pytest.approx([0, 128 / 255, 1])
    world.fails(
        "sim.transformBuffer('abcd', sim.buffer_uint8rgb, 1, 0, sim.buffer_uint8bgr)",
        "no whole count of pixels",
    )


def test_buffers_as_text_and_in_pieces(world: ScriptWorld) -> None:
    text = base64.b64encode(b"\0\1hello").decode()
    assert (
        world.value("sim.transformBuffer('\\0\\1hello', sim.buffer_uint8, 1, 0, sim.buffer_base64)") == text
    )
    assert (
        world.value(f"sim.transformBuffer('{text}', sim.buffer_base64, 1, 0, sim.buffer_uint8)")
        == "\0\1hello"
    )
    assert world.value("sim.transformBuffer('abcdef', sim.buffer_uint8, 0, 2, sim.buffer_split)") == [
        "ab",
        "cd",
        "ef",
    ]
    world.fails(
        "sim.transformBuffer('abc', sim.buffer_uint8, 0, 2, sim.buffer_split)",
        "cannot be split into pieces of 2",
    )
    world.fails("sim.transformBuffer('a!', sim.buffer_base64, 1, 0, sim.buffer_uint8)", "no base64")
