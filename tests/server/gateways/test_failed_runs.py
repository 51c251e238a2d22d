"""Physics diverges: every client that waits for a simulation step gets the reason as an error, at each gateway."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from loopback import LoopbackTransport
from original_peer import ints, peer
from real_world import RealWorld, handle_of, start_stepped
from zmq_world import ZmqWorld, cbor2, zmq_world

import simx_client as v
from simx_client.client import Client, Worlds
from simx_client.connection.clients import CLIENTS
from simx_client.connection.connection import Connection
from simx_client.errors import CallsFailed, RemoteError
from simx_client.gym import SimxEnv
from simx_client.protocol.messages import Pace
from simx_server.gateways.original.gateway import OriginalGateway

DIVERGED = "the physics diverged"

DIVERGES = """
<mujoco>
  <option gravity="0 0 -1e13"/>
  <worldbody>
    <body name="ball"><freejoint/><geom size="0.1"/></body>
    <body name="arm" pos="5 0 0"><joint name="hinge"/><geom size="0.1"/></body>
  </worldbody>
</mujoco>
"""

MOTION = {"pos": [0.0], "targetPos": [9.0], "maxVel": [1.0], "maxAccel": [1.0], "maxJerk": [2.0]}

BLOCKING, FAILED = v.simx_opmode_blocking, v.simx_return_remote_error_flag


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "diverges.xml"
    path.write_text(DIVERGES)
    return path


def own_client(server: ZmqWorld) -> int:
    transport = LoopbackTransport(server.loop, turns=False)
    connection = Connection(lambda: transport, where=transport.client, timeout=20.0)
    number = CLIENTS.add(connection)
    connection.connect(20.0)
    return number


def test_calls_of_all_gateways_that_wait_for_a_step_fail(tmp_path: Path) -> None:
    with zmq_world(tmp_path) as server:
        gateway = OriginalGateway(server.loop, ["127.0.0.1:0"])
        holder, driver = own_client(server), own_client(server)
        for client in (holder, driver):
            v.simxSynchronous(client, True)
        v.simxStartSimulation(holder, BLOCKING)
        stepping = server.raw()
        stepping.ask("sim.setStepping", True)
        waiting = [stepping, *(server.raw() for _ in range(3))]
        calls = (
            ("sim.step",),
            ("sim.wait", 100),
            ("sim.moveToConfig", MOTION),
            ("sim.waitForSignal", "never"),
        )
        for client, call in zip(waiting, calls, strict=True):
            client.send(*call)
        codes: list[Any] = []
        threads = [threading.Thread(target=lambda: codes.append(v.simxSynchronousTrigger(driver)))]
        try:
            with peer(gateway.ports[0]) as original:
                original.call(0x0001)
                threads.append(
                    threading.Thread(target=lambda: codes.append(original.call(0x0003).has_failed))
                )
                for thread in threads:
                    thread.start()
                sessions = server.loop.sessions
                assert server.wait_until(
                    lambda: sum(each.is_stepping and not each.is_waiting for each in sessions.values()) == 3
                )
                assert server.wait_until(lambda: len(server.gateway._clients._waiting) == 4)
                server.on_server(lambda: server.simulation.data.qvel.fill(math.nan))
                assert v.simxSynchronousTrigger(holder) == FAILED
                answers = [cbor2.loads(client.socket.recv()) for client in waiting]
                for thread in threads:
                    thread.join(20)
                assert DIVERGED in original.call(0x0004).payload.decode()
                assert original.call(0x1021, ints(1)).time_ms == 0
        finally:
            gateway.close()
        assert [DIVERGED in answer["err"] for answer in answers] == [True] * 4, answers
        assert sorted(codes) == [True, FAILED]
        for client in (holder, driver):
            assert [DIVERGED in each for each in v.simxGetLastErrors(client, BLOCKING)[1]] == [True], (
                "told once"
            )
            v.simxFinish(client)


def test_a_paced_call_that_waits_fails_and_those_behind_it_are_made(scene: Path) -> None:
    world = RealWorld(scene)
    try:
        client = world.client(Pace.EVERY)
        hinge = handle_of(client, "hinge")
        v.simxStartSimulation(client, BLOCKING)
        codes = [v.simxGetJointPosition(client, hinge, BLOCKING)[0] for _ in range(9)]
        assert codes.count(FAILED) == 1
        assert codes[-1] == v.simx_return_ok, "stopped, and usable"
        assert DIVERGED in v.simxGetLastErrors(client, BLOCKING)[1][0]
    finally:
        world.close()


def test_an_embedded_client_gets_the_error_of_its_step(scene: Path) -> None:
    world = RealWorld(scene)
    try:
        client = world.embedded_client()
        start_stepped(client)
        codes = []
        while world.simulation.is_running:
            codes.append(v.simxSynchronousTrigger(client))
        assert codes[-1] == FAILED
        assert [DIVERGED in each for each in v.simxGetLastErrors(client, BLOCKING)[1]] == [True]
    finally:
        world.close()


def step_modern(scene: Path) -> None:
    with Client.embedded(scene) as client, client.stepping() as step:
        for _ in range(9):
            step()


def step_worlds(scene: Path) -> None:
    with Worlds(scene, 2, processes=0) as worlds:
        worlds.each(lambda calls, _: (calls.simxSynchronous(True), calls.simxStartSimulation()))
        for _ in range(9):
            worlds.step()


def step_environment(scene: Path) -> None:
    environment = SimxEnv(
        scene,
        observations=["hinge.position"],
        actions={"hinge.target_velocity": (-1.0, 1.0)},
        reward=lambda _: 0.0,
    )
    try:
        environment.reset(seed=1)
        for _ in range(9):
            environment.step(environment.action_space.sample())
    finally:
        environment.close()


@pytest.mark.parametrize(
    ("program", "error"),
    [(step_modern, RemoteError), (step_worlds, CallsFailed), (step_environment, CallsFailed)],
    ids=["client", "worlds", "environment"],
)
def test_a_program_that_steps_gets_an_exception_with_the_reason(
    scene: Path, program: Callable[[Path], None], error: type[Exception]
) -> None:
    with pytest.raises(error, match=DIVERGED):
        program(scene)
