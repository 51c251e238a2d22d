"""Messages that take long to read: pieces of each gateway's protocol, a random few of them repeated.

The promise: a message takes as long as its bytes and values, at most `costs.BUDGET` and `PER_BYTE`; four times as much
takes four times as long.
"""

# ruff: noqa: E501 - long lines are lists of pieces

from __future__ import annotations

import contextlib
import random
import struct
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import msgspec

from simx_client.protocol.codec import CodecError, decode_batch, decode_greeting
from simx_client.protocol.lane.frames import BadFrame, Frames
from simx_server.browsers import is_of_another_page
from simx_server.classroom import channel
from simx_server.classroom.page.http import BadRequest, read_head
from simx_server.gateways.original import messages as original
from simx_server.gateways.original.containers import Containers
from simx_server.gateways.original.packets import HEAD, BadPeer, read_message
from simx_server.gateways.zmq.wire.messages import WireError, language_of, read_request, uuid_of
from simx_server.gateways.zmq.wire.zmtp import GREETING, READY, Incoming
from simx_server.gateways.zmq.wire.zmtp import BadPeer as BadZmqPeer
from simx_server.limits import Limits
from simx_server.ros2_messages import BY_NAME, MessageError
from simx_server.viewer.browser_messages import BadMessage
from simx_server.viewer.browser_messages import check as check_browser_message
from simx_server.viewer.page.gate import MOST_HEAD, Refused, Rules
from simx_server.viewer.page.websocket_size import BadFrame as BadWebFrame
from simx_server.viewer.page.websocket_size import MessageSize

from .measuring import BUDGET, SLACK, is_within, least_seconds

PER_BYTE = 20e-9
"""Seconds of processor time for a byte of a message."""

GROWTH, NOISE = 10, 0.005
"""How much longer four times as much may take, and seconds that count as nothing. What grows with the square takes
sixteen times as long.
"""

SMALL = 16_000
"""Bytes of the smaller of two messages."""

_LIMITS = Limits()


class Gateway(NamedTuple):
    """A gateway, as its decoder sees it."""

    read: Callable[[bytes], object]
    heads: tuple[bytes, ...]
    pieces: tuple[bytes, ...]
    tails: tuple[bytes, ...] = (b"",)


def _zmq(data: bytes) -> None:
    uuid_of(data)
    language_of(data)
    with contextlib.suppress(WireError):
        read_request(data)


def _batch(data: bytes) -> None:
    for decode in (decode_batch, decode_greeting):
        with contextlib.suppress(CodecError):
            decode(data)


def _original(data: bytes) -> None:
    containers = Containers(lambda: _LIMITS)
    with contextlib.suppress(original.Malformed):
        containers.receive(original.read(data, _LIMITS.calls))
        containers.take_batch()


def _packets(data: bytes) -> None:
    arrived = bytearray(data)

    def receive(size: int) -> bytes:
        if len(arrived) < size:
            raise BadPeer("it has left")
        taken = bytes(arrived[:size])
        del arrived[:size]
        return taken

    with contextlib.suppress(BadPeer):
        read_message(receive, _LIMITS.message)


def _frames(data: bytes) -> None:
    frames = Frames()
    with contextlib.suppress(BadFrame):
        for start in range(0, len(data), 1000):
            frames.add(data[start : start + 1000])


def _zmtp(data: bytes) -> None:
    incoming = Incoming(64 << 20)
    with contextlib.suppress(BadZmqPeer):
        for start in range(0, len(data), 1000):
            incoming.take(data[start : start + 1000])


def _ros2(data: bytes) -> None:
    for name in (
        "tf2_msgs/msg/TFMessage",
        "diagnostic_msgs/msg/DiagnosticArray",
        "sensor_msgs/msg/PointCloud2",
    ):
        with contextlib.suppress(MessageError):
            BY_NAME[name].decode(data)


def _heads(data: bytes) -> Iterator[bytes]:
    """Yield heads of requests, of which none is longer than the pages read."""
    for head in data.split(b"\r\n\r\n"):
        for start in range(0, max(1, len(head)), MOST_HEAD):
            yield head[start : start + MOST_HEAD] + b"\r\n\r\n"


def _gate(data: bytes) -> None:
    for head in _heads(data):
        for token in (None, "token"):
            with contextlib.suppress(Refused):
                Rules(token, "cookie").checked(head)


def _class_page(data: bytes) -> None:
    for head in _heads(data):
        with contextlib.suppress(BadRequest):
            request = read_head(head)
            request.cookie("seat")
            is_of_another_page(request.headers)


def _channel(data: bytes) -> None:
    with contextlib.suppress(ValueError):
        channel.unpacked(data)


def _web_socket(data: bytes) -> None:
    size = MessageSize()
    with contextlib.suppress(BadWebFrame):
        for start in range(0, len(data), 65_536):
            size.add(data[start : start + 65_536])


def _browser(data: bytes) -> None:
    with contextlib.suppress(BadMessage, msgspec.DecodeError, RecursionError):
        check_browser_message(data)
        msgspec.msgpack.decode(data)


_FLOAT = b"\xfb" + struct.pack(">d", 0.1)


def _command(number: int, body: bytes, full: int = 0) -> bytes:
    size = original.COMMAND.size + len(body)
    return original.COMMAND.pack(size, full or size, 0, 0, number, 0, 0, 0, 0) + body


_LINES = (
    b"GET / HTTP/1.1\r\nHost: localhost\r\n", b"GET /?", b"GET /?token=", b"GET / HTTP/1.1\r\nHost: localhost\r\nCookie: ",
    b"GET / HTTP/1.1\r\nHost: ", b"GET / HTTP/1.1\r\nHost: a\r\nOrigin: http://", b"",
)  # fmt: skip
_PARTS_OF_HEADS = (
    b"a:\r\n", b"a", b" ", b"\r\n", b"a=b;", b"cookie=;", b"&a=", b"token=a&", b"%41", b"/", b":", b"[", b"]", b"@", b"1", b"0.", b"\xff",
    b"\t", b"Connection: close\r\n", b"Content-Length: 1\r\n", b" HTTP/1.1\r\n", b"\r\n\r\nGET / HTTP/1.1\r\nHost: localhost\r\n",
)  # fmt: skip

GATEWAYS: Mapping[str, Gateway] = {
    "zmq": Gateway(
        _zmq,
        (b"\xa3\x64args\x9f", b"\xa3\x64args\x9a\x00\x0f\x00\x00", b"\xa3\x64args" + b"\x98\x10" * 16, b""),
        (
            b"\x80", b"\xa0", b"\x9f", b"\xbf", b"\xff", b"\x98\x10", b"\x81", _FLOAT, 16 * _FLOAT, 15 * _FLOAT + b"\x01", b"\x01",
            b"\x39\x01\x00", b"\x61a", b"\x7f\x60", b"\x60", b"\xc2\x41\x01", b"\xc2", b"\xf9\x3c\x00", b"\xa1\x61a\x01",
            b"\x9b" + bytes(8), b"\x64uuid", b"\x64uuid\x9a\x00\x0f\xff\xff", b"\x64uuid\x7f\x60", b"\x64lang\x63abc", b"\x5b" + b"\xff" * 8,
        ),
        (b"", b"\xff\x64func\x63abc\x64uuid\x63abc"),
    ),
    "zenoh": Gateway(
        _batch,
        (b"\x93\x01\x02\xdd\x00\x00\x00\x01\x95\x01\x00\x00\xa1a\xdd\x00\x01\x00\x00", b"\x93\x01\x02\xdd\x00\x00\x20\x00", b"\xdd\x00\x0f\x00\x00"),
        (
            b"\x90", b"\x80", b"\x91", b"\x01", b"\xcb" + bytes(8), b"\xa1a", b"\xa3\xff\xff\xff", b"\xd4\x05a", b"\xd6\xff" + bytes(4),
            b"\xc4\x01a", b"\x81\xa1a\x01", b"\x95\x01\x00\x00\xa1a\x90", b"\xdd\x7f\xff\xff\xff", b"\xdb\x7f\xff\xff\xff",
        ),
    ),
    "original": Gateway(
        _original,
        (original.HEADER.pack(0, original.VERSION, 1, 0, 0, 0, 0),),
        (
            _command(1, b""), _command(1 | original.BLOCKING, b""), _command(0x3000 | original.STREAMING, b"s\0"),
            _command(0x3000, b"s\0a", 1000), _command(0x3400, b"a\0b\0" + struct.pack("<4i", 0, 0, 9, 0) + bytes(9)),
            _command(0x3000 | original.DISCONTINUE, b"s\0"), _command(2, b"\xff" * 100),
        ),
    ),
    "packets": Gateway(_packets, tuple(HEAD.pack(1, 1, n) + b"a" for n in range(3)), (HEAD.pack(1, 1, 1) + b"a", b"\0", b"\1\0\1\0")),
    "local": Gateway(_frames, (b"",), (bytes(5), b"\x01\0\0\0\0a", b"\x04\0\0\0\x01abcd", b"\xff\xff\xff\0\0")),
    "zmtp": Gateway(_zmtp, (GREETING + READY,), (b"\x01\0\0\1a", b"\x04\x08\x04PING\0\0a", b"\x02" + b"\0\0\0\0\0\xff\xff\xff", b"a")),
    "ros2": Gateway(
        _ros2,
        tuple(b"\0\1\0\0" + struct.pack("<I", n) for n in (100, 1000, 10_000)),
        (bytes(4), bytes(16), b"\1\0\0\0\0\0\0\0", b"\2\0\0\0a\0\0\0", b"\0\1\0\0"),
    ),
    "gate": Gateway(_gate, _LINES, _PARTS_OF_HEADS, (b"", b"\r\n\r\n")),
    "class page": Gateway(_class_page, _LINES, _PARTS_OF_HEADS, (b"", b"\r\n\r\n")),
    "class channel": Gateway(
        _channel, (b"", b'{"a":', b'{"reset":['), (b"[", b'{"a":', b'"', b"\\", b"1", b"0.1e9,", b"{},", b'"a":1,', b"\\ud800", b" "),
    ),
    "web socket": Gateway(
        _web_socket,
        (b"", b"\x02\x85abcda"),
        (
            b"\x82\0", b"\x02\0", b"\0\0", b"\x89\0", b"\x82\x81abcdx", b"\x00\x81abcdx", b"\x89\x81abcdx", b"\x82\x7e\0\1a",
            b"\x82\x7f" + bytes(7) + b"\1a", b"\xc2\0", b"\x82",
        ),
    ),
    "browser": Gateway(
        _browser,
        (b"", b"\x82\xa4type\xa1a\xa1a", b"\x82\xa4type\xa1a\xa1a\xdd\0\0\x0f\0", b"\xdd\0\x0f\0\0", b"\x81\xa1a\xdf\0\0\0\xff"),
        (
            b"\x90", b"\x80", b"\x91", b"\x81", b"\x01", b"\xcb" + bytes(8), b"\xa1a", b"\xc4\x01a", b"\xd4\x05a", b"\xd6\xff" + bytes(4),
            b"\xc6\x00\x00\x40\x00", b"\xdd\x7f\xff\xff\xff", b"\xdb\x7f\xff\xff\xff", b"\xc1",
        ),
    ),
}  # fmt: skip


def message(gateway: Gateway, chance: random.Random) -> Callable[[int], bytes]:
    """Return a function that makes a message of about this many bytes."""
    head, tail = chance.choice(gateway.heads), chance.choice(gateway.tails)
    unit = b"".join(chance.choices(gateway.pieces, k=chance.choice((1, 1, 2, 3))))
    return lambda size: head + unit * (size // len(unit)) + tail


def check(gateway: Gateway, made: Callable[[int], bytes]) -> str:
    """Return what is wrong with the cost of a message; empty if nothing is."""
    small, large = made(SMALL), made(4 * SMALL)
    base = least_seconds(lambda: gateway.read(small), NOISE / 2)
    allowed = GROWTH * base + NOISE
    taken = least_seconds(lambda: gateway.read(large), allowed)
    if taken > allowed:
        return (
            f"{len(small)} bytes take {base:.4f} s, and {len(large)} bytes {taken:.4f} s: {large[:60].hex()}"
        )
    return ""


def check_bound(read: Callable[[bytes], object], data: bytes) -> None:
    """Raise AssertionError if a large message takes longer than promised."""
    allowed = SLACK * (BUDGET + PER_BYTE * len(data))
    assert is_within(least_seconds(lambda: read(data), allowed), allowed)


def run(cases: int, seed: int, _folder: Path | None = None) -> str:
    """Read this many pairs of messages.

    Returns:
        The counts, for people.

    Raises:
        AssertionError: one takes longer than four times as long for four times as many bytes.
    """
    chance = random.Random(seed)
    seen: dict[str, Any] = dict.fromkeys(GATEWAYS, 0)
    for number in range(cases):
        name = list(GATEWAYS)[number % len(GATEWAYS)]
        problem = check(GATEWAYS[name], message(GATEWAYS[name], chance))
        assert not problem, f"{name}: {problem}"
        seen[name] += 1
    return ", ".join(f"{count} {name}" for name, count in seen.items())
