"""Every command of the original's protocol, spoken byte by byte, over a socket."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest
from original_peer import Peer, floats, ints, peer, served, text

from simx_client.protocol.table.original_wire import RESERVED
from simx_server.gateways.original.translation import WIRES

pytestmark = pytest.mark.gl

SCENE = Path(__file__).parents[3] / "conformance" / "scene.xml"
NO_OBJECT = 777_776
IDENTITY = (1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0)
COLOURS = bytes(range(12))


class Said(NamedTuple):
    """One command and the payload of its reply, as a format of `struct`, or its start and whether more follows."""

    ident: str
    payload: bytes = b""
    reply: str = "<"
    fails: bool = False
    more: bool = False


FINE: dict[int, Said] = {
    0x0006: Said("", reply="<i", more=True),
    0x0009: Said("", floats(0.1) + b"\1" + COLOURS, "<i"),
    0x1001: Said("shoulder", reply="<f"),
    0x1002: Said("shoulder", floats(0.25)),
    0x1007: Said("1"),
    0x1008: Said("shoulder", floats(0.5)),
    0x100A: Said("shoulder", reply="<12f"),
    0x100B: Said("ball", floats(*IDENTITY)),
    0x100C: Said("elbow", floats(0.5)),
    0x100D: Said("shoulder", reply="<f"),
    0x100E: Said("shoulder", floats(20.0)),
    0x100F: Said("scale", reply="<B3f3f"),
    0x1012: Said("lid", reply="<i"),
    0x1014: Said("5"),
    0x1018: Said("crate", ints(-1), "<3f"),
    0x1019: Said("crate", ints(-1), "<3f"),
    0x101A: Said("crate", ints(-1) + floats(0, 0, 1)),
    0x101B: Said("crate", ints(-1) + floats(1, 2, 3)),
    0x101C: Said("cube", ints(-1) + b"\1"),
    0x101D: Said("0", reply="<3f"),
    0x101E: Said("0", floats(0, 0, -9)),
    0x101F: Said("3", reply="<i"),
    0x1020: Said("3", ints(1)),
    0x1021: Said("1", reply="<i"),
    0x1022: Said("0", ints(1)),
    0x1023: Said("1", reply="<f"),
    0x1024: Said("1", floats(0.05)),
    0x1025: Said("13", more=True),
    0x1028: Said("cube"),
    0x102A: Said("1", reply="<i", more=True),
    0x102E: Said("0", b"crate", "<2i"),
    0x102F: Said("0", b"crate"),
    0x1034: Said("crate", reply="<i"),
    0x1035: Said("crate", ints(0)),
    0x1036: Said("falling", reply="<6f"),
    0x1037: Said("crate"),
    0x1038: Said("shoulder", reply="<f"),
    0x1801: Said("crate", ints(-1) + floats(0, 0, 0, 1)),
    0x2007: Said("shoulder 2012", reply="<f"),
    0x2008: Said("cube 3003", reply="<i"),
    0x2009: Said("shoulder 2017", floats(0.5)),
    0x200A: Said("cube 3003", ints(0)),
    0x200B: Said("crate 0", reply="<i"),
    0x200C: Said("1 15", reply="<4i", more=True),
    0x200D: Said("crate -1", reply="<3f"),
    0x200E: Said("crate -1", reply="<3f"),
    0x200F: Said("crate target", reply="<i"),
    0x2010: Said("crate target", reply="<f"),
    0x2801: Said("crate -1", reply="<4f"),
    0x3001: Said("'crate'", reply="<i"),
    0x3004: Said("'stored.txt'", b"content"),
    0x3008: Said("'hello'"),
    0x3009: Said(
        "'console'", ints(10, 0, 98765, 0, 98765, 0) + floats(-10, 0, 0, -10, 0, 0), "<i"
    ),
    0x300A: Said("'bump'", reply="<i"),
    0x300B: Said("'clearance'", reply="<i"),
    0x300D: Said("'f'"),
    0x300E: Said("'i'"),
    0x300F: Said("'s'"),
    0x3013: Said("'f'", floats(0.5)),
    0x3014: Said("'i'", ints(7)),
    0x3015: Said("'s'", b"a\0b"),
    0x3016: Said("'s'", b"a\0b"),
    0x3018: Said("'s'", more=True),
    0x3019: Said("'boxes'", reply="<i"),
}  # fmt: skip
"""Commands that succeed on the conformance scene while it is stopped. The words of the identification data are names
of objects, numbers, and 'texts'."""

ELSEWHERE = {
    0x0001, 0x0002, 0x0003, 0x0004, 0x0005, 0x1003, 0x1009, 0x1004, 0x1005, 0x1006, 0x1010, 0x1011, 0x1015, 0x1016,
    0x1017, 0x1026, 0x1027, 0x1029, 0x102B, 0x102C, 0x102D, 0x2001, 0x2002, 0x2003, 0x2004, 0x2005, 0x2006, 0x3002,
    0x3003, 0x3005, 0x3006, 0x3007, 0x300C, 0x3010, 0x3011, 0x3012, 0x3017, 0x3401,
}  # fmt: skip
"""Commands of the other tests of this file: they need something first."""


@pytest.fixture
def client(tmp_path: Path) -> Iterator[Peer]:
    with served(SCENE, tmp_path) as server, peer(server.port) as client:
        yield client


@pytest.fixture(scope="module")
def stopped(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Peer]:
    """One client for the tests that depend on no other."""
    with served(SCENE, tmp_path_factory.mktemp("workspace")) as server, peer(server.port) as client:
        yield client


def ident(client: Peer, words: str) -> bytes:
    if words.startswith("'"):
        return text(words.strip("'"))
    return b"".join(
        ints(int(word) if word.lstrip("-").isdigit() else client.handle(word)) for word in words.split()
    )


def number(payload: bytes) -> int:
    return struct.unpack_from("<i", payload)[0]


def test_every_command_is_spoken_in_this_file() -> None:
    assert {id for id, _ in WIRES} == set(FINE) | ELSEWHERE
    assert not set(FINE) & ELSEWHERE


@pytest.mark.parametrize("id", sorted(FINE, key=lambda id: (id in (0x1028, 0x1037, 0x101C), id)), ids=hex)
def test_a_command_succeeds_with_a_payload_of_its_layout(stopped: Peer, id: int) -> None:
    said = FINE[id]
    payload = ints(stopped.handle("crate")) if said.payload == b"crate" else said.payload
    reply = stopped.call(id, ident(stopped, said.ident), payload)
    assert not reply.has_failed, stopped.call(0x0004).payload
    size = struct.calcsize(said.reply)
    assert len(reply.payload) >= size if said.more else len(reply.payload) == size


@pytest.mark.parametrize("id", [*RESERVED, 0x0FFF, 0x1700, 0x2400, 0x3100, 0x3900, 0x7FFF], ids=hex)
def test_a_number_that_no_command_has_is_an_error_with_its_own_payload(stopped: Peer, id: int) -> None:
    stopped.call(0x0004)
    sizes = {0: 0, 1: 4, 2: 8}
    some = text("name") if id >= 0x3000 else bytes(sizes[id >> 12])
    reply = stopped.call(id, some, b"payload")
    assert reply.has_failed
    assert reply.payload == b"payload"
    assert f"{id:#06x}".encode() in stopped.call(0x0004).payload


@pytest.mark.parametrize("id", sorted({id for id, _ in WIRES if id not in (1, 2, 3, 4, 5, 6)}), ids=hex)
def test_a_payload_that_ends_too_early_is_an_error_or_not_needed(stopped: Peer, id: int) -> None:
    sizes = {0: 0, 1: 4, 2: 8}
    some = (
        text("no such") * (2 if id == 0x3401 else 1)
        if id >= 0x3000
        else ints(*[NO_OBJECT] * (sizes[id >> 12] // 4))
    )
    stopped.call(id, (ints(1) if id == 0x3401 else b"") + some, b"\1")
    assert not stopped.call(0x1021, ints(1)).has_failed, "the client is served as before"


def test_values_that_are_set_come_back(client: Peer) -> None:
    shoulder, crate = client.handle("shoulder"), client.handle("crate")
    client.call(0x1002, ints(shoulder), floats(0.25))
    assert struct.unpack("<f", client.call(0x1001, ints(shoulder)).payload)[0] == pytest.approx(0.25)
    client.call(0x101B, ints(crate), ints(-1) + floats(1, 2, 3))
    assert struct.unpack("<3f", client.call(0x200E, ints(crate, -1)).payload) == (1, 2, 3)
    assert client.call(0x1019, ints(crate), ints(-1)).payload == floats(1, 2, 3), "of libraries before 3.3"
    client.call(0x1801, ints(crate), ints(-1) + floats(0, 0, 1, 0))
    assert struct.unpack("<4f", client.call(0x2801, ints(crate, -1)).payload)[2] == pytest.approx(1)
    client.call(0x102F, ints(0), ints(crate))
    assert client.call(0x0006).payload == ints(1, crate)


def test_signals_keep_every_byte(client: Peer) -> None:
    client.call(0x3013, text("f"), floats(0.5))
    assert client.call(0x3010, text("f")).payload == floats(0.5)
    client.call(0x3014, text("i"), ints(-7))
    assert client.call(0x3011, text("i")).payload == ints(-7)
    data = bytes(range(256)) * 20
    client.call(0x3015, text("s"), data)
    assert client.call(0x3012, text("s")).payload == data
    client.call(0x3016, text("s"), b"\0end", keeps_equal=True)
    assert client.call(0x3018, text("s")).payload == data + b"\0end"
    assert client.call(0x3018, text("s")).payload == b"", "nothing since, which is a success"
    client.call(0x3015, text("s"), b"once")
    assert client.call(0x3017, text("s")).payload == b"once"
    assert client.call(0x3017, text("s")).has_failed
    assert b"'s'" in client.call(0x0004).payload


def test_start_pause_stop_and_stepped_mode(client: Peer) -> None:
    assert client.call(0x0003).has_failed, "stepped mode is off"
    assert not client.call(0x0001).has_failed
    assert client.call(0x0003).has_failed, "the simulation is stopped"
    assert not client.call(0x1007, ints(0)).has_failed
    for step in range(1, 4):
        assert not client.call(0x0003).has_failed
        assert client.call(0x1021, ints(1)).time_ms == 50 * step
    client.call(0x1007, ints(1))
    assert client.call(0x0003).has_failed, "paused"
    client.call(0x1007, ints(2))
    assert client.call(0x1021, ints(1)).time_ms == 0
    assert not client.call(0x0002).has_failed
    assert client.call(0x1007, ints(3)).has_failed, "there is no such request"


def test_sensors_images_and_registered_objects(client: Peer) -> None:
    colour, distance = client.handle("colour"), client.handle("distance")
    client.call(0x0001)
    client.call(0x1007, ints(0))
    client.call(0x0003)
    rgb, grey = client.call(0x1004, ints(colour)), client.call(0x1003, ints(colour))
    assert rgb.payload[:8] == grey.payload[:8] == ints(8, 6)
    assert (len(rgb.payload), len(grey.payload)) == (8 + 8 * 6 * 3, 8 + 8 * 6)
    depth = client.call(0x1017, ints(distance)).payload
    assert depth[:8] == ints(8, 6)
    assert len(depth) == 8 + 4 * 8 * 6
    assert all(0 <= each <= 1 for each in struct.unpack("<48f", depth[8:]))
    state, packets, size = struct.unpack_from("<B2i", client.call(0x1011, ints(colour)).payload)
    assert (state, packets, size) == (0, 1, 15)
    seen = struct.unpack("<B3fi3f", client.call(0x1009, ints(client.handle("ahead"))).payload)
    assert seen[0] == 1
    assert seen[1:4] == pytest.approx((0, 0, 1), abs=1e-4)
    assert seen[4] == client.handle("target")
    assert not client.call(0x1006, ints(colour), bytes(8 * 6 * 3)).has_failed
    assert not client.call(0x1005, ints(colour), bytes(8 * 6)).has_failed
    assert client.call(0x1006, ints(colour), bytes(5)).has_failed, "not the size of the image"
    bump, clearance = (
        number(client.call(0x300A, text("bump")).payload),
        number(client.call(0x300B, text("clearance")).payload),
    )
    assert client.call(0x1026, ints(bump)).payload == ints(0)
    assert struct.unpack("<f", client.call(0x1027, ints(clearance)).payload)[0] > 1
    assert not client.call(0x1010, ints(client.handle("scale"))).has_failed


def test_a_script_gets_and_gives_four_lists(client: Peer) -> None:
    client.call(0x0001)
    client.call(0x1007, ints(0))
    client.call(0x0003)
    lists = ints(2, 1, 2, 3) + ints(1, -2) + floats(0.5) + text("one") + text("") + b"\0\1\2"
    reply = client.call(0x3401, ints(1) + text("robot") + text("echo"), lists, keeps_equal=True)
    assert not reply.has_failed, client.call(0x0004).payload
    assert reply.payload == lists
    assert client.call(0x3401, ints(1) + text("robot") + text("fails"), ints(0, 0, 0, 0)).has_failed
    assert b"on purpose" in client.call(0x0004).payload
    for counts in ((-1, 0, 0, 0), (0x7FFFFFFF, 0, 0, 0), (0, 0, 0x7FFFFFFF, 0), (0, 0, 1, 0), (0, 0, 0, 9)):
        assert client.call(0x3401, ints(1) + text("robot") + text("echo"), ints(*counts)).has_failed


def test_a_console_prints_and_is_cleared(client: Peer) -> None:
    window = ints(10, 0, 30, 40, 300, 200) + floats(1, 1, 1, 0, 0, 0)
    console = client.call(0x3009, text("title"), window).payload
    assert not client.call(0x1015, console, text("line\n"), keeps_equal=True).has_failed
    assert not client.call(0x1015, console, keeps_equal=True).has_failed, "without a text it is cleared"
    assert not client.call(0x1016, console, ints(0)).has_failed
    assert client.call(0x1016, ints(NO_OBJECT), ints(1)).has_failed


def test_a_dialog_is_shown_and_answered(client: Peer) -> None:
    client.call(0x1007, ints(0))
    content = text("Go on?") + ints(4) + text("") + floats(-10, 0, 0, 0, 0, 0) + floats(1, 1, 1, 0, 0, 0)
    reply = client.call(0x300C, text("Question"), content)
    assert not reply.has_failed, client.call(0x0004).payload
    dialog = reply.payload[:4]
    assert len(reply.payload) == 8
    assert len(client.call(0x102D, dialog).payload) == 4
    said = client.call(0x102C, dialog)
    assert said.has_failed or said.payload.endswith(b"\0")
    assert not client.call(0x102B, dialog).has_failed


PANEL = (
    '[[ui]]\nname = "panel"\n[[ui.element]]\nid = 1\nlabel = "Go"\n[[ui.element]]\nid = 2\nkind = "slider"\n'
)


def test_a_custom_ui_is_loaded_set_and_removed(client: Peer) -> None:
    assert not client.call(0x3004, text("panel.toml"), PANEL.encode()).has_failed
    loaded = client.call(0x3005, text("panel.toml")).payload
    assert loaded[:4] == ints(1)
    panel = loaded[4:]
    assert client.call(0x3007, text("panel")).payload == panel
    assert not client.call(0x2002, panel + ints(2), ints(250)).has_failed
    assert client.call(0x2001, panel + ints(2)).payload == ints(250)
    properties = client.call(0x2004, panel + ints(1)).payload
    assert not client.call(0x2005, panel + ints(1), properties).has_failed
    assert not client.call(0x2006, panel + ints(1), text("on") + text("off")).has_failed
    event = client.call(0x2003, panel)  # the original sends four bytes too few
    assert event.ident == panel + bytes(4)
    assert event.payload == ints(-1, 0, 0)
    assert not client.call(0x1029, panel).has_failed
    assert client.call(0x3007, text("panel")).has_failed


def test_files_travel_are_loaded_and_erased(client: Peer, tmp_path: Path) -> None:
    small = (
        b"<mujoco model='small'><worldbody><body name='brick'><geom size='0.1'/></body></worldbody></mujoco>"
    )
    assert not client.call(0x3004, text("small.xml"), small).has_failed
    assert (tmp_path / "small.xml").read_bytes() == small
    assert len(client.call(0x3003, text("small.xml")).payload) == 4
    assert not client.call(0x3002, text("small.xml")).has_failed
    assert client.handle("brick") >= 0
    assert not client.call(0x3006, text("small.xml")).has_failed
    assert not (tmp_path / "small.xml").exists()
    assert client.call(0x3004, text("../small.xml"), small).has_failed, "only the workspace"
    assert not client.call(0x0005).has_failed


def test_a_file_of_the_clients_side_never_lies_in_the_workspace(client: Peer, tmp_path: Path) -> None:
    name = text("REMOTE_API_TEMPFILE_0815.xml")
    small = (
        b"<mujoco model='small'><worldbody><body name='brick'><geom size='0.1'/></body></worldbody></mujoco>"
    )
    assert client.call(0x3002, name).has_failed, "nothing was sent"
    assert not client.call(0x3004, name, small).has_failed
    assert list(tmp_path.iterdir()) == []
    assert not client.call(0x3002, name).has_failed
    assert not client.call(0x3006, name).has_failed
    assert client.handle("brick") >= 0
