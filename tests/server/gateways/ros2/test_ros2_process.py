"""The flag --ros2 of a real server, and of an embedded simulation."""

from __future__ import annotations

from pathlib import Path

import pytest
from processes import finished
from processes import server as server_process
from ros2_world import CLOCK, JOINT_STATE, SCENE, Peer, free_port

from simx_server.app.embedding import start

pytestmark = pytest.mark.slow


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "scene.xml"
    path.write_text(SCENE, encoding="utf-8")
    return path


def test_a_server_names_its_router_and_serves_there_in_its_domain(scene: Path) -> None:
    port = free_port()
    router = f"self=tcp/127.0.0.1:{port}"
    with server_process(
        scene, "--ros2", "7", "--ros2-namespace", "/arm", "--ros2-router", router, "--speed", "max"
    ) as started:
        assert f" ros2/router/tcp/127.0.0.1:{port} " in started.ready
        peer = Peer(port)
        peer.watch(7)
        peer.wait_for_token(lambda token: "%arm%simx%start" in token)
        peer.listen(f"7/arm/clock/{CLOCK}")
        assert peer.trigger("start", "7/arm/simx")["success"]
        assert peer.next(f"7/arm/clock/{CLOCK}", lambda sent: sent.value["clock"]["sec"] > 2)
        started.process.terminate()
        assert started.process.wait(20) == 0
        peer.wait_for_no_token()
        peer.close()


def test_a_server_ends_when_the_standard_state_quitting_is_set(scene: Path) -> None:
    port = free_port()
    with server_process(
        scene, "--ros2", "0", "--ros2-router", f"self=tcp/127.0.0.1:{port}", "--start"
    ) as started:
        peer = Peer(port)
        peer.watch()
        peer.wait_for_token(lambda token: "%set_simulation_state" in token)
        answer = peer.call_standard("SetSimulationState", "set_simulation_state", state={"state": 3})
        assert answer["result"]["result"] == 1
        assert started.process.wait(20) == 0
        peer.close()


def test_a_taken_port_ends_the_server_with_advice(scene: Path) -> None:
    port = free_port()
    arguments = [str(scene), "--port", "0", "--ros2", "--ros2-router", f"self=tcp/127.0.0.1:{port}"]
    with server_process(scene, "--ros2", "0", "--ros2-router", f"self=tcp/127.0.0.1:{port}"):
        done = finished("-m", "simx_server", *arguments)
    assert done.returncode == 1
    assert "--ros2-router self cannot listen" in done.stderr


def test_an_embedded_simulation_is_a_node_too(scene: Path) -> None:
    port = free_port()
    arguments = [str(scene), "--port", "0", "--ros2", "3", "--ros2-router", f"self=tcp/127.0.0.1:{port}"]
    server = start([*arguments, "--speed", "max"])
    peer = Peer(port)
    try:
        peer.watch(3)
        peer.wait_for_token(lambda token: "%simx%start" in token)
        peer.listen(f"3/clock/{CLOCK}")
        assert peer.trigger("start", "3/simx")["success"]
        assert peer.next(f"3/clock/{CLOCK}", lambda sent: sent.value["clock"]["sec"] > 2)
    finally:
        server.close()
    peer.wait_for_no_token()
    peer.close()


def test_a_recording_of_a_server_is_replayed_without_ros(scene: Path, tmp_path: Path) -> None:
    port, recording = free_port(), tmp_path / "run.simxlog"
    router = f"self=tcp/127.0.0.1:{port}"
    with server_process(
        scene, "--ros2", "0", "--ros2-router", router, "--speed", "max", "--record", recording
    ) as started:
        peer = Peer(port)
        peer.watch()
        peer.wait_for_token(lambda token: "%simx%start" in token)
        joints = f"0/joint_states/{JOINT_STATE}"
        peer.listen(joints)
        assert peer.trigger("start")["success"]
        peer.command(["shoulder"], position=[0.4])
        peer.next(joints, lambda sent: abs(sent.value["position"][0] - 0.4) < 0.05)
        peer.close()
        started.process.terminate()
        assert started.process.wait(20) == 0
    done = finished("-m", "simx_server", "--replay", recording)
    assert done.returncode == 0, done.stderr
    assert "is equal" in done.stderr
