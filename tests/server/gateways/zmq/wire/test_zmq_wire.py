"""Reading messages: values as clients' libraries write them."""

from __future__ import annotations

from typing import Any

import pytest
from zmq_world import cbor2

from simx_server.gateways.zmq.wire import Reader, WireError, language_of, read_request, uuid_of


@pytest.mark.parametrize(
    ("value", "read"),
    [
        (0, 0), (23, 23), (24, 24), (1 << 40, 1 << 40), (-1, -1), (-(1 << 33), -(1 << 33)),
        (1 << 70, 1 << 70), (-(1 << 70), -(1 << 70)), (0.5, 0.5), (True, True), (False, False), (None, None),
        ("text", b"text"), ("x" * 300, b"x" * 300), (b"\x00\xff", b"\x00\xff"), ([], []), ({}, {}),
        ([1, [2, "a"]], [1, [2, b"a"]]), ({"a": 1, 2: 3.0}, {"a": 1, 2: 3.0}), ([1.0] * 40, [1.0] * 40),
        ([0.1 * n for n in range(100)] + [7], [0.1 * n for n in range(100)] + [7]),
    ],
)  # fmt: skip
def test_values_arrive(value: Any, read: Any) -> None:
    assert Reader(cbor2.dumps(value)).whole() == read


def test_lengths_may_be_left_open() -> None:
    assert Reader(b"\x9f\x01\x7f\x61a\x61b\xff\xff").whole() == [1, b"ab"]
    assert Reader(b"\xbf\x61a\x01\xff").whole() == {"a": 1}
    assert Reader(b"\x9f" + b"\xfb\x3f\xf0" + bytes(6) + b"\xff").whole() == [1.0]


@pytest.mark.parametrize("damaged", [b"\x1c", b"\xf8\x20", b"\x7f\x41a\xff", b"\x00\x00", b"\xdf"])
def test_damaged_values_are_errors(damaged: bytes) -> None:
    with pytest.raises(WireError):
        Reader(damaged).whole()


def test_a_request_is_read_whatever_the_order_of_its_keys() -> None:
    fields = {"uuid": "u", "args": ["uuid", 1], "func": "sim.step", "lang": "c++", "ver": 2, "timeout": 600}
    payload = cbor2.dumps(fields)
    request = read_request(payload)
    assert (request.function, request.arguments) == ("sim.step", [b"uuid", 1])
    assert (uuid_of(payload), language_of(payload)) == ("u", "c++")


@pytest.mark.parametrize("is_first", [True, False])
def test_the_identity_is_found_on_either_side_of_long_arguments(is_first: bool) -> None:
    about = {"uuid": "me", "lang": "lua"}
    arguments = {"args": [b"x" * 5000]}
    payload = cbor2.dumps({**about, **arguments} if is_first else {**arguments, **about})
    assert (uuid_of(payload), language_of(payload)) == ("me", "lua")
