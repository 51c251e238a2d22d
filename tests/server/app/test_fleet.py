"""Several servers by one command: each with its own ports and name, watched and ended together."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from forked import Forked
from processes import read_line, running, wait_until

import simx_client as v
from simx_server.settings.derived import of_member
from simx_server.settings.gathering import gather
from simx_server.settings.rules import SettingError

BLOCKING = v.simx_opmode_blocking
TIMEOUT = 20.0
COUNTING = """
<mujoco>
  <worldbody><body name="box"><geom size="0.1"/></body></worldbody>
  <custom><text name="simx:script:customization:box" data="file=count.py"/></custom>
</mujoco>
"""
COUNT = """
calls = 0

def count(ints, floats, strings, buffer):
    global calls
    calls += 1
    return [calls], [], [], b""
"""
MEGABYTE = 1024  # in the kilobytes of /proc

pytestmark = [
    pytest.mark.slow,
    pytest.mark.gl,
    pytest.mark.skipif(not hasattr(os, "fork"), reason="this system cannot fork"),
    pytest.mark.usefixtures("no_connection_left"),
]


@dataclass
class FleetProcess:
    process: subprocess.Popen[str]
    servers: list[dict[str, Any]]
    log: Path

    @property
    def children(self) -> list[int]:
        return [server["pid"] for server in self.servers]

    def are_gone(self) -> bool:
        return not any(_is_alive(process_id) for process_id in self.children)

    def says(self, text: str) -> bool:
        return text in self.log.read_text()

    def end(self, number: signal.Signals = signal.SIGTERM) -> int:
        self.process.send_signal(number)
        return self.process.wait(TIMEOUT)


def _is_alive(process_id: int) -> bool:
    try:
        os.kill(process_id, 0)
        # A child whose parent was killed is nobody's to wait for, until the system's first process does.
        return ") Z " not in Path(f"/proc/{process_id}/stat").read_text()
    except ProcessLookupError:  # it may go between the two looks
        return False
    except FileNotFoundError:
        return not Path("/proc").is_dir()


@contextlib.contextmanager
def spawned(log: Path, *arguments: object) -> Iterator[subprocess.Popen[str]]:
    with log.open("w") as errors:
        process = Forked(
            ("-m", "simx_server", *arguments),
            stdout=subprocess.PIPE,
            stderr=errors,
            start_new_session=True,
        )
    with running(process):
        yield process


@contextlib.contextmanager
def fleet(log: Path, *arguments: object) -> Iterator[FleetProcess]:
    """A fleet on free ports, once it is ready."""
    with spawned(log, *arguments, "--port", 0) as process:
        line = read_line(process)
        assert line, log.read_text()
        servers = json.loads(line)["servers"]
        yield FleetProcess(process, servers, log)


@pytest.fixture
def log(tmp_path: Path) -> Path:
    return tmp_path / "log"


def _hinge(port: int) -> int:
    client = v.simxStart("127.0.0.1", port, True, True, 5000, 5)
    handle = v.simxGetObjectHandle(client, "hinge", BLOCKING)[1]
    return v.simxGetJointPosition(client, handle, BLOCKING)[0]


def test_a_line_of_json_tells_where_all_of_them_are_when_they_can_be_reached(scene: Path, log: Path) -> None:
    with fleet(log, scene, "--count", 3, "--port", 0, "--realm", "lab") as started:
        assert [server["realm"] for server in started.servers] == ["lab-0", "lab-1", "lab-2"]
        ports = [port for server in started.servers for port in server["ports"]]
        assert len(set(ports)) == 6
        assert len({*started.children, started.process.pid}) == 4
        assert all(_hinge(port) == v.simx_return_ok for port in ports)
        assert started.servers[0]["endpoints"] == [f"tcp/127.0.0.1:{port}" for port in ports[:2]]
        assert started.servers[0]["scene"] == "pendulum"


def test_each_is_a_world_of_its_own(scene: Path, log: Path) -> None:
    with fleet(log, scene, "--count", 2) as started:
        first, second = (
            v.simxStart("127.0.0.1", server["ports"][0], True, True, 5000, 5) for server in started.servers
        )
        assert v.simxStartSimulation(first, BLOCKING) == v.simx_return_ok
        v.simxSetIntegerSignal(first, "mine", 1, BLOCKING)
        assert v.simxGetIntegerSignal(first, "mine", BLOCKING) == (0, 1)
        assert v.simxGetIntegerSignal(second, "mine", BLOCKING)[0] != 0

        def is_running(client: int) -> bool:
            v.simxGetPingTime(client)
            return bool(v.simxGetInMessageInfo(client, v.simx_headeroffset_server_state)[1] & 1)

        assert is_running(first)
        assert not is_running(second)


@pytest.mark.skipif(sys.platform != "linux", reason="scripts in Python run on Linux only")
def test_a_script_that_lives_from_the_start_is_each_servers_own(tmp_path: Path, log: Path) -> None:
    (tmp_path / "count.py").write_text(COUNT)
    scene = tmp_path / "scene.xml"
    scene.write_text(COUNTING)
    with fleet(log, scene, "--count", 2) as started:
        for server in started.servers:
            client = v.simxStart("127.0.0.1", server["ports"][0], True, True, 5000, 5)
            for expected in (1, 2):
                result = v.simxCallScriptFunction(client, "box", 6, "count", [], [], [], b"", BLOCKING)
                assert result[:2] == (v.simx_return_ok, [expected]), log.read_text()


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_ending_the_command_ends_all(number: signal.Signals, scene: Path, log: Path) -> None:
    with fleet(log, scene, "--count", 2, "--start") as started:
        assert started.end(number) == 0
        assert started.are_gone()
        assert started.process.stdout is not None
        assert started.process.stdout.read() == ""


def test_ctrl_c_in_a_terminal_ends_all_cleanly(scene: Path, log: Path) -> None:
    with fleet(log, scene, "--count", 2) as started:
        os.killpg(started.process.pid, signal.SIGINT)  # what a terminal does
        assert started.process.wait(TIMEOUT) == 0
        assert started.are_gone()


def test_one_that_dies_is_told_and_the_others_go_on(scene: Path, log: Path) -> None:
    with fleet(log, scene, "--count", 3, "--realm", "lab", "--no-supervised") as started:
        os.kill(started.children[1], signal.SIGKILL)
        assert wait_until(lambda: started.says("ended by signal 9 (SIGKILL); 2 of 3 go on"), TIMEOUT)
        assert started.says(f"server 1 (realm lab-1), process {started.children[1]}")
        for number in (0, 2):
            assert _hinge(started.servers[number]["ports"][0]) == v.simx_return_ok
        v.simxFinish(-1)
        assert started.end() == 1


def test_a_frozen_one_does_not_keep_the_others_from_ending(scene: Path, log: Path) -> None:
    with fleet(log, scene, "--count", 2) as started:
        os.kill(started.children[0], signal.SIGSTOP)
        started.process.send_signal(signal.SIGTERM)
        assert wait_until(lambda: not _is_alive(started.children[1]), TIMEOUT)
        assert started.end() == 130  # the second signal ends what is left at once
        assert started.are_gone()


def test_none_outlives_the_command_even_when_that_is_killed(scene: Path, log: Path) -> None:
    with fleet(log, scene, "--count", 2) as started:
        started.process.kill()
        assert wait_until(started.are_gone, TIMEOUT)


def test_it_ends_by_itself_when_all_have_ended_well(scene: Path, log: Path) -> None:
    with fleet(log, scene, "--count", 2, "--duration", 2.0) as started:
        assert started.process.wait(TIMEOUT) == 0
        assert started.says("ended with exit code 0; 0 of 2 go on")


def test_a_port_that_is_taken_ends_all_before_anything_is_listed(scene: Path, log: Path) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with spawned(log, scene, "--count", 2, "--port", port - 1) as process:
            assert process.wait(TIMEOUT) == 1
            assert process.stdout is not None
            assert process.stdout.read() == ""
        text = log.read_text()
        assert f"port {port} is taken" in text or f"port {port - 1} is taken" in text
        assert "not all servers got ready, so all are ended" in text


def test_a_scene_that_cannot_be_used_is_told_once(log: Path) -> None:
    with spawned(log, "no_such_scene", "--count", 3, "--port", 0) as process:
        assert process.wait(TIMEOUT) == 1
    assert log.read_text().count("no_such_scene") == 1


@pytest.mark.skipif(not Path("/proc/self/smaps_rollup").exists(), reason="memory is told by Linux only")
def test_a_further_server_takes_little_memory(log: Path) -> None:
    def private(process_id: int) -> int:
        lines = Path(f"/proc/{process_id}/smaps_rollup").read_text().splitlines()
        sizes = {line.split(":")[0]: int(line.split()[1]) for line in lines[1:]}
        return sizes["Private_Clean"] + sizes["Private_Dirty"]

    with fleet(log, "ur5_rg2_kinect", "--count", 3, "--start") as started:
        assert all(private(process_id) < 60 * MEGABYTE for process_id in started.children)


def test_an_image_can_be_had_from_each(log: Path) -> None:
    with fleet(log, "ur5_rg2_kinect", "--count", 2) as started:
        for server in started.servers:
            client = v.simxStart("127.0.0.1", server["ports"][0], True, True, 5000, 5)
            camera = v.simxGetObjectHandle(client, "kinect_rgb", BLOCKING)[1]
            code, resolution, image = v.simxGetVisionSensorImage(client, camera, 0, BLOCKING)
            assert code == v.simx_return_ok
            assert len(image) == resolution[0] * resolution[1] * 3


def test_ports_of_the_next_follow_those_of_the_one_before() -> None:
    settings = gather({"count": "3", "realm": "lab"}, {})
    members = [of_member(settings, number) for number in range(3)]
    assert [member.ports for member in members] == [(19997, 19999), (20000, 20002), (20003, 20005)]
    assert [member.temporary_port for member in members] == [19999, 20002, 20005]
    assert [member.realm for member in members] == ["lab-0", "lab-1", "lab-2"]
    assert not any(member.count for member in members)
    single = gather({"count": "3", "ports": ["5000"]}, {})
    assert [of_member(single, number).ports for number in range(3)] == [(5000,), (5001,), (5002,)]
    assert of_member(single, 2).temporary_port == 19999
    free = gather({"count": "2", "ports": ["0", "0"]}, {})
    assert of_member(free, 1).ports == (0, 0)
    assert of_member(free, 1).realm is None


@pytest.mark.parametrize(
    ("flags", "complaint"),
    [
        ({"count": "0"}, "from 1 to 1000"),
        ({"count": "many"}, "from 1 to 1000"),
        ({"count": "2", "listen": ["tcp/0.0.0.0:7447"]}, "--connect to a router"),
        ({"count": "1000", "ports": ["65000"]}, "beyond 65535"),
    ],
)
def test_a_count_that_cannot_be_is_told_with_what_is_valid(flags: dict[str, Any], complaint: str) -> None:
    with pytest.raises(SettingError, match=complaint):
        gather(flags, {})
