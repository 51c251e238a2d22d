"""Functions of the client that the server calls: they run at the client, and may call the server."""

from __future__ import annotations

import itertools
from typing import Any

import pytest
from zmq_world import ZmqWorld

from simx_server.gateways.zmq import connection


def test_a_function_of_the_client_is_called_and_its_result_used(server: ZmqWorld) -> None:
    calls: list[Any] = []

    def add(a: float, b: float) -> float:
        calls.append((a, b))
        return a + b

    assert server.sim().testCB(21, add, 4, 10) == 25
    assert calls == [(21, 4)] * 11


def test_a_list_is_several_results_and_a_tuple_is_one(server: ZmqWorld) -> None:
    sim = server.sim()
    assert sim.testCB(0, lambda a, b: [1, 2, 3], 0, 1) == (1, 2, 3)
    assert sim.testCB(0, lambda a, b: (1, 2), 0, 1) == [1, 2]
    assert sim.testCB(0, lambda a, b: None, 0, 1) is None


def test_a_function_may_call_the_server_also_with_functions(server: ZmqWorld) -> None:
    sim = server.sim()

    def inner(a: float, b: float) -> float:
        return a * b + sim.getObjectPosition(sim.getObject("/nose"), -1)[2]

    def outer(a: float, b: float) -> float:
        with pytest.raises(Exception, match="object does not exist"):
            sim.getObject("/nix")
        return sim.testCB(a, inner, b, 2)

    assert sim.testCB(2, outer, 3, 2) == pytest.approx(9)


def test_a_motion_calls_a_function_in_every_step(server: ZmqWorld) -> None:
    sim = server.sim()
    sim.setStepping(True)
    sim.startSimulation()
    seen: list[Any] = []

    def move(config: Any, *_: Any) -> None:
        seen.append((config[0], sim.getSimulationTime()))

    sim.moveToConfig(-1, [0.0], [0.0], [0.0], [1.0], [5.0], [9.0], [0.2], [0.0], move, None)
    assert seen[-1][0] == pytest.approx(0.2)
    assert [b[1] - a[1] for a, b in itertools.pairwise(seen)] == pytest.approx([0.05] * (len(seen) - 1))
    in_a_table: list[Any] = []
    table = {"pos": [0.0], "targetPos": [0.2], "maxVel": [1], "maxAccel": [5], "maxJerk": [9]}
    sim.moveToConfig({**table, "callback": lambda data: in_a_table.append(data["pos"][0])})
    assert in_a_table[-1] == pytest.approx(0.2)


def test_none_at_the_end_of_the_arguments_of_a_function_is_left_out(server: ZmqWorld) -> None:
    """Functions of three arguments are called by motions without auxiliary data, as in CoppeliaSim."""
    sim = server.sim()
    sim.setStepping(True)
    sim.startSimulation()
    poses: list[list[float]] = []

    def move(pose: list[float], _velocity: Any, _acceleration: Any) -> None:
        poses.append(pose)

    start, goal, most = [0, 0, 0, 0, 0, 0, 1], [0.1, 0, 0, 0, 0, 0, 1], [9.0] * 4
    sim.moveToPose(-1, start, most, most, most, goal, move, None, None)
    assert poses[-1][0] == pytest.approx(0.1)
    with_auxiliary: list[Any] = []
    sim.moveToPose(-1, start, most, most, most, goal, lambda *given: with_auxiliary.append(given[3:]), 7)
    assert with_auxiliary[-1] == (7,)
    assert sim.testCB(None, lambda *given: len(given), 1, 1) == 2, "before a value None is kept"


def test_a_function_that_raises_leaves_the_client_usable(server: ZmqWorld) -> None:
    sim = server.sim()

    def fails(_a: Any, _b: Any) -> None:
        raise ValueError("of the client")

    with pytest.raises(ValueError, match="of the client"):
        sim.testCB(1, fails, 2, 1)
    assert sim.getObject("/box") >= 0, "answered as if nested"
    sim.setStepping(True)
    sim.startSimulation()
    sim.step()  # waits for a step, so it cannot be nested
    assert sim.getSimulationTime() == pytest.approx(0.05)


def test_a_function_cannot_step_itself(server: ZmqWorld) -> None:
    sim = server.sim()
    sim.startSimulation()

    def steps(_a: Any, _b: Any) -> None:
        sim.step()

    with pytest.raises(
        Exception, match=r"sim\.step waits for a simulation step, so it cannot be called within"
    ):
        sim.testCB(1, steps, 2, 1)
    assert sim.getObject("/box") >= 0


def test_functions_nest_only_so_deep(server: ZmqWorld) -> None:
    sim = server.sim()

    def deeper(a: float, b: float) -> float:
        return sim.testCB(a + 1, deeper, b, 0)

    with pytest.raises(Exception, match="more than 8 functions of a client wait for each other"):
        sim.testCB(0, deeper, 0, 0)
    assert sim.getObject("/box") >= 0


def test_a_silent_function_is_not_waited_for_long(server: ZmqWorld, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(connection, "SILENCE", 0.02)
    silent, other = server.raw(), server.sim()
    request = silent.ask("sim.testCB", 1, "f_0@func", 2, 1)
    assert request == {"func": "f_0", "args": [1, 2]}
    assert other.createDummy(0.1) >= 0, "it waits in vain, others do not"
    answer = silent.ask("_*executed*_", 3)
    assert "the function f_0 took too long" in answer["err"]
    assert silent.ask("sim.getSimulationTime")["ret"] == [0.0]


def test_a_client_that_goes_within_its_function_is_noticed(server: ZmqWorld) -> None:
    gone, other = server.raw(), server.sim()
    assert "func" in gone.ask("sim.testCB", 1, "f_0@func", 2, 1)
    gone.close()
    assert other.getObject("/box") >= 0
    assert server.wait_until(lambda: len(server.loop.service.clients.sessions) == 1)


def test_a_result_that_nobody_asked_for_is_an_error(server: ZmqWorld) -> None:
    assert "err" in server.raw().ask("_*executed*_", 1)


def test_functions_kept_for_later_are_called_only_while_the_client_waits(server: ZmqWorld) -> None:
    from simx_server.gateways.zmq.connection import ClientFunction
    from simx_server.scripting.interpreter import ScriptError

    client = server.client()
    client.require("sim")
    inside = server.gateway._clients._clients[f"zmq/{client.uuid}"]
    with pytest.raises(ScriptError, match="only while the client waits"):
        ClientFunction(inside, "f")()
