"""Recordings of clients of the ZeroMQ remote API and of the original's protocol, and their replays."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from loopback import LoopbackTransport
from original_peer import STREAMING, command, floats, ints, peer, text
from recordings import RecordedWorld, kinds, replay, rewrite
from zmq_world import SCENE, ZmqWorld

import simx_client as v
from simx_client.connection.clients import CLIENTS
from simx_client.connection.connection import Connection
from simx_client.protocol.cli.exit_codes import DIVERGED, DONE
from simx_server.gateways.original.gateway import OriginalGateway
from simx_server.gateways.zmq import connection
from simx_server.recording.records import Kind, Record


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    return tmp_path / "run.simxlog"


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "scene.xml"
    path.write_text(SCENE, encoding="utf-8")
    return path


@contextmanager
def recorded_server(scene: Path, recording: Path) -> Iterator[ZmqWorld]:
    opened = ZmqWorld(RecordedWorld(scene, recording))
    try:
        yield opened
    finally:
        opened.close()


def of_this_project(server: ZmqWorld) -> int:
    """A client of the table's calls beside the others."""
    transport = LoopbackTransport(server.loop, turns=False)
    made = Connection(lambda: transport, where=transport.client, timeout=20.0)
    client = CLIENTS.add(made)
    made.connect(20.0)
    return client


def test_calls_of_zmq_clients_replay_to_the_same_states(
    scene: Path, recording: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with recorded_server(scene, recording) as server:
        drive(server, monkeypatch)
    recorded = kinds(recording)
    assert {Kind.JOINED, Kind.JOINED_ZMQ, Kind.CONTINUED, Kind.WITHIN, Kind.LEFT} <= set(recorded)
    assert replay(recording) == DONE


def drive(server: ZmqWorld, monkeypatch: pytest.MonkeyPatch) -> None:
    """Everything whose order a recording must keep."""
    sim, beside = server.sim(), of_this_project(server)
    box, hinge = sim.getObject("/box"), sim.getObject("/hinge")

    # Functions of the client: what they return and call changes the simulation, and others act meanwhile.
    def act(a: float, b: float) -> float:
        sim.setObjectPosition(box, -1, [a, b, sim.getSimulationTime()])
        assert v.simxSetJointPosition(beside, hinge, a / 10, v.simx_opmode_blocking) == 0
        return sim.getJointPosition(hinge) + b

    assert sim.testCB(1, act, 2, 1) == pytest.approx(2.1)
    sim.setStepping(True)
    sim.startSimulation()

    def follow(config: Any, *_: Any) -> None:
        sim.setJointTargetVelocity(hinge, 3 * config[0])

    sim.moveToConfig(-1, [0.0], [0.0], [0.0], [1.0], [5.0], [9.0], [0.2], [0.0], follow, None)
    sim.wait(0.2)
    for count in range(5):
        sim.setJointTargetVelocity(hinge, 0.3 * count)
        sim.step()

    # One that goes within a call that waits, one within its function, and one that is silent for too long.
    sim.setStepping(False)
    going = server.raw()
    going.send("sim.wait", 1000.0)
    assert server.wait_until(lambda: len(server.loop.sessions) == 3)
    going.close()
    assert server.wait_until(lambda: len(server.loop.sessions) == 2)
    gone, silent = server.raw(), server.raw()
    assert "func" in gone.ask("sim.testCB", 1, "f@func", 2, 1)
    gone.close()
    monkeypatch.setattr(connection, "SILENCE", 0.02)
    assert "func" in silent.ask("sim.testCB", 1, "f@func", 2, 1)
    sim.setFloatSignal("within", sim.getSimulationTime())
    sim.announceSceneContentChange()  # waits until the function is not waited for any longer
    sim.setFloatSignal("after", sim.getSimulationTime())
    assert "took too long" in silent.ask("_*executed*_", 3)["err"]
    assert "err" in silent.ask_bytes(b"\xff"), "nonsense is recorded too"
    sim.stopSimulation(True)
    sim.setObjectPosition(box, -1, [3, 3, 3])
    v.simxFinish(beside)


def test_a_replay_without_a_message_of_a_function_differs(scene: Path, recording: Path) -> None:
    with recorded_server(scene, recording) as server:
        client = server.raw()
        box = client.ask("sim.getObject", "/box")["ret"][0]
        assert "func" in client.ask("sim.testCB", box, "move@func", -1, 0)
        assert "ret" in client.ask("sim.setObjectPosition", box, -1, [0.25, 0.5, 0.75])
        client.ask("_*executed*_", 3)
        client.ask("sim.startSimulation")
    assert replay(recording) == DONE

    def without_answer(records: list[Record]) -> list[Record]:
        places = [place for place, record in enumerate(records) if record[0] == Kind.WITHIN]
        return [record for place, record in enumerate(records) if place != places[0]]

    rewrite(recording, without_answer)
    assert replay(recording) == DIVERGED


def test_calls_of_original_clients_replay_to_the_same_states(scene: Path, recording: Path) -> None:
    place = RecordedWorld(scene, recording)
    gateway = OriginalGateway(place.loop, ["127.0.0.1:0"])
    thread = threading.Thread(target=place.loop.run)
    thread.start()
    try:
        with peer(gateway.ports[0]) as client:
            hinge = ints(client.handle("hinge"))
            client.call(0x0001)  # stepped mode
            client.call(0x1007, ints(0))  # start
            client.exchange(command(0x1001, hinge, mode=STREAMING))
            for step in range(1, 25):
                client.call(0x1008, hinge, floats(0.1 * step))  # a target velocity
                client.call(0x3014, text("mark"), ints(step))
                assert not client.call(0x0003).has_failed  # a step
            client.call(0x1007, ints(2))
            client.call(0x1002, hinge, floats(0.25))
    finally:
        place.loop.ending.request()
        thread.join(20)
        gateway.close()
        place.close()
    assert kinds(recording).count(Kind.PASS) == 24
    assert replay(recording) == DONE
