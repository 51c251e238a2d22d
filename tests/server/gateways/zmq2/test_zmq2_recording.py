"""Recordings of clients of API 2 replay bit for bit, with the answers of their functions; viewers change nothing."""

from __future__ import annotations

from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from recordings import RecordedWorld, kinds, replay
from zmq2_world import FUNCTION, SCENE, SCENE_HANDLE, SELF, Refused, Zmq2World, cbor2, zmq2_world

from simx_server.gateways.zmq import connection
from simx_server.gateways.zmq2.gateway import Zmq2Gateway
from simx_server.recording.records import Kind

REPLAYED = 0


@contextmanager
def recorded(folder: Path) -> Any:
    """A recorded server with the gateway; yields it and the recording."""
    (folder / "scene.xml").write_text(SCENE, encoding="utf-8")
    file = folder / "run.simxlog"
    opened = Zmq2World(RecordedWorld(folder / "scene.xml", file))
    try:
        yield opened, file
    finally:
        opened.close()


def test_steps_phases_and_functions_are_repeated(tmp_path: Path) -> None:
    with recorded(tmp_path) as (server, file):
        client, other = server.wire(), server.wire()
        hinge, box = client.at("/hinge"), client.at("/box")
        height = [1.0]

        def act() -> None:
            height[0] += 0.01
            client.call(box, "setPosition", [0.0, 0.0, height[0]])

        client.register("sysCall_actuation", act, is_global=True)
        client.call(SELF, "setStepping", True)
        client.call(SCENE_HANDLE, "simulation.start")
        for count in range(10):
            client.call(hinge, "setTargetVelocity", 0.1 * count)
            other.call(SCENE_HANDLE, "setProperty", "signal.count", count, {})
            client.call(SELF, "step")
        client.functions["@tmpcallback_1"] = lambda item: client.call(
            item.value, "setProperty", "position", [0, 0, 5]
        )
        client.call(box, "visitTree", cbor2.CBORTag(FUNCTION, "@tmpcallback_1"))
        client.call(SELF, "wait", 0.2)
        client.call(SCENE_HANDLE, "simulation.stop")
    seen = kinds(file)
    assert Kind.WITHIN in seen
    assert Kind.CONTINUED in seen
    assert replay(file) == REPLAYED


def test_a_client_that_fell_silent_in_its_function_is_repeated(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(connection, "SILENCE", 0.05)
    with recorded(tmp_path) as (server, file):
        silent, other = server.wire(), server.wire()
        silent.register("sysCall_sensing", lambda: None, is_global=True)
        silent.call(SCENE_HANDLE, "simulation.start")
        owed = silent.receive()
        assert server.wait_until(lambda: server.simulation.step_count > 10)
        silent.serve(owed)
        silent.serve(silent.receive())
        other.call(SCENE_HANDLE, "setProperty", "signal.after", 1, {})
        other.call(SCENE_HANDLE, "simulation.stop")
    assert replay(file) == REPLAYED


def test_a_viewer_reads_and_changes_nothing(tmp_path: Path) -> None:
    with zmq2_world(tmp_path) as server:
        gateway = server.on_server(
            lambda: Zmq2Gateway(server.loop.service, "127.0.0.1:0", may_only_read=True)
        )
        server.port = gateway.port
        viewer = server.wire()
        box = viewer.at("/box")
        assert viewer.get(box, "position").value[1][0] == 1.0
        function = cbor2.CBORTag(FUNCTION, "@tmpcallback_1")
        for target, name, arguments in (
            (box, "setProperty", ["position", [0, 0, 0], {}]),
            (box, "remove", []),
            (SCENE_HANDLE, "simulation.start", []),
            (SELF, "setStepping", [True]),
            (SELF, "step", []),
            (SCENE_HANDLE, "createObject", [{"type": "dummy"}]),
            (box, "visitTree", [function]),
        ):
            with pytest.raises(Refused, match="viewer"):
                viewer.call(target, name, *arguments)
        with pytest.raises(Refused, match="viewer"):
            viewer.register("sysCall_sensing", lambda: None, is_global=True)
        server.close_clients()
        server.on_server(gateway.close)
