"""During a long edit, blocking calls of others are refused with a text; calls that do not wait keep their place."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import mujoco
import pytest
from loopback import LoopbackTransport
from observing import observe
from real_world import RealWorld

import simx_client as vrep
from simx_client.connection.clients import CLIENTS
from simx_client.connection.connection import Connection
from simx_server.scene.editing import recompile
from simx_server.service.calls import busy
from simx_server.service.calls.work import BatchWork
from simx_server.service.monitoring import report
from simx_server.service.watcher import Watcher

TIMEOUT = 20.0
"""Seconds that only a hang takes."""

BLOCKING, ONESHOT = vrep.simx_opmode_blocking, vrep.simx_opmode_oneshot


class LongCompile:
    """The next compile takes until it is told to go on."""

    def __init__(self, patch: pytest.MonkeyPatch) -> None:
        self.begun, self.go_on = threading.Event(), threading.Event()
        self._compile = recompile.compile_spec
        patch.setattr(recompile, "compile_spec", self)

    def __call__(self, spec: mujoco.MjSpec, *others: Any) -> mujoco.MjModel:
        self.begun.set()
        assert self.go_on.wait(TIMEOUT)
        return self._compile(spec, *others)


class World(RealWorld):
    """The server loop runs in a thread; each client is a separate caller."""

    def __init__(self) -> None:
        super().__init__(Path(__file__).parents[2] / "conformance" / "scene.xml")
        self._thread = threading.Thread(target=self.loop.run)
        self._thread.start()

    def client(self) -> int:
        transport = LoopbackTransport(self.loop, port=19997, turns=False)
        connection = Connection(lambda: transport, where=transport.client, timeout=TIMEOUT)
        client_id = CLIENTS.add(connection)
        connection.connect(1.0)
        assert vrep.simxGetPingTime(client_id)[0] == vrep.simx_return_ok  # its hello has been heard
        return client_id

    def close(self) -> None:
        vrep.simxFinish(-1)
        self.loop.service.ending.request()
        self._thread.join(TIMEOUT)
        super().close()


@pytest.fixture
def world(monkeypatch: pytest.MonkeyPatch) -> Iterator[World]:
    monkeypatch.setattr(busy, "TIMEOUT", 0.05)
    monkeypatch.setattr(busy, "_LOOK", 0.01)
    world = World()
    try:
        yield world
    finally:
        world.close()


def test_blocking_calls_of_others_are_refused_while_an_edit_takes_long(
    world: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    editor, other = world.client(), world.client()
    cart = vrep.simxGetObjectHandle(editor, "cart", BLOCKING)[1]
    compiling = LongCompile(monkeypatch)
    made: list[int] = []
    edit = threading.Thread(target=lambda: made.append(vrep.simxRemoveObject(editor, cart, BLOCKING)))
    edit.start()
    try:
        assert compiling.begun.wait(TIMEOUT)
        vrep.simxSetIntegerSignal(other, "kept", 7, ONESHOT)
        assert vrep.simxSetIntegerSignal(other, "refused", 1, BLOCKING) == vrep.simx_return_remote_error_flag
        code, texts = vrep.simxGetLastErrors(other, BLOCKING)
        problems = report.health(world.loop.service, "realm")["problems"]
    finally:
        compiling.go_on.set()
        edit.join(TIMEOUT)
    assert code == vrep.simx_return_ok
    assert len(texts) == 1
    assert "simxSetIntegerSignal: the server is busy with simxRemoveObject of another client" in texts[0]
    assert "not executed, call again" in texts[0]
    assert problems[0].startswith("simxRemoveObject of loopback takes ")
    assert made[0] == vrep.simx_return_ok  # who edits waits for the result
    assert vrep.simxGetIntegerSignal(other, "kept", BLOCKING) == (vrep.simx_return_ok, 7)
    assert vrep.simxGetIntegerSignal(other, "refused", BLOCKING)[0] != vrep.simx_return_ok
    assert vrep.simxSetIntegerSignal(other, "refused", 1, BLOCKING) == vrep.simx_return_ok


def test_a_short_edit_refuses_nobody(world: World) -> None:
    client = world.client()
    assert vrep.simxCreateDummy(client, 0.1, None, BLOCKING)[0] == vrep.simx_return_ok
    assert vrep.simxGetLastErrors(client, BLOCKING) == (vrep.simx_return_ok, [])


def test_one_of_several_clients_waits_for_no_longer_physics_step_than_for_an_edit(
    world: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(busy, "STEP_TIMEOUT", 1000.0)
    starter, other = world.client(), world.client()
    begun, go_on = threading.Event(), threading.Event()

    def long_step() -> None:
        begun.set()
        assert go_on.wait(TIMEOUT)

    observe(world.simulation, step_finished=long_step)
    try:
        assert vrep.simxStartSimulation(starter, BLOCKING) == vrep.simx_return_ok
        assert begun.wait(TIMEOUT)
        code = vrep.simxSetIntegerSignal(other, "refused", 1, BLOCKING)
        _, texts = vrep.simxGetLastErrors(other, BLOCKING)
    finally:
        go_on.set()
    assert code == vrep.simx_return_remote_error_flag
    assert "the server is busy with a simulation step" in texts[0]


def test_calls_that_only_a_socket_holds_are_refused_too(
    world: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    one, other = world.client(), world.client()
    connection = CLIENTS.get(other)
    assert connection is not None
    held: list[tuple[str, bytes]] = []
    client = connection.where
    monkeypatch.setattr(
        connection._transport, "send", lambda payload, deadline: held.append((client, payload))
    )

    def submit(client: str, payload: bytes) -> None:
        world.loop.service.queue.submit(client, BatchWork(payload))

    class Reader(Watcher):
        def read_while_busy(self) -> None:
            for _ in held[:]:
                submit(*held.pop())

    world.loop.service.watchers.add(Reader())
    cart = vrep.simxGetObjectHandle(one, "cart", BLOCKING)[1]
    compiling = LongCompile(monkeypatch)
    thread = threading.Thread(target=vrep.simxRemoveObject, args=(one, cart, BLOCKING))
    thread.start()
    assert compiling.begun.wait(TIMEOUT)
    code = vrep.simxGetObjectHandle(other, "base", BLOCKING)[0]
    compiling.go_on.set()
    thread.join(TIMEOUT)
    assert code == vrep.simx_return_remote_error_flag, (
        "it was read and refused, not left until the compile was done"
    )
