"""ZeroMQ's protocol on a connection: what peers send arrives whole, and the others are refused with a reason."""

from __future__ import annotations

import pytest

from simx_server.gateways.zmq.wire.zmtp import GREETING, MOST_AT_ONCE, READY, BadPeer, Incoming, framed

LONGEST = 1000


def command(name: bytes, content: bytes = b"") -> bytes:
    body = bytes((len(name),)) + name + content
    return bytes((4, len(body))) + body


def ready(kind: bytes) -> bytes:
    return command(
        b"READY", b"\x0bSocket-Type" + len(kind).to_bytes(4, "big") + kind + b"\x08Identity" + bytes(4)
    )


REQ = ready(b"REQ")
BEGIN = GREETING + REQ
SHORT, LONG = b"short", bytes(range(256)) * 3


def test_messages_arrive_wherever_the_bytes_are_divided() -> None:
    sent = BEGIN + framed(SHORT) + framed(LONG) + framed(b"") + framed(SHORT)
    for size in (1, 2, 7, 64, 100, len(sent)):
        incoming = Incoming(LONGEST)
        messages = [
            message
            for place in range(0, len(sent), size)
            for message in incoming.take(sent[place : place + size])
        ]
        assert messages == [SHORT, LONG, b"", SHORT]
        assert incoming.due == READY


def test_a_message_that_comes_alone_is_taken_at_once() -> None:
    incoming = Incoming(LONGEST)
    assert not incoming.is_ready
    assert incoming.take(BEGIN) == []
    assert incoming.is_ready
    assert incoming.take(framed(SHORT)) == [SHORT]
    assert incoming.take(framed(LONG)[:100]) == []
    assert incoming.missing == len(framed(LONG)) - 100
    assert incoming.take(framed(LONG)[100:]) == [LONG]


def test_a_ping_is_answered_with_what_it_brought() -> None:
    incoming = Incoming(LONGEST)
    incoming.take(BEGIN)
    incoming.due = b""
    assert incoming.take(command(b"PING", b"\x00\x64context") + command(b"SUBSCRIBE", b"x")) == []
    assert incoming.due == command(b"PONG", b"context")


@pytest.mark.parametrize(
    ("sent", "reason"),
    [
        (b"GET / HTTP/1.1\r\n", "does not speak ZeroMQ's protocol"),
        (b"\xff" + bytes(9), "does not speak ZeroMQ's protocol"),
        (b"\xff" + bytes(8) + b"\x7f\x01", "a version of ZeroMQ's protocol before 3"),
        (GREETING.replace(b"NULL\0", b"PLAIN"), "asks for PLAIN"),
        (GREETING + framed(SHORT), "a message before READY"),
        (GREETING + ready(b"SUB"), "no socket of kind REQ"),
        (GREETING + command(b"READY"), "no socket of kind REQ"),
        (GREETING + command(b"READY", b"\x0bSocket-Type\x00\x00\x00\xffREQ")[:-1] + b"X", "no socket of kind REQ"),
        (GREETING + command(b"READY", b"\xff"), "no socket of kind REQ"),
        (GREETING + command(b"ERROR", b"\x07go away"), "refuses the server: go away"),
        (BEGIN + b"\x00\x00", "other frames"),
        (BEGIN + b"\x01\x01x", "other frames"),
        (BEGIN + b"\x01\x00\x01\x01x", "other frames"),
        (BEGIN + b"\x01\x00\x02" + (LONGEST + 1).to_bytes(8, "big"), "at most 1000 are read"),
        (BEGIN + b"\x06" + (5000).to_bytes(8, "big"), "at most 4096 are read"),
        (BEGIN + command(b"PING", b"\0\0") * (MOST_AT_ONCE + 1), "without reading answers"),
    ],
)  # fmt: skip
def test_what_breaks_the_rules_is_refused_with_the_reason(sent: bytes, reason: str) -> None:
    with pytest.raises(BadPeer, match=reason):
        Incoming(LONGEST).take(sent)
