"""Ports that open and close while the server runs: clients reach the same simulation there."""

from __future__ import annotations

from pathlib import Path
from xml.sax.saxutils import quoteattr

import pytest
from processes import server, wait_until
from routers import free_port

import simx_client as v

pytestmark = pytest.mark.usefixtures("no_connection_left")
pytest.importorskip("lupa")

BLOCKING = v.simx_opmode_blocking


def scene_with(folder: Path, script: str) -> Path:
    path = folder / "scene.xml"
    path.write_text(
        "<mujoco><worldbody><body name='robot'><geom size='0.1'/></body></worldbody>"
        f"<custom><text name='simx:lua:robot' data={quoteattr(script)}/></custom></mujoco>",
        encoding="utf-8",
    )
    return path


def connect(port: int) -> int:
    return v.simxStart("127.0.0.1", port, True, True, 5000, 5)


def test_a_client_that_comes_by_a_named_port_starts_the_simulation_and_stays(tmp_path: Path) -> None:
    port = free_port()
    with server(scene_with(tmp_path, f"function sysCall_init() simRemoteApi.start({port}) end")) as place:
        client, other = connect(port), connect(place.port)
        assert min(client, other) >= 0
        assert v.simxSetIntegerSignal(client, "mark", 7, BLOCKING) == 0
        assert v.simxGetIntegerSignal(other, "mark", BLOCKING) == (0, 7), "both reach one simulation"
        assert v.simxGetInMessageInfo(client, v.simx_headeroffset_server_state)[1] & 1, "the simulation runs"
        assert v.simxStopSimulation(client, BLOCKING) == 0
        assert v.simxGetPingTime(client)[0] == 0
        v.simxFinish(-1)


def test_a_computed_port_closes_with_its_clients_after_the_run(tmp_path: Path) -> None:
    port = free_port()
    script = f"function sysCall_init() simRemoteApi.start({port} + 0) end"
    with server(scene_with(tmp_path, script), "--start") as place:
        client, other = connect(port), connect(place.port)
        assert min(client, other) >= 0
        assert v.simxStopSimulation(client, BLOCKING) == 0, "the answer arrives before the port closes"
        assert wait_until(lambda: v.simxGetConnectionId(client) == -1, 20)
        assert v.simxGetPingTime(other)[0] == 0, "clients of other ports stay"
        v.simxFinish(client)
        assert v.simxStartSimulation(other, BLOCKING) == 0
        assert wait_until(lambda: connect(port) >= 0, 20), "it opens again with the next run"
        v.simxFinish(-1)


def test_a_taken_port_is_a_line_in_the_log_and_the_server_starts(tmp_path: Path) -> None:
    with server(scene_with(tmp_path, "-- no ports")) as first:
        text = f"function sysCall_init() simRemoteApi.start({first.port}) end"
        with server(scene_with(tmp_path, text)) as second:
            client = connect(second.port)
            assert client >= 0
            assert v.simxGetPingTime(client)[0] == 0
            v.simxFinish(-1)


def test_a_server_can_be_told_to_open_no_ports_of_scripts(tmp_path: Path) -> None:
    port = free_port()
    path = scene_with(tmp_path, f"function sysCall_init() simRemoteApi.start({port}) end")
    with server(path, "--no-script-ports", "--start"):
        assert v.simxStart("127.0.0.1", port, True, True, 300, 5) == -1
