"""Other versions of the official client, its asyncio variant, both CBOR packages, and a program like its example."""

from __future__ import annotations

import asyncio
import gc
import importlib
import sys
from collections.abc import Iterator
from types import ModuleType
from typing import Any

import pytest
from other_clients import client_folder, install_line
from zmq_world import INSTALL, TIMEOUT, RawClient, ZmqGateway, ZmqWorld, cbor2, zmq

NAME = "coppeliasim_zmqremoteapi_client"
OLDER = ("0.1.0", "2.0.2")


@pytest.fixture
def fresh_modules() -> Iterator[None]:
    """The client is imported again within the test."""
    kept = {name: module for name, module in sys.modules.items() if name.split(".")[0] in (NAME, "cbor2")}
    for name in kept:
        del sys.modules[name]
    yield
    for name in [name for name in sys.modules if name.split(".")[0] in (NAME, "cbor2")]:
        del sys.modules[name]
    sys.modules.update(kept)


def forget() -> None:
    """Delete the clients that nothing uses: they say good-bye, and close their sockets."""
    vars(sys.modules["__main__"]).pop("require", None)  # the client puts a method of its own there
    gc.collect()


def use(package: ModuleType, server: ZmqWorld) -> Any:
    """Connect with a version of the client; do what programs do, and return its sim."""
    client = package.RemoteAPIClient(port=server.port)
    client.socket.setsockopt(zmq.RCVTIMEO, TIMEOUT)
    sim = client.require("sim") if hasattr(client, "require") else client.getObject("sim")
    client.setStepping(True)
    sim.startSimulation()
    while sim.getSimulationTime() < 0.5:
        client.step()
    assert sim.getObjectPosition(sim.getObject("/nose"), sim.handle_world) == pytest.approx([0, 0, 3])
    with pytest.raises(Exception, match="object does not exist"):
        sim.getObject("/nix")
    sim.stopSimulation()
    while sim.getSimulationState() != sim.simulation_stopped:
        pass
    return sim


@pytest.mark.parametrize("version", OLDER)
@pytest.mark.usefixtures("fresh_modules")
def test_older_clients_work(server: ZmqWorld, version: str, monkeypatch: pytest.MonkeyPatch) -> None:
    requirement = f"{NAME.replace('_', '-')}=={version}"
    folder = client_folder(requirement)
    if not folder.is_dir():
        pytest.skip(install_line(requirement))
    monkeypatch.syspath_prepend(str(folder))
    package = importlib.import_module(NAME)
    assert str(folder) in str(package.__file__)
    use(package, server)
    forget()
    assert server.wait_until(lambda: not server.loop.service.clients.sessions)


@pytest.mark.usefixtures("fresh_modules")
def test_the_client_works_with_the_package_that_pip_brings(
    server: ZmqWorld, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("cbor", reason=INSTALL)
    pytest.importorskip(NAME, reason=INSTALL)
    del sys.modules[NAME]
    monkeypatch.setitem(sys.modules, "cbor2", None)
    package = importlib.import_module(NAME)
    assert package.cbor.__name__ == "cbor"
    sim = use(package, server)
    assert sim.unpackDoubleTable(sim.packDoubleTable([1.5, 2.5])) == [1.5, 2.5]
    del sim
    forget()
    assert server.wait_until(lambda: not server.loop.service.clients.sessions)


def test_arrays_of_numpy_travel_where_the_client_can_write_them(server: ZmqWorld) -> None:
    import numpy as np

    sim = server.sim()
    box = sim.getObject("/box")
    sim.setObjectPosition(box, np.array([1.0, 2.0, 3.0]), sim.handle_world)
    assert sim.getObjectPosition(box, sim.handle_world) == pytest.approx([1, 2, 3])
    sim.setObjectPosition(box, [np.float32(1.0), np.float64(0.0), 0.5], sim.handle_world)


def test_many_calls_at_a_time_of_an_asyncio_client(server: ZmqWorld) -> None:
    package = pytest.importorskip(f"{NAME}.asyncio", reason=INSTALL)

    async def program() -> tuple[list[int], float]:
        async with package.RemoteAPIClient(port=server.port) as client:
            sim = await client.getObject("sim")
            dummies = await asyncio.gather(*[sim.createDummy(0.01) for _ in range(50)])
            await sim.setStepping(True)
            await sim.startSimulation()
            for _ in range(4):
                await sim.step()
            time = await sim.getSimulationTime()
            await sim.stopSimulation()
            await sim.removeObjects(dummies)
            return dummies, time

    dummies, time = asyncio.run(asyncio.wait_for(program(), TIMEOUT / 1000))
    assert len(set(dummies)) == 50
    assert time == pytest.approx(0.2)
    assert server.wait_until(lambda: not server.loop.service.clients.sessions)


def test_a_call_whose_answer_was_lost_in_a_crash_ends_with_the_reason(server: ZmqWorld) -> None:
    context = zmq.Context()
    crashed = context.socket(zmq.ROUTER)
    port = crashed.bind_to_random_port("tcp://127.0.0.1")
    client = RawClient(port)
    client.send("sim.getSimulationTime")
    crashed.recv_multipart()
    context.destroy(linger=0)
    server.loop.service.returning.expect({}, "the server crashed")
    successor = server.on_server(lambda: ZmqGateway(server.loop.service, f"127.0.0.1:{port}"))
    assert cbor2.loads(client.socket.recv()) == {"err": "the server crashed"}
    assert client.ask("sim.getSimulationTime") == {"ret": [0.0]}
    client.close()
    server.on_server(successor.close)


def test_a_program_like_the_simplest_example(server: ZmqWorld) -> None:
    """Objects are made and moved, a free run is watched, a stepped one is made, all is removed."""
    client = server.client()
    sim = client.require("sim")
    before = sim.getInt32Param(sim.intparam_idle_fps)
    sim.setInt32Param(sim.intparam_idle_fps, 0)
    handles = [sim.createDummy(0.01, 12 * [0]) for _ in range(20)]
    for index, handle in enumerate(handles):
        sim.setObjectPosition(handle, -1, [0.01 * index, 0.01 * index, 0.01 * index])
    client.setStepping(False)
    sim.startSimulation()
    while sim.getSimulationTime() < 0.3:
        sim.addLog(1, f"simulation time: {sim.getSimulationTime():.2f} [s]")
    sim.stopSimulation()
    while sim.getSimulationState() != sim.simulation_stopped:
        pass
    client.setStepping(True)
    sim.startSimulation()
    steps = 0
    while sim.getSimulationTime() < 1.0 - 1e-9:
        client.step()
        steps += 1
    assert steps == 20
    sim.stopSimulation()
    sim.removeObjects(handles)
    sim.setInt32Param(sim.intparam_idle_fps, before)
