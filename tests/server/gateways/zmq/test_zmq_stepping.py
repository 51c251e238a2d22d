"""Stepping, functions that wait, several clients, and clients that go."""

from __future__ import annotations

import threading
from typing import Any

import pytest
from zmq_world import ZmqWorld, cbor2

from simx_server.history import History
from simx_server.history.going_on import go_on

MOTION = {"pos": [0.0], "targetPos": [1.0], "maxVel": [1.0], "maxAccel": [1.0], "maxJerk": [2.0]}


def start_stepping(sim: Any) -> None:
    sim.setStepping(True)
    sim.startSimulation()


def test_each_step_is_one_simulation_step(server: ZmqWorld) -> None:
    client = server.client()
    sim = client.require("sim")
    start_stepping(sim)
    assert (sim.getSimulationState(), sim.getSimulationTime()) == (
        sim.simulation_advancing_firstafterstop,
        0,
    )
    times = []
    for _ in range(5):
        sim.step()
        times.append(sim.getSimulationTime())
    client.step()
    times.append(sim.getSimulationTime())
    assert times == pytest.approx([0.05, 0.1, 0.15, 0.2, 0.25, 0.3])
    sim.stopSimulation()
    assert sim.getSimulationState() == sim.simulation_stopped


def test_levels_count_and_a_stop_ends_stepping(server: ZmqWorld) -> None:
    sim = server.sim()
    assert [sim.setStepping(True), sim.setStepping(True), sim.setStepping(False)] == [0, 1, 2]
    sim.startSimulation()
    sim.step()
    assert sim.getSimulationTime() == pytest.approx(0.05), "one level is left"
    sim.stopSimulation()
    assert sim.setStepping(False) == 0


def test_step_returns_at_once_when_nothing_runs(server: ZmqWorld) -> None:
    sim = server.sim()
    sim.step()
    start_stepping(sim)
    sim.step()
    sim.pauseSimulation()
    sim.step()
    assert sim.getSimulationTime() == pytest.approx(0.05)


def test_a_free_client_waits_for_the_next_step(server: ZmqWorld) -> None:
    sim = server.sim()
    sim.startSimulation()
    before = sim.getSimulationTime()
    sim.step()
    assert sim.getSimulationTime() > before


def test_waiting_makes_the_steps_that_it_needs(server: ZmqWorld) -> None:
    sim = server.sim()
    start_stepping(sim)
    sim.step()
    assert sim.wait(0.5) == pytest.approx(0, abs=1e-9)
    assert sim.getSimulationTime() == pytest.approx(0.55)


def test_two_stepping_clients_wait_for_each_other(server: ZmqWorld) -> None:
    first, second = server.sim(), server.sim()
    first.setStepping(True)
    second.setStepping(True)
    first.startSimulation()
    times: list[float] = []

    def other() -> None:
        for _ in range(3):
            second.step()
            times.append(second.getSimulationTime())

    thread = threading.Thread(target=other)
    thread.start()
    for _ in range(3):
        first.step()
    thread.join(20)
    assert not thread.is_alive()
    assert times[0] == pytest.approx(0.05)
    assert first.getSimulationTime() == pytest.approx(0.15)


def test_a_motion_takes_time_while_others_are_served(server: ZmqWorld) -> None:
    moving, other = server.sim(), server.sim()
    hinge = moving.getObject("/hinge")
    moving.startSimulation()
    ended = threading.Event()

    def move() -> None:
        table = {"joints": [hinge], "targetPos": [1.0], "maxVel": [1], "maxAccel": [1], "maxJerk": [2]}
        moving.moveToConfig(table)
        ended.set()

    thread = threading.Thread(target=move)
    thread.start()
    served = 0
    while not ended.is_set():
        other.getJointPosition(hinge)
        served += 1
    thread.join(20)
    assert served > 3


def test_a_lock_holds_the_simulation(server: ZmqWorld) -> None:
    sim = server.sim()
    sim.startSimulation()
    sim.acquireLock()
    before = sim.getSimulationTime()
    for _ in range(20):
        assert sim.getSimulationTime() == before
    sim.releaseLock()
    sim.step()
    assert sim.getSimulationTime() > before


def test_a_stop_lets_waiting_calls_return(server: ZmqWorld) -> None:
    waiting, other = server.raw(), server.sim()
    waiting.ask("sim.setStepping", True)
    other.setStepping(True)
    other.startSimulation()
    waiting.send("sim.step")
    assert server.wait_until(lambda: server.gateway._clients.wants_idle)
    other.stopSimulation()
    assert waiting.socket.recv() == b"\xa1\x63ret\x80"


@pytest.mark.parametrize(
    "call",
    [("sim.wait", 0.5), ("sim.moveToConfig", MOTION), ("sim.waitForSimulationStart",)],
    ids=lambda call: call[0],
)
def test_a_call_that_began_before_the_start_makes_the_steps_that_it_needs(
    server: ZmqWorld, call: tuple[Any, ...]
) -> None:
    stepping, other = server.raw(), server.sim()
    stepping.ask("sim.setStepping", True)
    stepping.send(*call)
    assert server.wait_until(lambda: server.gateway._clients.wants_idle)
    other.startSimulation()
    assert "ret" in cbor2.loads(stepping.socket.recv())


def test_a_call_that_waits_in_a_pause_goes_on_after_it(server: ZmqWorld) -> None:
    stepping, other = server.raw(), server.sim()
    stepping.ask("sim.setStepping", True)
    other.startSimulation()
    other.pauseSimulation()
    stepping.send("sim.wait", 0.5)
    assert server.wait_until(lambda: server.gateway._clients.wants_idle)
    other.startSimulation()
    assert "ret" in cbor2.loads(stepping.socket.recv())


def test_a_client_that_begins_to_step_while_a_call_of_its_own_waits_goes_on(server: ZmqWorld) -> None:
    waiting, second, other = server.raw(), server.raw(), server.sim()
    second.uuid = waiting.uuid
    other.setStepping(True)
    other.startSimulation()
    waiting.send("sim.wait", 0.5)
    assert server.wait_until(lambda: server.gateway._clients.wants_idle)
    second.ask("sim.setStepping", True)
    other.setStepping(False)
    assert "ret" in cbor2.loads(waiting.socket.recv())


def test_a_wait_by_the_clock_ends_while_the_simulation_is_stopped(server: ZmqWorld) -> None:
    assert server.sim().wait(0.05, False) >= 0


def test_a_client_that_goes_while_stepping_frees_the_simulation(server: ZmqWorld) -> None:
    gone, stays = server.raw(), server.sim()
    gone.ask("sim.setStepping", True)
    stays.startSimulation()
    assert stays.getSimulationTime() == 0
    gone.send("sim.step")  # dies while it waits for an answer
    gone.close()
    assert server.wait_until(lambda: len(server.loop.service.clients.sessions) == 1)
    stays.step()
    assert stays.getSimulationTime() > 0


def test_a_client_with_several_connections_leaves_with_the_last(server: ZmqWorld) -> None:
    first, second = server.raw(), server.raw()
    second.uuid = first.uuid
    first.ask("sim.setStepping", True)
    assert second.ask("sim.setStepping", True) == {"ret": [1]}, "one client"
    first.close()
    second.ask("sim.getSimulationTime")
    assert len(server.loop.service.clients.sessions) == 1
    second.close()
    assert server.wait_until(lambda: not server.loop.service.clients.sessions)


def test_a_goodbye_ends_stepping(server: ZmqWorld) -> None:
    client = server.raw()
    client.ask("sim.setStepping", True)
    assert client.ask("_*end*_") == {}
    assert client.ask("sim.setStepping", True) == {"ret": [0]}


def test_calls_are_noted_with_the_steps_of_a_run_and_a_new_run_goes_on_from_one(server: ZmqWorld) -> None:
    sim = server.sim()
    history = server.on_server(lambda: History(server.loop.service, 60.0))
    server.on_server(lambda: server.loop.service.watchers.add(history))
    start_stepping(sim)
    sim.step()
    sim.setFloatSignal("gain", 0.5)
    with pytest.raises(Exception, match="object does not exist"):
        sim.getObject("/nix")
    sim.step()
    sim.step()
    calls = [call for call in server.on_server(lambda: history.calls(2)).calls if not call.only_reads]
    assert [(call.function, call.arguments, call.has_failed) for call in calls] == [
        ("sim.setFloatSignal", ("gain", 0.5), False)
    ]
    failed = [call for call in server.on_server(lambda: history.calls(2)).calls if call.has_failed]
    assert [call.function for call in failed] == ["sim.getObject"]
    server.on_server(lambda: go_on(server.loop.service, history, 1))
    assert sim.getSimulationTime() == pytest.approx(0.05)
    assert not sim.getFloatSignal("gain")
    sim.startSimulation()
    sim.step()
    assert sim.getSimulationTime() == pytest.approx(0.1)
    server.on_server(lambda: server.simulation.parts.detach(history))
    server.on_server(lambda: server.loop.service.executor.note_in(None))
