"""Functions of clients of API 2: as arguments, in phases of the simulation, within each other; and clients that fall
silent.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from zmq2_world import FUNCTION, SCENE_HANDLE, SELF, Refused, WireClient, Zmq2World, cbor2, zmq2_world

from simx_server.gateways.zmq import connection


def visitor(client: WireClient, function: Any, name: str = "@tmpcallback_1") -> Any:
    """A function as an argument."""
    client.functions[name] = function
    return cbor2.CBORTag(FUNCTION, name)


def test_a_function_travels_as_an_argument_and_may_call_the_server(client: WireClient) -> None:
    names: list[str] = []

    def visit(item: Any) -> bool:
        names.extend(client.call(item.value, "getStringProperty", "name"))
        return True

    client.call(client.at("/hinge"), "visitTree", visitor(client, visit))
    assert names == ["hinge", "arm"]


def test_functions_are_nested(client: WireClient) -> None:
    depth: list[int] = []

    def visit(item: Any) -> bool:
        depth.append(len(depth))
        if len(depth) < 3:
            client.call(item.value, "visitTree", visitor(client, visit, f"@tmpcallback_{len(depth)}"))
        return False

    client.call(client.at("/box"), "visitTree", visitor(client, visit))
    assert len(depth) == 3


def test_an_error_of_a_function_is_the_error_of_the_call(client: WireClient) -> None:
    def fail(_item: Any) -> None:
        raise ValueError("lost my way")

    with pytest.raises(Refused, match="lost my way"):
        client.call(client.at("/box"), "visitTree", visitor(client, fail))


def test_phases_call_registered_functions_in_each_step(client: WireClient) -> None:
    seen: list[tuple[str, float]] = []
    for name in ("sysCall_actuation", "sysCall_sensing"):
        client.register(
            name,
            lambda name=name: seen.append((name, client.get(SCENE_HANDLE, "simulation.time"))),
            is_global=True,
        )
    client.call(SCENE_HANDLE, "simulation.start")
    client.poll_until(lambda: len(seen) >= 8)
    client.call(SCENE_HANDLE, "simulation.stop")
    assert [name for name, _ in seen[:4]] == ["sysCall_actuation", "sysCall_sensing"] * 2
    times = [time for name, time in seen if name == "sysCall_sensing"]
    assert times == sorted(set(times))


def test_numbers_of_both_sides_do_not_collide(client: WireClient) -> None:
    """The client's request 1 is under way while the server's call 1 comes."""
    client.functions["sysCall_sensing"] = lambda: None
    client.register("sysCall_sensing", lambda: None, is_global=True)
    client.call(SCENE_HANDLE, "simulation.start")
    assert client.call(SELF, "wait", 0.5) == []


def test_an_unknown_phase_is_refused(client: WireClient) -> None:
    with pytest.raises(Refused, match="not called for clients; those are sysCall_actuation"):
        client.register("sysCall_vision", lambda: None, is_global=True)


def test_a_client_that_dies_in_its_function_holds_nobody(server: Zmq2World) -> None:
    dying, other = server.wire(), server.wire()
    dying.register("sysCall_sensing", lambda: None, is_global=True)
    dying.call(SCENE_HANDLE, "simulation.start")
    dying.receive()  # the server waits within the step
    dying.context.destroy(linger=0)
    before = other.get(SCENE_HANDLE, "simulation.stepCount")
    while other.get(SCENE_HANDLE, "simulation.stepCount") < before + 5:
        pass


def test_a_silent_client_is_called_again_after_its_late_answer(
    server: Zmq2World, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(connection, "SILENCE", 0.05)
    silent, other = server.wire(), server.wire()
    silent.register("sysCall_sensing", lambda: None, is_global=True)
    silent.call(SCENE_HANDLE, "simulation.start")
    owed = silent.receive()
    before = other.get(SCENE_HANDLE, "simulation.stepCount")
    while other.get(SCENE_HANDLE, "simulation.stepCount") < before + 20:
        pass  # the simulation goes on without it
    silent.serve(owed)
    assert silent.receive()["func"] == "sysCall_sensing"


def test_a_step_within_a_phase_is_made_after_it(client: WireClient, monkeypatch: pytest.MonkeyPatch) -> None:
    """The server does not know whether a request has crossed its call, so it goes on without the answer."""
    monkeypatch.setattr(connection, "SILENCE", 0.05)
    done: list[bool] = []

    def sense() -> None:
        if not done:
            client.call(SELF, "step")
            done.append(True)

    client.register("sysCall_sensing", sense, is_global=True)
    client.call(SCENE_HANDLE, "simulation.start")
    client.poll_until(lambda: bool(done))


def test_a_step_within_a_function_of_a_call_is_refused(client: WireClient) -> None:
    problems: list[str] = []

    def visit(_item: Any) -> None:
        try:
            client.call(SELF, "wait", 0.1)
        except Refused as problem:
            problems.append(str(problem))

    client.call(client.at("/box"), "visitTree", visitor(client, visit))
    assert "cannot be called within @tmpcallback_1" in problems[0]


def test_a_request_that_crosses_the_call_of_a_phase_is_served(client: WireClient) -> None:
    client.register("sysCall_sensing", lambda: None, is_global=True)
    client.call(SCENE_HANDLE, "simulation.start")
    owed = client.receive()  # the server waits for it, and now gets a request first
    client.send({"msg": "call", "id": 77, "target": SELF, "func": "wait", "args": [0.2]})
    client.serve(owed)
    while (message := client.receive()).get("id") != 77 or message["msg"] != "result":
        client.serve(message)
    assert message["error"] is False


def test_older_clients_pass_a_function_by_the_name_that_they_have_registered(client: WireClient) -> None:
    seen: list[int] = []
    client.register("visit", lambda item: seen.append(item.value))
    box = client.at("/box")
    client.call(box, "visitTree", "visit")
    assert seen == [box]
    assert client.call(box, "setProperty", "customData.text", "visitor", {}) == []
    assert client.get(box, "customData.text") == "visitor"


def test_a_scene_without_scripts_calls_clients_running_and_stopped(tmp_path: Path) -> None:
    seen: list[str] = []
    with zmq2_world(tmp_path, scene="<mujoco><worldbody><body name='box'/></worldbody></mujoco>") as server:
        client = server.wire()
        for name in (
            "sysCall_nonSimulation",
            "sysCall_actuation",
            "sysCall_sensing",
            "sysCall_afterSimulation",
        ):
            client.register(name, lambda name=name: seen.append(name), is_global=True)
        client.poll_until(lambda: "sysCall_nonSimulation" in seen)
        client.call(SCENE_HANDLE, "simulation.start")
        client.poll_until(lambda: seen.count("sysCall_sensing") > 2)
        client.call(SCENE_HANDLE, "simulation.stop")
        client.poll_until(lambda: "sysCall_afterSimulation" in seen)
    first = seen.index("sysCall_actuation")
    assert seen[first : first + 4] == ["sysCall_actuation", "sysCall_sensing"] * 2
