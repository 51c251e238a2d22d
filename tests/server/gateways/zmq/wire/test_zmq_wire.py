"""Reading messages: values as clients' libraries write them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from zmq_world import cbor2

from simx_server.gateways.zmq.wire.messages import Reader, WireError, language_of, read_request, uuid_of
from simx_server.gateways.zmq.wire.requests import Requests


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


_ABOUT = {"uuid": "7d2c5a7e-1111", "ver": 2, "lang": "python"}
_CALL = cbor2.dumps({"func": "sim.getObjectPosition", "args": [24, -1], **_ABOUT})


def _outcome(read: Callable[[bytes], Any], payload: bytes) -> Any:
    try:
        return read(payload)
    except WireError as problem:
        return str(problem)


@pytest.mark.parametrize(
    "payload",
    [
        _CALL,
        cbor2.dumps({"func": "sim.step", "args": [], **_ABOUT}),
        cbor2.dumps({"func": "f", "args": [1.5, [True, {"a": b"uuid"}]], **_ABOUT}),
        cbor2.dumps({"func": "f", "args": {}, **_ABOUT}),
        cbor2.dumps({"func": "", "args": [], **_ABOUT, "eval": "sim.step()"}),
        cbor2.dumps({"func": "f" * 300, "args": [], **_ABOUT}),
        cbor2.dumps({"func": 7, "args": [], **_ABOUT}),
        cbor2.dumps({"func": "f", "args": 7, **_ABOUT}),
        cbor2.dumps({**_ABOUT, "args": [1], "func": "f"}),
        cbor2.dumps({"func": "f", "args": [_CALL], **_ABOUT}),
        cbor2.dumps({"func": "f", "args": [2], **_ABOUT, "lang": "c++"}),
        cbor2.dumps({"func": "f", "args": ["x" * 5000], **_ABOUT}),
        cbor2.dumps({"func": "f", "args": [3], "other": 1, **_ABOUT}),
        _CALL[:-1],
        _CALL[:30] + _CALL[-30:],
        b"\xa6" + _CALL[1:],
        b"\xa7" + _CALL[1:] + cbor2.dumps("func") + cbor2.dumps("g") + cbor2.dumps("args") + cbor2.dumps([5]),
        b"\xbf" + _CALL[1:] + b"\xff",
        b"\xa5\x64func\x61f\x64args\x81\x44abc" + _CALL[-60:],
        b"",
    ],
)  # fmt: skip
def test_a_message_is_read_the_same_whatever_came_before_it(payload: bytes) -> None:
    alone = _outcome(read_request, payload)
    requests = Requests()
    for _ in range(2):
        for before in (_CALL, payload):
            assert requests.read(_CALL) == read_request(_CALL)
            assert _outcome(requests.read, before) == _outcome(read_request, before)
            assert _outcome(requests.read, payload) == alone


def test_a_connection_does_not_read_the_fields_again_that_each_message_has() -> None:
    read = list[int]()

    class Counting(Requests):
        def _learn(self, payload: bytes) -> None:
            read.append(len(payload))
            super()._learn(payload)

    requests = Counting()
    for number in range(5):
        payload = cbor2.dumps({"func": "sim.getObjectPosition", "args": [number], **_ABOUT})
        assert requests.read(payload).arguments == [number]
    assert len(read) == 1
