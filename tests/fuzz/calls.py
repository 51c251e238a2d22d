"""Calls that mean no good, and the server that must live through them.

`argument` and `call` draw what a table's command may be sent: mostly of the right kind, often with values at the edge
of it, now and then something else altogether. `Victim` is a whole server in this thread; `endure` sends it one message
and looks at everything that must hold afterwards.
"""

# ruff: noqa: E501 - long lines are lists of values and commands

from __future__ import annotations

import logging
import math
from pathlib import Path
from typing import Any

import msgpack
from hypothesis import strategies as st
from loopback import LoopbackTransport
from real_world import RealWorld

from simx_client.protocol.codec import decode_delivery
from simx_client.protocol.commands import ANSWERED, Command
from simx_client.protocol.messages import STATUS_OK, STATUS_REMOTE_ERROR, Reply

from .scene import SCENE

COMMANDS: tuple[Command, ...] = tuple({each.name: each for each in ANSWERED.values()}.values())

OBJECTS = (
    "base",
    "arm",
    "slider",
    "knob",
    "box",
    "hinge",
    "slide",
    "ball",
    "eye",
    "ray",
    "feel",
    "dummy",
    "lamp",
)
FLAGS = (0x400000, 0x1000000)

integers = st.one_of(
    st.integers(-3, 40),
    st.sampled_from([-1, -2, -4, -11, -12, -13, 2_000_000, 2_010_000, 2_020_000, 2_030_000, 4000, 3000]),
    st.sampled_from([2**31 - 1, -(2**31), 2**31, 2**32, 2**63, 2**64 - 1, -(2**63)]),
    st.builds(lambda handle, flag: handle + flag, st.integers(-1, 40), st.sampled_from(FLAGS)),
    st.integers(0, 5000),
    st.integers(-(2**31), 2**31 - 1),
)
numbers = st.one_of(
    st.floats(-10, 10),
    st.sampled_from(
        [0.0, -0.0, 1.0, math.nan, math.inf, -math.inf, 3.5e38, -3.4e38, 1e308, 1e-45, 5e-324, 1e30]
    ),
    st.floats(),
    integers,
)
_PATHS = (
    "..", ".", "/", "../x.xml", "a/../../x", "/etc/passwd", "/dev/zero", "/proc/self/mem", "C:\\x.xml", "C:x", "\\\\h\\s\\x.ttt",
    "victim.xml", "victim.ttt", "victim.ttm", "ui.ttb", "ui.toml", "x.zip", "x.mjb", "x.urdf", ".xml", "a\0b.xml", "\0", "con", "nul.xml",
    "a/" * 300, "a" * 256 + ".xml", "a/b/c.bin", "link", "x.stl", "~", "~/x.xml", "$HOME", "%s%n", "file:///etc/passwd", "-x",
)  # fmt: skip
_NAMES = (
    *OBJECTS, "", " ", "hinge#", "hinge#0", "hinge#99999999999999999999", "base@silentError", "@", "@alt0", "/base/arm", "/*", "//",
    "./arm", "../base", "/base[0]", "/base[-1]", "/base[99999999999999999999]", "[", "]", "[[", "*", "?", "\udc80\udcff", "\N{ROBOT FACE}",
    "A" * 5000, "\x1b[2J", "\r\n", "some", "hit", "far", "returns", "fails", "nothing", "sim.stopSimulation", "executeCode_function",
    "returns@base", "fails@base", "remoteApiCommandServer", "userInterface",
)  # fmt: skip
texts = st.one_of(st.sampled_from(_NAMES), st.sampled_from(_PATHS), st.text(max_size=20))
binaries = st.one_of(
    st.binary(max_size=64),
    st.sampled_from(
        [
            SCENE.encode(),
            b"<mujoco/>",
            b"<mujoco",
            b"\xff\xfe",
            b"PK\x03\x04",
            b"[[ui]]\nname='a'\n",
            bytes(192),
            bytes(9999),
        ]
    ),
)
_LENGTHS = (0, 1, 2, 3, 4, 6, 12, 13, 100)


def lists(items: st.SearchStrategy[Any], length: int | None = None) -> st.SearchStrategy[list[Any]]:
    """Mostly of the right length, sometimes long ones of equal items."""
    right = st.lists(items, min_size=length or 0, max_size=4 if length is None else length)
    wrong = st.sampled_from(_LENGTHS).flatmap(lambda n: st.lists(items, min_size=n, max_size=n))
    long = st.builds(lambda item, count: [item] * count, items, st.sampled_from([1000, 20_000]))
    return st.one_of(right, right, right, wrong, long)


def nested(depth: int) -> list[Any]:
    """Lists within lists."""
    value: list[Any] = []
    for _ in range(depth):
        value = [value]
    return value


anything = st.one_of(
    st.none(), st.booleans(), integers, numbers, texts, binaries, lists(st.one_of(integers, texts, numbers)),
    st.sampled_from([{}, {"a": 1}, nested(3), nested(400), nested(900), msgpack.Timestamp(0)]),
)  # fmt: skip

_KINDS: dict[str, st.SearchStrategy[Any]] = {
    "int": integers,
    "float": numbers,
    "bool": st.one_of(st.booleans(), integers),
    "text": texts,
    "bytes": binaries,
    "ints": lists(integers),
    "floats": lists(numbers),
    "texts": lists(texts),
    "packets": lists(lists(numbers)),
    "pixels": binaries,
    "depths": binaries,
    "vector3": lists(numbers, 3),
    "vector4": lists(numbers, 4),
    "matrix12": lists(numbers, 12),
    "optional_text": st.one_of(st.none(), texts),
    "optional_ints2": st.one_of(st.none(), lists(integers, 2)),
    "optional_ints12": st.one_of(st.none(), lists(integers, 12)),
    "optional_floats3": st.one_of(st.none(), lists(numbers, 3)),
    "optional_floats6": st.one_of(st.none(), lists(numbers, 6)),
}
_MEANT: dict[str, st.SearchStrategy[Any]] = {
    "int": st.integers(-2, 30),
    "float": st.floats(-2, 2, width=32),
    "bool": st.booleans(),
    "text": st.sampled_from(OBJECTS),
    "vector3": st.lists(st.floats(-2, 2, width=32), min_size=3, max_size=3),
    "ints": st.lists(st.integers(1, 20), max_size=4),
}
"""What a program that means well would send."""


def argument(kind: str) -> st.SearchStrategy[Any]:
    """Something for an argument of this kind."""
    hostile = _KINDS[kind]
    meant = _MEANT.get(kind, hostile)
    return st.one_of(meant, meant, hostile, hostile, hostile, hostile, anything)


def call(command: Command) -> st.SearchStrategy[tuple[str, list[Any]]]:
    """A name and arguments, seldom one too few or too many."""
    right = st.tuples(*(argument(each.kind.name) for each in command.arguments)).map(list)
    names = st.sampled_from(command.names)
    return st.one_of(*[st.tuples(names, right)] * 15, st.tuples(names, st.lists(anything, max_size=8)))


any_call = st.one_of(
    *(call(command) for command in COMMANDS),
    st.tuples(
        st.one_of(texts, st.sampled_from(["simxNo", "SimxStart", "simxStart"])),
        st.lists(anything, max_size=3),
    ),
)
operations = st.sampled_from([0, 0, 0, 0, 0, 0, 1, 1, 1, 2, 3, -1, 255, 2**63])
delays = st.sampled_from([0, 0, 0, 1, 100, -1, 2**31, 2**63, -(2**63)])


class Victim(logging.Handler):
    """A whole server in this thread, a client that attacks it, and one that minds its own business."""

    def __init__(self, folder: Path) -> None:
        super().__init__(logging.ERROR)
        self.workspace = folder / "workspace"
        self.workspace.mkdir()
        (self.workspace / "link").symlink_to("/etc")
        self.scene = self.workspace / "victim.xml"
        self.scene.write_text(SCENE)
        self.world = RealWorld(self.scene, workspace=self.workspace)
        self.failures: list[str] = []
        self.last_id = 0
        self.attacks = 0
        logging.getLogger("simx_server").addHandler(self)
        self._witness = LoopbackTransport(self.world.loop, name="witness")
        self._witness.greet(1.0)
        self.attacker = LoopbackTransport(self.world.loop, name="attacker")
        self.begin()

    def emit(self, record: logging.LogRecord) -> None:
        """An unforeseen error is logged with its trace."""
        if record.exc_info:
            self.failures.append(f"{record.getMessage()}: {record.exc_info[1]!r}")

    def close(self) -> None:
        logging.getLogger("simx_server").removeHandler(self)
        self.world.close()
        super().close()

    def begin(self) -> None:
        """The scene as it was, and an attacker that has just come."""
        simulation = self.world.simulation
        self.attacker.close()
        simulation.stop()
        self.scene.write_text(SCENE)
        simulation.load(self.scene)
        for each in (
            self.world.parts.signals.integers,
            self.world.parts.signals.floats,
            self.world.parts.signals.strings,
        ):
            each.clear()
        for console in self.world.parts.user_interface.consoles:
            self.world.parts.user_interface.consoles.close(console.handle)
        simulation.files.stored.clear()
        simulation.dynamics_enabled = True
        self.attacker = LoopbackTransport(self.world.loop, name="attacker")
        self.attacker.greet(1.0)
        self.failures.clear()

    def endure(self, calls: list[tuple[int, int, str, list[Any]]]) -> list[Reply]:
        """Send a message of (operation, delay, name, arguments), let passes go by, and check everything."""
        first = self.last_id + 1
        self.last_id += len(calls)
        items = [[first + index, *each] for index, each in enumerate(calls)]
        payload = msgpack.packb([1, 2, items], unicode_errors="surrogateescape")
        self.attacker.send(payload)
        replies = self._replies(self.attacker, {item[0] for item in items if item[1] != 2})
        for _ in range(2):
            self.world.loop.turn()
        self.attacker.newest()
        self.attacker.images()
        self.check(calls)
        return replies

    def send(self, payload: bytes) -> None:
        """Bytes that need be no message."""
        self.attacker.send(payload)
        self.world.loop.turn()
        self.check(payload)

    def _replies(self, link: LoopbackTransport, wanted: set[int]) -> list[Reply]:
        found: list[Reply] = []
        missing = set(wanted)
        for _ in range(200):
            if not missing:
                break
            payload = link.receive(0.05)
            if payload is not None:
                came = decode_delivery(payload).replies
                found += came
                missing -= {reply.call_id for reply in came}
            elif self.failures:
                break
        assert not self.failures, self.failures
        assert not missing, f"calls {missing} were not answered"
        for reply in found:
            assert reply.status in (STATUS_OK, STATUS_REMOTE_ERROR), reply
            assert reply.status == STATUS_OK or "internal error" not in "".join(map(str, reply.values)), reply
        return found

    def check(self, what: object) -> None:
        """The server lives, the other client is answered rightly, the tree is a tree, nothing unforeseen was logged."""
        assert not self.failures, (self.failures, what)
        scene = self.world.simulation.scene
        for handle, item in scene.objects.items():
            seen = {handle}
            parent = item.parent
            while parent != -1:
                assert parent in scene.objects, (handle, parent)
                assert parent not in seen, (handle, seen)
                seen.add(parent)
                parent = scene.objects[parent].parent
        self.last_id += 2
        number, name = self.last_id & 0x7FFF_FFFF, "of the witness"
        calls = [[self.last_id - 1, 0, 0, "simxSetIntegerSignal", [name, number]],
                 [self.last_id, 0, 0, "simxGetIntegerSignal", [name]]]  # fmt: skip
        self._witness.send(msgpack.packb([1, 2, calls]))
        answers = {
            reply.call_id: reply for reply in self._replies(self._witness, {self.last_id - 1, self.last_id})
        }
        assert answers[self.last_id].values == [number], (answers, what)
        assert self.world.loop.sessions[self._witness.client].is_stepping is False
