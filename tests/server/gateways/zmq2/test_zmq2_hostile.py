"""Messages that no correct client of API 2 sends: each is answered or cut, and the server serves others on."""

from __future__ import annotations

from typing import Any

import pytest
from zmq2_world import OBJECT, SCENE_HANDLE, WireClient, Zmq2World, cbor2

from simx_server.gateways.zmq import connection
from simx_server.gateways.zmq.wire.messages import WireError
from simx_server.gateways.zmq2.messages import Message, read_message
from simx_server.gateways.zmq2.work import ModelWork
from simx_server.sim_api.object_model.values import Color, Matrix, Pose, Quaternion, Ref

TAG = cbor2.CBORTag


def call_of(argument: Any) -> bytes:
    return cbor2.dumps(
        {"msg": "call", "id": 1, "target": SCENE_HANDLE, "func": "getObject", "args": [argument]}
    )


@pytest.mark.parametrize(
    ("value", "reason"),
    [
        (TAG(40, [[1 << 31, 1 << 31], []]), "R . C numbers"),
        (TAG(40, [[2, 2], [1.0, 2.0]]), "R . C numbers"),
        (TAG(40, [[-1, -4], [1.0] * 4]), "R . C numbers"),
        (TAG(40, [[1, 1], [float("nan")]]), "R . C numbers"),
        (TAG(40, "text"), "list of its sizes"),
        (TAG(OBJECT, TAG(OBJECT, 1)), "another tag in it"),
        (TAG(OBJECT, "one"), "another value"),
        (TAG(OBJECT, 1 << 40), "another value"),
        (TAG(4294980500, [1.0] * 6), "another value"),
        (TAG(4294980000, [float("inf")] * 4), "another value"),
        (TAG(4294980000, [(1 << 1024) - 1] * 4), "another value"),
        (TAG(40, [[1, 1], [(1 << 1024) - 1]]), "R . C numbers"),
        (TAG(4294970000, b"12345"), "another value"),
        (TAG(4294999997, "x" * 300), "another value"),
        (TAG(86, b"1234567"), "no array of numbers"),
        (TAG(86, 7), "holds bytes"),
        (TAG(4294999996, 1), "has no meaning here"),
        (TAG(258, [1, 2]), "has no meaning here"),
    ],
)
def test_values_that_break_the_rules_are_refused_with_the_reason(value: Any, reason: str) -> None:
    with pytest.raises(WireError, match=reason):
        read_message(call_of(value))


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (TAG(OBJECT, 16), Ref(16)),
        (TAG(OBJECT, None), Ref(-1)),
        (TAG(4294999998, [16, -1]), [Ref(16), Ref(-1)]),
        (TAG(40, [[2, 1], [1, 2]]), Matrix(2, 1, [1.0, 2.0])),
        (TAG(40, [[2, 1], TAG(85, bytes(8))]), Matrix(2, 1, [0.0, 0.0])),
        (TAG(69, b"\1\0\2\0"), [1, 2]),
        (TAG(79, b"\xff" * 8), [-1]),
        (TAG(4294980500, [1, 2, 3, 0, 0, 0, 1]), Pose([1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0])),
        (TAG(4294980000, [0, 0, 0, 1]), Quaternion([0.0, 0.0, 0.0, 1.0])),
        (TAG(4294970000, "\x01\x02\x03\x04"), Color(b"\1\2\3\4")),
        (TAG(4294970000, b"\1\2\3"), Color(b"\1\2\3\xff")),
        (TAG(4294970000, [1.0, 0.0, 0.0]), Color(b"\xff\0\0\xff")),
        ("text", "text"),
        (b"bytes", b"bytes"),
        (1 << 70, 1 << 70),
    ],
)
def test_values_are_read_with_their_types(value: Any, expected: Any) -> None:
    assert read_message(call_of(value)).arguments == (expected,)


def test_tags_within_tags_do_not_exhaust_the_stack() -> None:
    for start in (b"\xd8\x28", b"\xdb\x00\x00\x00\x01\x00\x00\x7f\xbf", b"\xd8\x28\x82"):
        body = cbor2.dumps("args") + b"\x81" + start * 5000 + b"\x00"
        with pytest.raises(WireError):
            read_message(b"\xa4" + cbor2.dumps("msg") + cbor2.dumps("call") + cbor2.dumps("id") + b"\x01"
                         + cbor2.dumps("func") + cbor2.dumps("f") + body)  # fmt: skip


def test_a_name_among_the_arguments_is_not_taken_for_the_function() -> None:
    message = {
        "msg": "call",
        "args": ["dfuncgisValid"],
        "func": "simulation.stop",
        "id": 1,
        "target": SCENE_HANDLE,
    }
    work = ModelWork(1, cbor2.dumps(message), lambda *_: None)
    assert work.waits_for_scripts()
    assert work.stops()


def test_results_need_not_be_lists() -> None:
    for given, values in (([1, 2], (1, 2)), ({}, ()), (None, ()), (True, (True,))):
        message = read_message(cbor2.dumps({"msg": "result", "id": 3, "error": False, "result": given}))
        assert message == Message("result", 3, arguments=values)


@pytest.mark.parametrize(
    ("message", "text"),
    [
        ({"msg": "call", "id": 1, "target": "box", "func": "getName", "args": []}, "target must be"),
        ({"msg": "call", "id": 1, "target": SCENE_HANDLE, "func": "x" * 300, "args": []}, "at most 200"),
        (
            {"msg": "call", "id": 1, "target": SCENE_HANDLE, "func": "getObject", "args": 5},
            "args must be a list",
        ),
        ({"msg": "registerCallback", "id": 1, "func": 7}, "func must be"),
    ],
)
def test_an_unreadable_request_is_answered_by_its_number(client: WireClient, message: Any, text: str) -> None:
    client.send(message)
    answer = client.receive()
    assert (answer["id"], answer["error"]) == (1, True)
    assert text in answer["result"]
    assert client.call(SCENE_HANDLE, "getStringProperty", "type") == ["scene"]


def test_nonsense_leaves_others_alone(server: Zmq2World) -> None:
    for payload in (
        b"",
        b"\xff",
        b"\xa1",
        bytes(64),
        cbor2.dumps([1, 2]),
        cbor2.dumps({"msg": "shout", "id": 1}),
    ):
        peer = server.wire()
        peer.send(payload or b"\x00")
        peer.send({"msg": "result", "id": 77, "error": False, "result": []})
    assert server.wire().call(SCENE_HANDLE, "getStringProperty", "type") == ["scene"]


def test_a_client_that_sends_on_without_reading_is_disconnected(server: Zmq2World) -> None:
    flood, other = server.wire(), server.wire()
    other.call(SCENE_HANDLE, "getStringProperty", "type")
    flood.register("sysCall_sensing", lambda: None, is_global=True)
    before = server.on_server(lambda: len(server.gateway._peers))
    for _ in range(200):
        flood.send({"msg": "call", "id": 5, "target": -4, "func": "wait", "args": [5.0]})
    assert server.wait_until(
        lambda: len(server.gateway._peers) < before or not server.gateway._clients._clients
    )
    assert other.call(SCENE_HANDLE, "getStringProperty", "type") == ["scene"]


def test_results_that_nobody_has_asked_for_are_counted_until_they_are_read(
    server: Zmq2World, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A function of another client holds the server, which reads on meanwhile: they must not pile up."""
    monkeypatch.setattr(connection, "SILENCE", 5.0)
    before = server.on_server(lambda: set(server.gateway._peers))
    flood = server.wire()
    flood.call(SCENE_HANDLE, "getStringProperty", "type")
    (peer,) = server.on_server(lambda: set(server.gateway._peers) - before)
    holding = server.wire()
    holding.register("sysCall_sensing", lambda: None, is_global=True)
    holding.call(SCENE_HANDLE, "simulation.start")
    owed = holding.receive()
    for _ in range(100):
        flood.send({"msg": "result", "id": 77, "error": False, "result": []})
    assert server.wait_until(lambda: peer.is_gone)
    holding.serve(owed)
