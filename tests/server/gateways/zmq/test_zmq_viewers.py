"""Viewers of the ZeroMQ remote API: they read, and change nothing."""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Iterator
from pathlib import Path

import pytest
from zmq_world import ZmqWorld, zmq_world

from simx_server import sim_api as api
from simx_server.errors import CommandError
from simx_server.gateways.zmq.functions import described
from simx_server.gateways.zmq.gateway import ZmqGateway
from simx_server.recording import state
from simx_server.scripting.interpreter import ScriptError
from simx_server.scripting.script import Script, ScriptKind
from simx_server.sim_api.namespaces import Namespaces, signatures

READING = sorted(
    f"{space}.{name}"
    for space in api.NAMESPACES
    for name in signatures(space)
    if described(f"{space}.{name}").only_reads
)


@pytest.fixture
def viewed(tmp_path: Path) -> Iterator[ZmqWorld]:
    """A server with a second port, at which the clients of the test connect."""
    with zmq_world(tmp_path) as server:
        gateway = server.on_server(lambda: ZmqGateway(server.loop.service, "127.0.0.1:0", may_only_read=True))
        server.port = gateway.port
        yield server
        server.close_clients()
        server.on_server(gateway.close)


def test_a_viewer_passes_no_functions(viewed: ZmqWorld) -> None:
    """All others would wait for them."""
    viewer = viewed.raw()
    for arguments in ([0, "slow@func"], [[-1, "slow@func"]], [{"callback": "slow@func"}]):
        answer = viewer.ask("sim.visitTree", *arguments)
        assert "passes no functions" in answer.get("err", ""), answer


def test_a_viewer_reads_and_changes_nothing(viewed: ZmqWorld) -> None:
    sim = viewed.sim()
    box = sim.getObject("/box")
    assert sim.getObjectPosition(box) == pytest.approx([1, 0, 0.5])
    assert sim.getSimulationState() == sim.simulation_stopped
    for change in (
        lambda: sim.setObjectPosition(box, [0, 0, 0]),
        lambda: sim.startSimulation(),
        lambda: sim.setStepping(True),
        lambda: sim.acquireLock(),
        lambda: sim.removeObjects([box]),
        lambda: sim.callScriptFunction("double", box, 1),
    ):
        with pytest.raises(Exception, match=r"may change something, and .* is a viewer, who may only read"):
            change()
    assert sim.getObjectPosition(box) == pytest.approx([1, 0, 0.5])
    roles = viewed.on_server(
        lambda: [each.may_only_read for each in viewed.loop.service.clients.sessions.values()]
    )
    assert roles == [True]


def test_there_are_functions_for_viewers() -> None:
    assert len(READING) > 250


def test_functions_of_viewers_change_nothing_whatever_their_arguments(viewed: ZmqWorld) -> None:
    """Each is called with many arguments on the server's thread; most are refused, and none leaves a trace."""

    def call_all() -> list[str]:
        world = viewed.world.parts
        namespaces = Namespaces(world, Script(1, ScriptKind.CUSTOMIZATION, -1, "test"))
        handles = list(world.simulation.scene.objects)[:6]
        singles = [*handles, -1, 0, 1, b"/box", b"a", [0.0] * 7, [0.0] * 12]
        wanted = [
            (),
            *((each,) for each in singles),
            *itertools.product(handles, (-1, 0, b"a")),
            *((h, -1, 0) for h in handles),
        ]
        before, guilty = (
            (state.digests(world), world.simulation.model_version, list(world.simulation.scene.objects)),
            [],
        )
        for name in READING:
            for arguments in wanted:
                with contextlib.suppress(CommandError, ScriptError):
                    namespaces.invoke(name, list(arguments))
            after = state.digests(world), world.simulation.model_version, list(world.simulation.scene.objects)
            if after != before:
                guilty.append(name)
                before = after
        return guilty

    assert viewed.on_server(call_all) == []
