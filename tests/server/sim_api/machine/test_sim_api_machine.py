"""Serial ports and programs: used where the operator allows it; a recording has what came from there."""

from __future__ import annotations

import fcntl
import os
import pty
import sys
import termios
import tty
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import NamedTuple

import pytest
from processes import wait_until
from recordings import kinds, recorded, replay, rewrite
from sim_api_calls import ScriptWorld, world

import simx_client as v
from simx_client.protocol.cli.exit_codes import DIVERGED, DONE
from simx_server.errors import CommandError
from simx_server.parts.machine import serial_ports
from simx_server.parts.machine.serial_ports import MOST_BYTES, MOST_PORTS
from simx_server.recording.records import Kind
from simx_server.sim_api import processes

__all__ = ["world"]

BLOCKING = v.simx_opmode_blocking


class Cable(NamedTuple):
    """A pseudo terminal: what is written at one end can be read at the other."""

    end: int
    device: int

    @property
    def port(self) -> str:
        return os.ttyname(self.device)

    def write(self, data: bytes) -> None:
        """Write, and wait until the data has gone through the system's buffers."""
        there = self.waiting() + os.write(self.end, data)
        assert wait_until(lambda: self.waiting() == there, 20.0)

    def waiting(self) -> int:
        return int.from_bytes(fcntl.ioctl(self.device, termios.FIONREAD, bytes(4)), sys.byteorder)

    def read(self) -> bytes:
        return os.read(self.end, 1000)


@pytest.fixture
def cable() -> Iterator[Cable]:
    end, device = pty.openpty()
    tty.setraw(device, termios.TCSANOW)
    yield Cable(end, device)
    os.close(end)
    os.close(device)


@pytest.fixture
def allowed(world: ScriptWorld) -> ScriptWorld:
    world.parts.serial_ports.is_allowed = world.parts.programs.is_allowed = True
    return world


def test_without_the_flag_no_port_opens_and_no_program_starts(world: ScriptWorld, cable: Cable) -> None:
    assert world.value(f"sim.serialOpen('{cable.port}', 9600)") == -1
    assert world.value("sim.launchExecutable('robotClient', '19999 7', 0)") == -1
    port, program = world.parts.status_bar.messages[-2:]
    assert port.endswith(f"without --allow-machine, such as '{cable.port}'")
    assert program.endswith("without --allow-machine: start 'robotClient' yourself (arguments: 19999 7)")


def test_a_script_talks_over_a_serial_port(allowed: ScriptWorld, cable: Cable) -> None:
    pytest.importorskip("serial")
    port = allowed.value(f"sim.serialOpen('{cable.port}', 115200)")
    assert port >= 0
    assert allowed.value(f"sim.serialSend({port}, 'go\\n')") == 3
    assert cable.read() == b"go\n"
    assert allowed.value(f"sim.serialRead({port}, 10, false)") == ""
    cable.write(b"\x00ready;")
    assert allowed.value(f"sim.serialCheck({port})") == 7
    assert allowed.value(f"sim.serialRead({port}, 4, false)") == "\x00rea"
    assert allowed.value(f"sim.serialCheck({port})") == 3
    assert allowed.value(f"simSerialRead({port}, 40)") == "dy;"
    assert allowed.lua(f"return sim.serialClose({port})") in ([], [None])
    allowed.fails(f"sim.serialSend({port}, 'x')", r"no serial port with handle \d+ is open; open are: none")


def test_the_older_names_of_the_functions_of_ports_work_too(allowed: ScriptWorld, cable: Cable) -> None:
    pytest.importorskip("serial")
    port = allowed.value(f"sim.serialPortOpen('{cable.port}', 9600)")
    assert allowed.value(f"sim.serialPortSend({port}, 'go')") == 2
    assert cable.read() == b"go"
    assert allowed.value(f"sim.serialPortRead({port}, 10, false)") == ""
    assert allowed.lua(f"return sim.serialPortClose({port})") in ([], [None])


def test_a_blocking_read_waits_in_a_thread_for_a_whole_piece(allowed: ScriptWorld, cable: Cable) -> None:
    pytest.importorskip("serial")
    port = allowed.value(f"sim.serialOpen('{cable.port}')")
    allowed.fails(f"sim.serialRead({port}, 4, true)", "only in a thread")

    def begin(call: str) -> None:
        allowed.lua(
            f"pieces = {{}} reader = coroutine.create(function() pieces[1] = {call} end) coroutine.resume(reader)"
        )

    def go_on() -> list[str]:
        return allowed.lua("coroutine.resume(reader) return pieces[1]")

    begin(f"sim.serialRead({port}, 4, true)")
    cable.write(b"abc")
    assert go_on() == [None]
    cable.write(b"def")
    assert go_on() == ["abcd"]
    begin(f"sim.serialRead({port}, 100, true, 'g;')")
    cable.write(b"fg;h")
    assert go_on() == ["effg;"]
    begin(f"sim.serialRead({port}, 100, true, '', 1e-9)")
    assert go_on() == ["h"]


def test_the_time_of_a_blocking_read_counts_from_its_own_start(
    allowed: ScriptWorld, cable: Cable, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("serial")
    clock = SimpleNamespace(now=0.0, monotonic=lambda: clock.now)
    for module in (serial_ports, processes):
        monkeypatch.setattr(module, "time", clock, raising=False)
    port = allowed.value(f"sim.serialOpen('{cable.port}')")
    assert allowed.value(f"sim.serialRead({port}, 4)") == ""
    clock.now = 100.0
    allowed.lua(
        f"pieces = {{}} reader = coroutine.create(function() pieces[1] = sim.serialRead({port}, 4, true, '', 5) end)"
    )
    for now, read in ((101.0, None), (104.0, None), (106.5, "")):
        clock.now = now
        assert allowed.lua("coroutine.resume(reader) return pieces[1]") == [read]


def test_ports_that_cannot_be_used_are_told(allowed: ScriptWorld, cable: Cable) -> None:
    pytest.importorskip("serial")
    assert allowed.value("sim.serialOpen('/dev/no-such-port', 9600)") == -1
    assert "'/dev/no-such-port' cannot be opened" in allowed.parts.status_bar.messages[-1]
    allowed.fails(f"sim.serialOpen('{cable.port}', 0)", "a baud rate is a number from 1")
    port = allowed.value(f"sim.serialOpen('{cable.port}')")
    assert allowed.value(f"sim.serialOpen('{cable.port}')") == -1, "it is open already"
    allowed.fails(f"sim.serialRead({port}, {MOST_BYTES + 1})", "a read has 0 to")
    allowed.fails("sim.serialCheck(77)", f"open are: {port} ")


def test_the_end_of_the_run_closes_ports(allowed: ScriptWorld, cable: Cable) -> None:
    pytest.importorskip("serial")
    ports = allowed.parts.serial_ports
    allowed.value(f"sim.serialOpen('{cable.port}')")
    allowed.sim.stop()
    assert ports.open(cable.port, 9600)[0] >= 0, "the device is free again"
    allowed.sim.start()
    allowed.sim.stop()
    assert ports.get(1), "it was opened while no run was"
    for handle in range(MOST_PORTS - 1):
        ports._open[100 + handle] = ports.get(1)
    with pytest.raises(CommandError, match="at most 16"):
        ports.open(cable.port, 9600)
    ports.close(1)
    ports._open.clear()


def test_a_program_gets_its_arguments_and_works_in_the_workspace(
    allowed: ScriptWorld, tmp_path: Path
) -> None:
    program = tmp_path / "robotClient"
    program.write_text(f'#!{sys.executable}\nimport sys\nopen("done", "w").write(repr(sys.argv[1:]))\n')
    program.chmod(0o700)
    assert allowed.value("sim.launchExecutable('robotClient', '19999 \"a b\" ;$HOME', 0)") == 1
    (child,) = allowed.parts.programs._running
    assert child.wait(60) == 0
    assert (tmp_path / "done").read_text() == "['19999', 'a b', ';$HOME']"
    assert allowed.value("sim.launchExecutable('./nothing')") == -1
    assert "program './nothing' cannot be started" in allowed.parts.status_bar.messages[-1]
    assert allowed.value("sim.launchExecutable('@true')") == 1
    (child,) = allowed.parts.programs._running
    assert child.wait(60) == 0


READER = """
<mujoco>
  <worldbody><body name="arm"><joint name="hinge" axis="0 1 0"/><geom size="0.1" pos="0 0 0.1"/></body></worldbody>
  <custom><text name="simx:lua:child:arm" data="
    function sysCall_init() port = sim.serialOpen('PORT', 9600) began = sim.getSystemTime() end
    function sysCall_actuation()
        local angle = tonumber(sim.serialRead(port, 100, false)) or 0
        sim.setJointPosition(sim.getObject('/hinge'), angle + (sim.getSystemTime() - began) % 0.1)
    end"/></custom>
</mujoco>
"""


def test_a_replay_repeats_what_was_read_and_the_wall_clock(tmp_path: Path, cable: Cable) -> None:
    pytest.importorskip("serial")
    scene, recording = tmp_path / "reader.xml", tmp_path / "run.simxlog"
    scene.write_text(READER.replace("PORT", cable.port))
    with recorded(scene, recording, allow_machine=True) as place:
        client = place.client()
        v.simxSynchronous(client, True)
        v.simxStartSimulation(client, BLOCKING)
        hinge = v.simxGetObjectHandle(client, "hinge", BLOCKING)[1]
        angles = []
        for number in range(5):
            cable.write(str(number / 2).encode())
            v.simxSynchronousTrigger(client)
            angles.append(v.simxGetJointPosition(client, hinge, BLOCKING)[1])
    assert [round(angle // 0.5) for angle in angles] == list(range(5))
    assert kinds(recording).count(Kind.OUTSIDE) > 10
    assert replay(recording) == DONE


def test_a_replay_whose_answers_are_missing_opens_nothing(tmp_path: Path, cable: Cable) -> None:
    pytest.importorskip("serial")
    scene, recording = tmp_path / "reader.xml", tmp_path / "run.simxlog"
    scene.write_text(READER.replace("PORT", cable.port))
    with recorded(scene, recording, allow_machine=True) as place:
        client = place.client()
        v.simxSynchronous(client, True)
        v.simxStartSimulation(client, BLOCKING)
        cable.write(b"0.5")
        v.simxSynchronousTrigger(client)
    rewrite(recording, lambda records: [each for each in records if each[0] != Kind.OUTSIDE])
    cable.write(b"0.5")
    assert replay(recording) == DIVERGED
