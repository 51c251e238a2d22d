"""Numbers, tables and pictures as bytes, as scripts pack and change them."""

from __future__ import annotations

import base64
import struct

import pytest
from sim_api_calls import ScriptWorld, world

from simx_server.sim_api.values import cbor
from simx_server.sim_api.values.tables import pack_table

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
    assert world.value("sim.unpackInt32Table(sim.packInt32Table({1, 2}, 1, 2))") == [2]
    world.fails("sim.packInt32Table({'x'})", "a table with a finite number at index 1")
    assert world.value("sim.unpackInt32Table('abcd', 0, 0, 9)") == []


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
    world.fails("sim.packTable({}, 9)", "the scheme is 0 .* not 9")
    assert world.value("sim.unpackTable(sim.packTable({print}))") == ["<FUNCTION>"]
    world.fails("sim.unpackTable('x')", "this is no packed table")
    world.fails("sim.unpackTable(sim.packTable({1,2,3}):sub(1, -2))", "the packed table is damaged")


NAMED = b"\x03\x01\0\0\0n"
"""The name ``n`` in V-REP's format."""


@pytest.mark.parametrize(
    ("data", "table"),
    [
        (b"\0\0\x02\0\0\0" + NAMED + b"\x01" + struct.pack("<d", 7), {"n": 7}),
        (b"\0\0\x02\0\0\0" + NAMED + b"\x01" + struct.pack("<d", 0.5), {"n": 0.5}),
        (b"\x05\0\x02\0\0\0" + NAMED + b"\x09" + struct.pack("<q", -3), {"n": -3}),
        (b"\x05\x01\x03\0\0\0\0\x02\x01\x04\x01\0\0\0\0", {2: True, 3: []}),
        (b"\x05\x01\x01\0\0\0\x02\0\x02\x02\x02\xff", [False]),
        (b"\xa1\x61n\x82\x01\xfb" + struct.pack(">d", 0.5), {"n": [1, 0.5]}),
        (b"\xd9\xd9\xf7\x9f\x18\x20\xf4\xf9\x3c\x00\xff", [32, False, 1.0]),
        (b"\x81\x5f\x42ab\x41c\xff", ["abc"]),
    ],
    ids=["3.x whole", "3.x", "4.3", "nil", "4.7", "cbor", "cbor tag", "cbor pieces"],
)
def test_tables_that_other_programs_packed_are_read(world: ScriptWorld, data: bytes, table: object) -> None:
    assert world.value(f"sim.unpackTable({lua_bytes(data)})") == table


def test_a_number_of_the_old_format_shows_as_lua_5_1_showed_it(world: ScriptWorld) -> None:
    old = b"\0\x01\x01\0\0\0\x01" + struct.pack("<d", 5)
    assert world.value(f"'v' .. sim.unpackTable({lua_bytes(old)})[1]") == "v5"


def test_tables_are_packed_in_the_formats_of_others(world: ScriptWorld) -> None:
    assert raw(world.value("sim.packTable({a = 1, b = {0.5, true}})")) == (
        b"\x05\0\x04\0\0\0\x03\x01\0\0\0a\x09\x01\0\0\0\0\0\0\0\x03\x01\0\0\0b"
        b"\x04\x01\x02\0\0\0\x01" + struct.pack("<d", 0.5) + b"\x02\x01"
    )
    assert raw(world.value("sim.packTable({'t', '\\0', 0.5, -1}, 1)")) == (
        b"\x84\x61t\x41\0\xfb" + struct.pack(">d", 0.5) + b"\x20"
    )
    assert raw(world.value("sim.packTable({0.5, 'x@:dat:', 300}, 2)")) == (
        b"\x83\xfa" + struct.pack(">f", 0.5) + b"\x41x\x19\x01\x2c"
    )


@pytest.mark.parametrize("scheme", [0, 1])
def test_a_damaged_table_is_refused_wherever_it_ends(world: ScriptWorld, scheme: int) -> None:
    table = "{a = {1, 2.5, 'text', {true}}, b = -70000}"
    count = world.value(f"#sim.packTable({table}, {scheme})")
    world.lua(
        f"data = sim.packTable({table}, {scheme}); good = 0; for i = 0, #data - 1 do "
        "if pcall(sim.unpackTable, data:sub(1, i)) then good = good + 1 end end"
    )
    assert count > 20
    assert world.value("good") == 0
    world.fails(f"sim.unpackTable({lua_bytes(bytes([0x81]) * 40)})", "nested more than")
    nested = b"\x05" + b"\x01\x01\0\0\0\x04" * 40
    world.fails(f"sim.unpackTable({lua_bytes(nested)})", "nested more than")


def test_the_list_part_of_a_table_with_names_is_a_list_to_functions_that_want_one(world: ScriptWorld) -> None:
    assert world.value("sim.unpackInt32Table(sim.packInt32Table({1, 2, name = 'x'}))") == [1, 2]
    world.fails("sim.setObjectPosition(1, -1, {1, nil, 3})", "must be a table without gaps")


def test_a_0_and_nil_inside_a_table_are_packed_as_by_vrep(world: ScriptWorld) -> None:
    code = "local t = {nil, 2, nil, 4, [0] = 9} return sim.unpackInt32Table(sim.packInt32Table(t)), #t"
    assert world.lua(code) == [[0, 2, 0, 4], 4]
    world.fails("sim.packInt32Table({1, [1000] = 3})", "must be a table without gaps")
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


@pytest.mark.parametrize("scheme", [0, 1, 2])
def test_a_long_list_of_floats_is_packed_as_its_items_are(
    scheme: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    table = [0.1 * index for index in range(100)] + [float("inf"), -0.0]
    packed = pack_table(table, scheme)
    monkeypatch.setattr(cbor, "_FEW", len(table))
    assert pack_table(table, scheme) == packed
