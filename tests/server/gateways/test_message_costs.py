"""Reading a message costs what it weighs, at every gateway: it is bounded, and grows no faster than the length."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from fuzz.costs import measuring
from fuzz.costs import messages as message_costs
from fuzz.costs.messages import GATEWAYS, Gateway, check, check_bound

pytestmark = pytest.mark.usefixtures("older_objects_set_aside")

F = b"\xfb\x3f\xf0" + bytes(6)
LIST = b"\xa2\x64args\x9a"
GET = b"GET / HTTP/1.1\r\n"
BROWSER = b"\x82\xa4type\xb3ViewerCameraMessage\xa4wxyz\xdd"
CALL = b"\x93\x01\x02\xdd\x00\x00\x00\x01\x95\x01\x00\x00\xa1a\xdd"

LARGEST = {
    "zmq: an identity that is a list, in many places": (
        "zmq", (b"\x64uuid\x9a\x00\x0f\xff\xff" + b"\x80" * 245_000) * 4,
    ),
    "zmq: numbers": ("zmq", LIST + (1 << 20).to_bytes(4, "big") + F * (1 << 20)),
    "zmq: lists without a length within each other, and numbers": ("zmq", b"\xa2\x64args" + b"\x9f" * 10 + F * 500_000),
    "zmq: numbers of two kinds in turn": ("zmq", LIST + (1 << 20).to_bytes(4, "big") + (F + b"\x01") * 300_000),
    "zmq: empty lists": ("zmq", LIST + (1 << 20).to_bytes(4, "big") + b"\x80" * (1 << 20)),
    "zmq: tags": ("zmq", LIST + b"\x00\x00\x00\x20" + b"\xc2" * 1_000_000),
    "zmq: pieces of a text": ("zmq", b"\xa2\x64args\x7f" + b"\x60" * 1_000_000),
    "zenoh: empty lists": ("zenoh", CALL + (1 << 20).to_bytes(4, "big") + b"\x90" * (1 << 20)),
    "zenoh: extension types": ("zenoh", CALL + (1 << 20).to_bytes(4, "big") + b"\xd4\x05a" * (1 << 20)),
    "zenoh: times": ("zenoh", CALL + (1 << 20).to_bytes(4, "big") + b"\xd6\xff\x00\x00\x00\x01" * (1 << 20)),
    "zenoh: texts that are none": ("zenoh", CALL + (1 << 20).to_bytes(4, "big") + b"\xa3\xff\xff\xff" * (1 << 20)),
    "gate: headers": ("gate", GET + b"a:\r\n" * 250_000),
    "gate: parameters": ("gate", (b"GET /?" + b"&a=" * 5400 + b" HTTP/1.1\r\n\r\n") * 60),
    "gate: an address of brackets": ("gate", (GET + b"Host: " + b"[:" * 8000 + b"\r\n\r\n") * 60),
    "class page: headers": ("class page", GET + b"a:\r\n" * 250_000),
    "class page: cookies": ("class page", (GET + b"Cookie: " + b"=;" * 8000 + b"\r\n\r\n") * 60),
    "class channel: lists within each other": ("class channel", b'{"reset":' + b"[" * 200_000),
    "web socket: empty frames": ("web socket", b"\x82\x80abcd" * 170_000),
    "web socket: pieces of a message": ("web socket", b"\x02\x81abcdx" + b"\x00\x81abcdx" * 150_000),
    "browser: empty lists": ("browser", BROWSER + (1 << 23).to_bytes(4, "big") + b"\x90" * (1 << 23)),
    "browser: times": ("browser", BROWSER + (1 << 20).to_bytes(4, "big") + b"\xd6\xff\x00\x00\x00\x01" * (1 << 20)),
    "browser: many lists": ("browser", BROWSER + bytes(2) + b"\x0f\xa0" + (b"\xdc\x0f\xff" + b"\x90" * 4095) * 4000),
    "ros2: transforms": ("ros2", b"\x00\x01\x00\x00\xff\xff\x01\x00" + bytes(16_000_000)),
}  # fmt: skip
"""Messages that took, or would take, the longest at their size."""


@pytest.mark.parametrize(("gateway", "data"), LARGEST.values(), ids=LARGEST)
def test_the_largest_messages_take_no_longer_than_promised(gateway: str, data: bytes) -> None:
    check_bound(GATEWAYS[gateway].read, data)


def test_four_times_as_much_takes_no_longer_than_four_times_as_long() -> None:
    """More of them by ``python tests/fuzz/run.py costs CASES``."""
    message_costs.run(10 * len(GATEWAYS), 1)


@pytest.mark.parametrize(("exponent", "is_found"), [(1, False), (2, True)])
def test_what_grows_with_the_square_is_found(
    monkeypatch: pytest.MonkeyPatch, exponent: int, is_found: bool
) -> None:
    spent = [0.0]
    monkeypatch.setattr(measuring, "time", SimpleNamespace(thread_time=lambda: spent[0]))

    def read(data: bytes) -> None:
        spent[0] += (1e-5 * len(data)) ** exponent

    assert bool(check(Gateway(read, (b"",), (b"a",)), lambda size: b"b" * size)) is is_found


def test_commands_in_pieces_that_do_not_end_are_dropped_at_once() -> None:
    """The oldest of very many is found without looking at those that have gone."""
    from simx_server.gateways.original.messages import Request
    from simx_server.gateways.original.splitting import PIECE_COST, Incoming

    kept = 3000
    incoming = Incoming(kept * (PIECE_COST + 1))

    def add(first: int) -> None:
        for number in range(first, first + kept):
            incoming.add(Request(1, 0, 0, b"%d" % number, b"a", False, 1000, 0))

    add(0)
    add(kept)
    assert incoming.add(Request(1, 0, 0, b"%d" % kept, b"b", False, 1000, 1)) is None
    assert len(incoming._partial) == kept - 1, "the last one has come out of order"
