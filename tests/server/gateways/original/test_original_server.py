"""A server process with ports for original clients, beside those of this project."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from xml.sax.saxutils import quoteattr

import pytest
from original_library import Library, needs_library
from original_peer import ints, message, packed, peer, text
from processes import PENDULUM, ServerProcess, finished, server, wait_until
from routers import free_port

import simx_client as v

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("no_connection_left")]


def legacy_ports(process: ServerProcess) -> list[int]:
    return [int(each) for each in re.findall(r"legacy/[\d.]+:(\d+)", process.ready)]


@pytest.fixture(scope="module")
def pendulum(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServerProcess]:
    path = tmp_path_factory.mktemp("scene") / "pendulum.xml"
    path.write_text(PENDULUM, encoding="utf-8")
    with server(path, "--legacy-port", 0, "--legacy-port", "127.0.0.2:0") as process:
        yield process


def test_clients_of_both_protocols_share_one_simulation(pendulum: ServerProcess) -> None:
    port = legacy_ports(pendulum)[0]
    client = v.simxStart("127.0.0.1", pendulum.port, True, True, 5000, 5)
    assert v.simxSetIntegerSignal(client, "mark", 7, v.simx_opmode_blocking) == 0
    with peer(port) as original:
        assert original.call(0x3011, text("mark")).payload == ints(7)
        original.call(0x3014, text("mark"), ints(8))
    assert v.simxGetIntegerSignal(client, "mark", v.simx_opmode_blocking) == (0, 8)
    v.simxFinish(client)


def test_status_lists_original_clients_beside_others(pendulum: ServerProcess) -> None:
    with peer(legacy_ports(pendulum)[0]) as original:
        original.call(0x1021, ints(1))
        said = finished("-m", "simx_client", "status", pendulum.port)
    assert "legacy 127.0.0.1" in said.stdout, said.stdout + said.stderr


def test_a_client_of_this_project_at_such_a_port_does_not_connect(pendulum: ServerProcess) -> None:
    assert v.simxStart("127.0.0.1", legacy_ports(pendulum)[0], True, True, 500, 5) == -1
    with peer(legacy_ports(pendulum)[0]) as original:
        assert not original.call(0x1021, ints(1)).has_failed


def test_a_port_that_is_taken_ends_the_start_with_what_to_do(pendulum: ServerProcess) -> None:
    taken = legacy_ports(pendulum)[0]
    done = finished("-m", "simx_server", "two_link_arm", "--port", 0, "--legacy-port", taken)
    assert done.returncode == 1
    assert f"cannot listen at 127.0.0.1:{taken}" in done.stderr
    assert "choose another port with --legacy-port N" in done.stderr


def test_a_server_that_is_open_to_all_warns(tmp_path: Path) -> None:
    (tmp_path / "pendulum.xml").write_text(PENDULUM)
    flags = ("--port", 0, "--duration", 0.1, "--legacy-port", "0.0.0.0:0")
    done = finished("-m", "simx_server", "pendulum.xml", *flags, folder=tmp_path)
    assert done.returncode == 0
    (line,) = [line for line in done.stderr.splitlines() if "WARNING" in line]
    assert "0.0.0.0:" in line
    assert "docs/operators/security.md" in line


def test_a_port_of_a_script_speaks_the_original_protocol_too(tmp_path: Path) -> None:
    port = free_port()
    script = f"function sysCall_init() simRemoteApi.start({port}) end"
    scene = tmp_path / "scene.xml"
    scene.write_text(
        "<mujoco><worldbody><body name='robot'><geom size='0.1'/></body></worldbody>"
        f"<custom><text name='simx:lua:robot' data={quoteattr(script)}/></custom></mujoco>",
        encoding="utf-8",
    )
    with server(scene, "--legacy-port", 0) as process, peer(port) as original:
        assert not original.call(0x1021, ints(1)).has_failed
        with peer(legacy_ports(process)[0]) as other:
            assert wait_until(lambda: other.call(0x1021, ints(1)).time_ms > 0, 20), (
                "it has started the simulation"
            )


def test_the_temporary_port_starts_the_simulation(tmp_path: Path) -> None:
    (tmp_path / "pendulum.xml").write_text(PENDULUM)
    port = free_port()
    flags = ("--legacy-port", port, "--temporary-port", port)
    with server(tmp_path / "pendulum.xml", *flags), peer(port) as original:
        assert wait_until(lambda: original.call(0x1021, ints(1)).time_ms > 0, 20)


def test_a_recording_with_an_original_client_replays(tmp_path: Path) -> None:
    (tmp_path / "pendulum.xml").write_text(PENDULUM)
    record = tmp_path / "run.simx"
    with server(tmp_path / "pendulum.xml", "--legacy-port", 0, "--record", record) as process:
        with peer(legacy_ports(process)[0]) as original:
            hinge = ints(original.handle("hinge"))
            original.call(0x0001)
            original.call(0x1007, ints(0))
            for _ in range(5):
                original.call(0x1008, hinge, b"\0\0\x80?")
                assert not original.call(0x0003).has_failed
            original.call(0x1007, ints(2))
        process.process.terminate()
        process.process.wait(20)
    done = finished("-m", "simx_server", "--replay", record)
    assert done.returncode == 0, done.stderr
    assert "is equal" in done.stderr


@needs_library
def test_the_original_library_drives_a_server_process(pendulum: ServerProcess) -> None:
    client = Library().start(legacy_ports(pendulum)[0])
    hinge = client.handle("hinge")
    client.start_stepped()
    assert client.call("simxSetJointTargetVelocity", hinge, 1.0) == 0
    client.trigger(20)
    code, position = client.number_of("simxGetJointPosition", hinge)
    assert (code, position > 0.1) == (0, True)
    assert client.call("simxStopSimulation") == 0
    client.finish()


def test_a_server_that_ends_ends_the_connection_at_once(tmp_path: Path) -> None:
    (tmp_path / "pendulum.xml").write_text(PENDULUM)
    with (
        server(tmp_path / "pendulum.xml", "--legacy-port", 0) as process,
        peer(legacy_ports(process)[0]) as original,
    ):
        original.socket.sendall(packed(message(0)))
        original.read()
        process.process.terminate()
        assert original.is_cut()
        assert process.process.wait(20) == 0
