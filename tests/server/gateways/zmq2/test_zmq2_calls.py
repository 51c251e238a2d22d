"""Calls over the wire of API 2: the session of the wire's description, values, errors, stepping."""

from __future__ import annotations

import struct
from typing import Any

import pytest
from zmq2_world import (
    APP,
    COLOR,
    MATRIX,
    OBJECT,
    POSE,
    SCENE_HANDLE,
    SELF,
    Refused,
    WireClient,
    Zmq2World,
    cbor2,
    zmq,
)


def test_the_first_connection_may_stay_and_a_second_one_works_too(server: Zmq2World) -> None:
    first = server.wire()
    first.send(
        bytes.fromhex("a5636d73676463616c6c66746172676574f66466756e6367676574506f7274646172677380626964 01")
    )
    assert first.receive() == {"msg": "result", "id": 1, "error": False, "result": [server.port]}
    second = server.wire()
    assert second.call(SCENE_HANDLE, "getStringProperty", "type") == ["scene"]
    assert first.call(SCENE_HANDLE, "getStringProperty", "type") == ["scene"]
    third = server.wire()
    assert third.call(None, "getPort", "some-id") == [server.port]
    assert server.on_server(lambda: len(server.gateway._clients._clients)) == 2


def test_a_session_as_the_description_shows_it(client: WireClient) -> None:
    assert client.call(SCENE_HANDLE, "getStringArrayProperty", "metaInfo.namespaces") == [
        ["customData", "signal"]
    ]
    assert client.call(SCENE_HANDLE, "getPropertyInfo", "getObject", {"noError": True})[0] == 240
    box = client.at("/box")
    assert client.call(box, "getPropertyInfo", "position", {"noError": True})[:1] == [5]
    (position,) = client.call(box, "getProperty", "position", {"type": 5})
    assert (position.tag, [list(each) for each in position.value]) == (MATRIX, [[3, 1], [1.0, 0.0, 0.5]])
    with pytest.raises(Refused, match="property is unknown"):
        client.call(box, "getProperty", "nonsense", {})
    assert client.call(box, "getPropertyInfo", "bla", {"noError": True}) == [None, None, None]
    assert client.call(SELF, "getLongProperty", "handle")[0] >= 4_000_003
    assert client.call(APP, "getStringProperty", "type") == ["app"]
    assert client.call(APP, "getIntProperty", "productVersionNb") == [41000]


def test_values_travel_with_their_tags(client: WireClient) -> None:
    box, tag = client.at("/box"), cbor2.CBORTag
    (pose,) = client.call(box, "getPose")
    assert (pose.tag, len(pose.value)) == (POSE, 7)
    packed = tag(86, _doubles(1, 0, 0.5))
    for given in ([1.0, 0.0, 0.5], tag(MATRIX, [[3, 1], [1.0, 0.0, 0.5]]), tag(MATRIX, [[3, 1], packed])):
        assert client.call(box, "setProperty", "position", given, {"type": 5}) == []
        assert list(client.get(box, "position").value[1]) == [1.0, 0.0, 0.5]
    for given in (tag(COLOR, b"\xff\x00\x00\xff"), [1.0, 0.0, 0.0], tag(COLOR, [255, 0, 0, 255])):
        client.call(box, "setProperty", "color.diffuse", given, {})
        color = client.get(box, "color.diffuse")
        assert (color.tag, color.value) == (COLOR, b"\xff\x00\x00\xff")
    client.call(box, "setProperty", "customData.friend", tag(OBJECT, box), {})
    friend = client.get(box, "customData.friend")
    assert (friend.tag, friend.value) == (OBJECT, box)
    assert client.get(box, "parent").value == -1
    for name, value in (("text", "grün"), ("bytes", b"\x00\xff"), ("map", {"a": [1, "b"]}), ("flag", True)):
        client.call(box, "setProperty", f"customData.{name}", value, {})
        assert client.get(box, f"customData.{name}") == value


def _doubles(*numbers: float) -> bytes:
    return struct.pack(f"<{len(numbers)}d", *numbers)


def test_an_empty_table_of_lua_stands_for_a_list(client: WireClient) -> None:
    assert client.request({"msg": "call", "target": SCENE_HANDLE, "func": "getObjects", "args": {}})[0]
    assert client.call(SCENE_HANDLE, "announceChange") == []


def test_errors_name_what_is_valid(client: WireClient) -> None:
    for target, name, arguments, text in (
        (SCENE_HANDLE, "getObjct", [], "did you mean .getObject."),
        (999, "getProperty", ["name"], "target does not exist"),
        (None, "simulation.start", [], "no such function: simulation.start"),
        (SCENE_HANDLE, "getObject", [5.5, 7], "argument"),
        (client.at("/box"), "getProperty", ["positon"], "did you mean"),
        (APP, "scheduleExecution", [1, 2], "works only in a script"),
    ):
        with pytest.raises(Refused, match=text):
            client.call(target, name, *arguments)
    assert client.call(999, "isValid") == [False]


def test_the_simulation_is_started_polled_and_stopped(client: WireClient) -> None:
    assert client.get(SCENE_HANDLE, "simulation.state") == 0
    assert client.call(SCENE_HANDLE, "simulation.start") == []
    while client.get(SCENE_HANDLE, "simulation.state") != 17:
        pass
    while client.get(SCENE_HANDLE, "simulation.time") < 0.2:
        pass
    client.call(SCENE_HANDLE, "simulation.stop")
    while client.get(SCENE_HANDLE, "simulation.state") != 0:
        pass


def test_a_stepping_client_makes_every_step(client: WireClient) -> None:
    client.call(SELF, "setStepping", True)
    assert client.call(SELF, "getStepping") == [True]
    client.call(SCENE_HANDLE, "simulation.start")
    for count in range(1, 4):
        assert client.call(SELF, "step") == []
        assert client.get(SCENE_HANDLE, "simulation.stepCount") == count
    client.call(SELF, "setStepping", False)
    assert client.call(SELF, "wait", 0.2) == []
    assert client.get(SCENE_HANDLE, "simulation.time") > 0.3


def test_objects_are_created_and_removed(client: WireClient) -> None:
    fields = {"type": "shape", "cuboid": {"size": [0.1, 0.2, 0.3]}, "name": "new"}
    (made,) = client.call(SCENE_HANDLE, "createObject", fields)
    assert made.tag == OBJECT
    assert client.at("/new") == made.value
    client.call(SCENE_HANDLE, "removeObjects", [cbor2.CBORTag(OBJECT, made.value)])
    assert client.call(made.value, "isValid") == [False]


def test_a_script_is_called_with_one_argument(client: WireClient, server: Zmq2World) -> None:
    shelf = client.at("/shelf/shelfScript")
    assert client.call(shelf, "callFunction", "where") == ["shelf"]
    with pytest.raises(Refused, match="--allow-code"):
        client.call(shelf, "executeString", "return 1")
    for name in ("load", b"load", "load\0x", b"os.execute"):
        with pytest.raises(Refused, match="no function of the script's own"):
            client.call(shelf, "callFunction", name, "return 1")
    with pytest.raises(Refused, match="allow"):
        client.call(SCENE_HANDLE, "createObject", {"type": "script", "code": "x = 1"})


def test_the_first_clients_of_api_2_have_no_numbers(server: Zmq2World) -> None:
    old = server.wire(zmq.REQ)
    assert old.call(None, "getPort", "client-id") == [server.port]
    assert old.call(SCENE_HANDLE, "getStringProperty", "type") == ["scene"]
    with pytest.raises(Refused, match="target does not exist"):
        old.call(999, "getProperty", "name")


def test_a_client_of_the_other_protocol_is_told_the_other_port(server: Zmq2World) -> None:
    other = server.raw()
    answer: Any = other.ask("zmqRemoteApi.require", "sim")
    assert "--zmq, and connect to that port (23000)" in answer["err"]


def test_noop_is_not_answered(client: WireClient) -> None:
    for _ in range(10):
        client.send(bytes.fromhex("a1636d7367646e6f6f70"))
    assert client.call(None, "noop") == []


def test_names_that_are_no_text_travel_as_bytes(client: WireClient) -> None:
    box, name = client.at("/box"), b"\xffname"
    client.call(box, "setProperty", "customData.odd", {name: 1}, {})
    assert client.get(box, "customData.odd") == {name: 1}


def test_a_request_behind_one_that_waits_is_refused_by_its_own_number(client: WireClient) -> None:
    client.call(SCENE_HANDLE, "simulation.start")
    client.send({"msg": "call", "id": 70, "target": SELF, "func": "wait", "args": [0.2]})
    client.send({"msg": "call", "id": 71, "target": SCENE_HANDLE, "func": "getObjects", "args": []})
    client.send({"msg": "registerCallback", "id": 72, "func": "sysCall_vision", "global": True})
    answers = {answer["id"]: answer for answer in (client.receive() for _ in range(3))}
    assert "wait is not answered yet" in answers[71]["result"]
    assert "not called for clients" in answers[72]["result"]
    assert answers[70] == {"msg": "result", "id": 70, "error": False, "result": []}
