"""Recordings of clients of the ZeroMQ remote API replay bit for bit."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from recordings import RecordedWorld, kinds, replay, rewrite
from zmq_world import SCENE, ZmqWorld

from simx_server.gateways.zmq import connection
from simx_server.recording.records import Kind

REPLAYED, DIFFERS = 0, 3


@contextmanager
def recorded(folder: Path, **settings: Any) -> Any:
    """A recorded server with the gateway; yields it and the recording."""
    (folder / "scene.xml").write_text(SCENE, encoding="utf-8")
    file = folder / "run.simxlog"
    opened = ZmqWorld(RecordedWorld(folder / "scene.xml", file, **settings))
    try:
        yield opened, file
    finally:
        opened.close()


def test_steps_motions_waits_and_two_clients_are_repeated(tmp_path: Path) -> None:
    with recorded(tmp_path) as (server, file):
        sim, other = server.sim(), server.sim()
        hinge = sim.getObject("/hinge")
        sim.setStepping(True)
        sim.startSimulation()
        for count in range(12):
            sim.setJointTargetVelocity(hinge, 0.1 * count)
            other.setInt32Signal("count", count)
            sim.step()
        sim.setStepping(False)
        sim.wait(0.3)
        sim.wait(0.02, False)  # seconds of the wall clock
        sim.setObjectPosition(sim.getObject("/box"), [0, 0, 2])
        other.wait(0.2)
        with pytest.raises(Exception, match="object does not exist"):
            sim.getObject("/gone")
        sim.stopSimulation()
        sim.startSimulation()
        server.close_clients()
        assert server.wait_until(lambda: not server.loop.service.clients.sessions)
    seen = kinds(file)
    assert seen.count(Kind.JOINED_ZMQ) == 2
    assert Kind.CONTINUED in seen
    assert replay(file) == REPLAYED


def test_the_end_of_a_frozen_clients_stepping_is_repeated(tmp_path: Path) -> None:
    with recorded(tmp_path) as (server, file):
        sim = server.sim()
        sim.setStepping(True)
        sim.startSimulation()
        sim.step()
        (key,) = server.loop.service.clients.sessions
        server.on_server(lambda: server.loop.service.clients.end_stepping(key, "it was silent"))
        assert server.wait_until(lambda: server.simulation.step_count > 10)
        with pytest.raises(Exception, match="the server ended the stepped mode of this client"):
            sim.step()
        assert sim.setStepping(True) == 0
        sim.step()
        sim.stopSimulation()
    assert Kind.STEPPING_LOST in kinds(file)
    assert replay(file) == REPLAYED


def pushed(sim: Any) -> None:
    """A motion whose function of the client pushes a body, by its own calls."""
    box = sim.getObject("/box")

    def push(motion: Any) -> None:
        sim.setObjectPosition(box, [0, 0, 1 + motion["pos"][0]])
        assert sim.testCB(2, lambda one, other: one + other, 3) == 5

    goal = {
        "joints": [sim.getObject("/hinge")],
        "targetPos": [0.3],
        "maxVel": [1],
        "maxAccel": [5],
        "maxJerk": [9],
    }
    sim.moveToConfig({**goal, "callback": push})


def silent(sim: Any) -> None:
    """A function that takes too long: the server ends its call, and the client goes on."""

    def wait_for_ever(*_numbers: int) -> int:
        sim.wait(0.1)
        return 1

    with pytest.raises(Exception, match="waits for a simulation step"):
        sim.testCB(1, wait_for_ever, 1)
    sim.setObjectPosition(sim.getObject("/box"), [0, 1, 2])


@pytest.mark.parametrize("act", [pushed, silent])
def test_functions_of_a_client_are_repeated_from_their_answers(
    tmp_path: Path, act: Callable[[Any], None]
) -> None:
    with recorded(tmp_path) as (server, file):
        sim, other = server.sim(), server.sim()
        sim.startSimulation()
        act(sim)
        other.setFloatSignal("after", 1.5)
        sim.wait(0.1)
        sim.stopSimulation()
    assert Kind.WITHIN in kinds(file)
    assert replay(file) == REPLAYED


def test_a_function_that_was_given_up_is_given_up_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(connection, "SILENCE", 0.05)
    with recorded(tmp_path) as (server, file):
        raw = server.raw()
        raw.ask("sim.startSimulation")
        assert raw.ask("sim.testCB", 1, "f@func", 1)["func"] == "f"
        assert server.wait_until(lambda: not any(each.nested is not None for each in server.gateway._peers))
        assert "took too long" in raw.ask("_*executed*_", 1)["err"]
        raw.ask("sim.setInt32Signal", "after", 1)
        raw.ask("sim.wait", 0.1)
    assert replay(file) == REPLAYED


def test_another_message_is_noticed(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    with recorded(tmp_path) as (server, file):
        sim = server.sim()
        sim.startSimulation()
        sim.setObjectPosition(sim.getObject("/box"), [0, 0, 2])
        sim.wait(0.1)

    def without_the_position(records: list[Any]) -> list[Any]:
        return [each for each in records if not (each[0] == Kind.BATCH and b"setObjectPosition" in each[3])]

    rewrite(file, without_the_position)
    assert replay(file) == DIFFERS
    assert "other positions (qpos)" in caplog.text
