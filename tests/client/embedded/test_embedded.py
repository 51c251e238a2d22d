"""Embedded simulations: a client and its world in one process, in real time, threads and stepped mode."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from launching import simx_run
from processes import PENDULUM, finished, wait_until

import simx_client as v
from simx_client.client import Client
from simx_client.connection.clients import CLIENTS
from simx_client.connection.embedded import EmbeddedConnection
from simx_client.connection.embedding import VARIABLE, as_arguments
from simx_client.errors import ConnectionFailed
from simx_server.gateways.embedded import transport

BLOCKING, BUFFER = v.simx_opmode_blocking, v.simx_opmode_buffer


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    file = tmp_path / "pendulum.xml"
    file.write_text(PENDULUM)
    return file


@pytest.fixture
def in_process(scene: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[int]:
    """A client made by simxStart, with a simulation as fast as possible."""
    monkeypatch.setenv(VARIABLE, f"'{scene}' --speed max")
    client = v.simxStart("127.0.0.1", 19997, True, True, 5000, 5)
    assert client >= 0
    yield client
    CLIENTS.end()


def trajectory(client: int) -> list[float]:
    """Positions of twenty stepped passes with a changing target."""
    hinge = v.simxGetObjectHandle(client, "hinge", BLOCKING)[1]
    v.simxGetJointPosition(client, hinge, v.simx_opmode_streaming)
    assert v.simxSynchronous(client, True) == 0
    assert v.simxStartSimulation(client, BLOCKING) == 0
    found: list[float] = []
    for step in range(20):
        v.simxSetJointTargetVelocity(client, hinge, 0.3 * (step % 5), v.simx_opmode_oneshot)
        assert v.simxSynchronousTrigger(client) == 0
        found.append(v.simxGetJointPosition(client, hinge, BUFFER)[1])
    assert v.simxStopSimulation(client, BLOCKING) == 0
    return found


def test_a_run_is_equal_to_one_over_the_network_bit_for_bit(in_process: int, scene: Path) -> None:
    from processes import server

    here = trajectory(in_process)
    with server(scene) as process, Client("127.0.0.1", process.port) as there:
        assert trajectory(there.id) == here
    assert trajectory(in_process) == here, "a stop restores the exact state"


def test_streams_of_a_stopped_simulation_show_what_was_set(in_process: int) -> None:
    hinge = v.simxGetObjectHandle(in_process, "hinge", BLOCKING)[1]
    assert v.simxGetJointPosition(in_process, hinge, v.simx_opmode_streaming)[0] == v.simx_return_novalue_flag
    assert v.simxGetJointPosition(in_process, hinge, BUFFER) == (0, 0.0)
    v.simxSetJointPosition(in_process, hinge, 0.5, v.simx_opmode_oneshot)
    assert wait_until(lambda: v.simxGetJointPosition(in_process, hinge, BUFFER) == (0, 0.5), 5.0)


def test_time_passes_without_calls_while_the_simulation_runs(in_process: int) -> None:
    assert v.simxStartSimulation(in_process, BLOCKING) == 0

    def simulated() -> int:
        v.simxGetObjects(in_process, v.sim_handle_all, BLOCKING)
        return v.simxGetLastCmdTime(in_process)

    assert wait_until(lambda: simulated() > 2000, 10.0)
    assert v.simxPauseSimulation(in_process, BLOCKING) == 0
    paused = simulated()
    assert simulated() == paused
    v.simxStopSimulation(in_process, BLOCKING)


def test_several_connections_lead_to_one_simulation_which_outlives_them(in_process: int) -> None:
    second = v.simxStart("localhost", 19998, True, True, 5000, 5)
    assert v.simxSetIntegerSignal(in_process, "number", 7, BLOCKING) == 0
    assert v.simxGetIntegerSignal(second, "number", BLOCKING) == (0, 7)
    v.simxFinish(-1)
    third = v.simxStart("127.0.0.1", 19997, True, True, 5000, 5)
    assert v.simxGetIntegerSignal(third, "number", BLOCKING) == (0, 7)


def test_connecting_by_the_temporary_port_starts_the_simulation(
    scene: Path, monkeypatch: pytest.MonkeyPatch, in_process: int
) -> None:
    client = v.simxStart("127.0.0.1", 19999, True, True, 5000, 5)
    code, state = v.simxGetInMessageInfo(client, v.simx_headeroffset_server_state)
    v.simxGetObjects(client, v.sim_handle_all, BLOCKING)
    code, state = v.simxGetInMessageInfo(client, v.simx_headeroffset_server_state)
    assert (code, state & 1) == (1, 1)


def test_two_steppers_in_threads_wait_for_each_other(in_process: int) -> None:
    clients = [in_process, v.simxStart("localhost", 19998, True, True, 5000, 5)]
    for client in clients:
        assert v.simxSynchronous(client, True) == 0
    assert v.simxStartSimulation(in_process, BLOCKING) == 0
    codes: list[int] = []

    def step(client: int) -> None:
        codes.extend(v.simxSynchronousTrigger(client) for _ in range(50))

    threads = [threading.Thread(target=step, args=(client,)) for client in clients]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(30)
    assert codes == [0] * 100
    v.simxGetObjects(in_process, v.sim_handle_all, BLOCKING)
    assert v.simxGetLastCmdTime(in_process) == 50 * 50


def test_worlds_of_one_process_are_independent(scene: Path) -> None:
    with Client.embedded(scene) as one, Client.embedded(scene, time_step=0.01) as other:
        assert trajectory(one.id) != trajectory(other.id)
        v.simxSetIntegerSignal(one.id, "number", 1, BLOCKING)
        assert v.simxGetIntegerSignal(other.id, "number", BLOCKING)[0] == v.simx_return_remote_error_flag


def test_the_modern_client_works_embedded(scene: Path) -> None:
    with Client.embedded(scene, speed="max") as client:
        hinge = client.joint("hinge")
        with client.stepping(lambda: hinge.position) as step:
            for _ in range(5):
                hinge.target_velocity = 1.0
                step()
            assert step.latest > 0.1
        assert "in this process" in repr(client)
    assert "closed" in repr(client)


def test_images_are_the_right_way_up_and_come_by_all_modes(tmp_path: Path) -> None:
    with Client.embedded("ur5_rg2_kinect", timeout=60.0) as client:
        camera = v.simxGetObjectHandle(client.id, "kinect_rgb", BLOCKING)[1]
        code, size, image = v.simxGetVisionSensorImage(client.id, camera, 0, BLOCKING)
        assert (code, size, len(image)) == (0, [640, 480], 640 * 480 * 3)
        v.simxGetVisionSensorImage(client.id, camera, 0, v.simx_opmode_streaming)
        streamed: list[object] = []

        def has_come() -> bool:
            code, _, found = v.simxGetVisionSensorImage(client.id, camera, 0, BUFFER)
            streamed[:] = found
            return code == 0

        assert wait_until(has_come, 20.0)
        assert streamed == list(image)


def test_other_processes_can_join(scene: Path) -> None:
    with Client.embedded(scene, port=0, speed="max") as client:
        port = client.embedded_ports[0]
        v.simxSetIntegerSignal(client.id, "number", 5, BLOCKING)
        program = (
            f"import simx_client as v; c = v.simxStart('127.0.0.1', {port}, True, True, 5000, 5)\n"
            "print(v.simxGetIntegerSignal(c, 'number', v.simx_opmode_blocking))\n"
            "v.simxSetIntegerSignal(c, 'number', 6, v.simx_opmode_blocking); v.simxFinish(c)\n"
        )
        done = finished("-c", program)
        assert done.stdout == "(0, 5)\n", done.stderr
        assert v.simxGetIntegerSignal(client.id, "number", BLOCKING) == (0, 6)


def test_what_was_recorded_embedded_replays(scene: Path, tmp_path: Path) -> None:
    recording = tmp_path / "run.simxlog"
    with Client.embedded(scene, record=recording) as client:
        trajectory(client.id)
    done = finished("-m", "simx_server", "--replay", recording)
    assert done.returncode == 0, done.stderr
    assert "is equal" in done.stderr


def test_a_recorded_step_goes_on_at_once(
    scene: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Calls after a trigger in one batch wait for nothing but the step."""
    monkeypatch.setattr(transport, "_MOST_WAITED", 1000.0)  # seconds: the next look would come too late
    with Client.embedded(scene, record=tmp_path / "run.simxlog") as client:
        hinge = client.joint("hinge")
        with client.stepping(lambda: hinge.position) as step:
            assert step() == hinge.position
            assert step() == hinge.position


def test_a_child_made_by_fork_can_have_a_simulation_too(scene: Path) -> None:
    program = (
        "import os, sys; from simx_client.client import Client\n"
        f"first = Client.embedded({str(scene)!r})\n"
        "child = os.fork()\n"
        "if not child:\n"
        f"    with Client.embedded({str(scene)!r}) as mine: os._exit(0 if mine.joint('hinge').position == 0 else 1)\n"
        "sys.exit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))\n"
    )
    done = finished("-c", program)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"scene": "no such scene"}, "no scene 'no such scene'"),
        ({"scene": None, "spede": 3}, "--spede"),
        ({"scene": None, "count": 3}, "--count is for a simx-server"),
        ({"scene": None, "time_step": "long"}, "time-step"),
    ],
)
def test_bad_settings_say_what_is_wrong(given: dict[str, object], said: str) -> None:
    with pytest.raises(ConnectionFailed, match=said):
        Client.embedded(**given)  # type: ignore[arg-type]


def test_settings_become_flags() -> None:
    settings = {"speed": float("inf"), "start": True, "auto_start": False, "port": [1, 2], "record": None}
    assert as_arguments("a.xml", settings) == [
        "a.xml", "--speed", "max", "--start", "--no-auto-start", "--port", "1", "--port", "2",
    ]  # fmt: skip


SCRIPT = """
import vrep
client = vrep.simxStart('127.0.0.1', 19997, True, True, 5000, 5)
code, hinge = vrep.simxGetObjectHandle(client, 'hinge', vrep.simx_opmode_oneshot_wait)
vrep.simxSynchronous(client, True)
vrep.simxStartSimulation(client, vrep.simx_opmode_oneshot)
for _ in range(10):
    vrep.simxSetJointTargetVelocity(client, hinge, 1.0, vrep.simx_opmode_oneshot)
    vrep.simxSynchronousTrigger(client)
print(code, vrep.simxGetJointPosition(client, hinge, vrep.simx_opmode_oneshot_wait)[1] > 0.1)
"""


def test_simx_run_embeds_an_old_script(scene: Path, tmp_path: Path) -> None:
    finished = simx_run(tmp_path, SCRIPT, flags=("--embed", str(scene)))
    assert (finished.returncode, finished.stdout) == (0, "0 True\n"), finished.stderr


def test_simx_run_refuses_a_server_and_an_embedded_simulation(scene: Path, tmp_path: Path) -> None:
    finished = simx_run(tmp_path, SCRIPT, flags=("--embed", str(scene), "--server", str(scene)))
    assert finished.returncode == 2
    assert "exclude each other" in finished.stderr


def test_a_scene_beside_the_script_is_found_and_its_path_may_have_spaces(tmp_path: Path) -> None:
    folder = tmp_path / "my project"
    folder.mkdir()
    (folder / "lab one.xml").write_text(PENDULUM)
    finished = simx_run(folder, SCRIPT, flags=("--embed", "lab one.xml"))
    assert (finished.returncode, finished.stdout) == (0, "0 True\n"), finished.stderr


@pytest.mark.parametrize(
    "call", [v.simxGetPingTime, v.simxSynchronousTrigger, lambda c: v.simxGetObjects(c, 0, BLOCKING)]
)
def test_ctrl_c_between_taking_a_turn_and_its_work_leaves_the_simulation_usable(
    in_process: int, call: Callable[[int], object]
) -> None:
    assert v.simxSynchronous(in_process, True) == 0
    assert v.simxStartSimulation(in_process, BLOCKING) == 0
    connection = CLIENTS.get(in_process)
    assert isinstance(connection, EmbeddedConnection)
    turns: Any = connection._direct
    assert turns._turns.lock.acquire(), "as Ctrl-C leaves it"
    call(in_process)
    with ThreadPoolExecutor(1) as other:
        assert other.submit(v.simxGetObjectHandle, in_process, "hinge", BLOCKING).result(20.0)[0] == 0


def test_an_interrupted_wait_leaves_the_simulation_usable(in_process: int) -> None:
    """Ctrl-C in a loop that reads."""
    deadline = time.monotonic() + 20.0
    timer = threading.Timer(0.3, os.kill, (os.getpid(), 2))
    timer.start()
    v.simxStartSimulation(in_process, BLOCKING)

    def read() -> None:
        while time.monotonic() < deadline:
            v.simxGetObjects(in_process, v.sim_handle_all, BLOCKING)

    with pytest.raises(KeyboardInterrupt):
        read()
    timer.join()
    assert v.simxGetObjectHandle(in_process, "hinge", BLOCKING)[0] == 0
    assert v.simxStopSimulation(in_process, BLOCKING) == 0
