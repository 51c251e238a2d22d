"""The 40 functions that scripts use most, between two processes, by the short way of one host and over Zenoh alone.

One server process for each way: each test connects, leaves the simulation stopped and finishes.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from conforming import BINDING, BLOCKING, BUFFER, NOVALUE, OK, ONESHOT, SCENE, STREAMING, assert_types
from processes import ROOT, ServerProcess, server, wait_until
from real_world import handle_of

import simx_client as v

pytestmark = [pytest.mark.slow, pytest.mark.gl]


@pytest.fixture(scope="module")
def workspace(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("workspace")


@pytest.fixture(scope="module", params=["--local", "--no-local"])
def process(request: pytest.FixtureRequest, workspace: Path) -> Iterator[ServerProcess]:
    with server(SCENE, "--speed", "max", "--workspace", workspace, request.param) as process:
        yield process


@pytest.fixture
def cid(process: ServerProcess) -> Iterator[int]:
    v.simxFinish(-1)
    cid = v.simxStart("127.0.0.1", process.port, True, True, 5000, 5)
    assert cid == 0
    yield cid
    v.simxStopSimulation(cid, BLOCKING)
    v.simxLoadScene(cid, str(SCENE), 0, BLOCKING)
    for clear in (v.simxClearFloatSignal, v.simxClearIntegerSignal, v.simxClearStringSignal):
        clear(cid, "", BLOCKING)
    v.simxFinish(-1)


def stepped(cid: int, steps: int = 4) -> None:
    assert v.simxSynchronous(cid, True) == OK
    assert v.simxStartSimulation(cid, BLOCKING) == OK
    for _ in range(steps):
        assert v.simxSynchronousTrigger(cid) == OK


JOINT, ZEROS = v.sim_object_joint_type, [0.0] * 3
READS: dict[str, tuple[Any, ...]] = {
    "simxGetObjectHandle": ("elbow",),
    "simxGetObjects": (JOINT,),
    "simxGetObjectPosition": ("@lid", -1),
    "simxGetObjectOrientation": ("@lid", -1),
    "simxGetObjectVelocity": ("@falling",),
    "simxGetJointPosition": ("@elbow",),
    "simxGetJointForce": ("@elbow",),
    "simxGetObjectGroupData": (JOINT, 16),
    "simxGetObjectFloatParameter": ("@elbow", 2012),
    "simxReadProximitySensor": ("@ahead",),
    "simxReadForceSensor": ("@scale",),
    "simxGetVisionSensorImage": ("@colour", 0),
    "simxGetFloatSignal": ("float",),
    "simxGetStringSignal": ("string",),
    "simxCallScriptFunction": ("robot", 1, "echo", [1], [0.5], ["x"], b"y"),
}
"""Functions that are read, with arguments; @ stands before the name of an object."""

SETS: dict[str, tuple[Any, ...]] = {
    "simxSetJointTargetVelocity": ("@shoulder", 0.5),
    "simxSetJointTargetPosition": ("@elbow", 0.5),
    "simxSetJointForce": ("@elbow", 10.0),
    "simxSetObjectPosition": ("@lid", -1, [1, 2, 3]),
    "simxSetObjectOrientation": ("@lid", -1, [0.1, 0.2, 0.3]),
    "simxSetObjectParent": ("@lid", -1, True),
    "simxSetFloatingParameter": (v.sim_floatparam_simulation_time_step, 0.02),
    "simxSetFloatSignal": ("float", 0.5),
    "simxSetIntegerSignal": ("integer", 7),
    "simxSetStringSignal": ("string", b"a\0b"),
    "simxAddStatusbarMessage": ("hello",),
}
OTHERS = {
    "simxStart", "simxFinish", "simxStartSimulation", "simxStopSimulation", "simxPauseSimulation", "simxSynchronous",
    "simxSynchronousTrigger", "simxGetPingTime", "simxGetConnectionId", "simxPauseCommunication",
    "simxGetLastCmdTime", "simxUnpackFloats", "simxLoadScene", "simxCloseScene",
}  # fmt: skip
"""Used by the tests below or by the fixtures above."""


def resolved(cid: int, arguments: tuple[Any, ...]) -> list[Any]:
    return [
        handle_of(cid, each[1:]) if isinstance(each, str) and each.startswith("@") else each
        for each in arguments
    ]


def test_these_are_the_40_functions_that_scripts_use_most() -> None:
    assert len(READS) + len(SETS) + len(OTHERS) == 40
    assert set(READS) | set(SETS) | OTHERS <= set(BINDING)


@pytest.mark.parametrize("name", READS)
def test_a_reading_function_answers_blocking_and_as_a_stream(cid: int, name: str) -> None:
    if name == "simxCallScriptFunction":
        pytest.importorskip("lupa")
    function, arguments = getattr(v, name), resolved(cid, READS[name])
    v.simxSetFloatSignal(cid, "float", 0.5, BLOCKING)
    v.simxSetStringSignal(cid, "string", b"abc", BLOCKING)
    stepped(cid)
    blocking = function(cid, *arguments, BLOCKING)
    assert blocking[0] == OK
    assert function(cid, *arguments, STREAMING) == BINDING[name].failure(NOVALUE)
    assert wait_until(lambda: function(cid, *arguments, BUFFER)[0] == OK, 5.0)
    streamed = function(cid, *arguments, BUFFER)
    assert streamed == blocking, "time stands still between triggers"
    assert_types(streamed, blocking)


@pytest.mark.parametrize("name", SETS)
def test_a_setting_function_is_success_blocking_and_after_a_oneshot(cid: int, name: str) -> None:
    function, arguments = getattr(v, name), resolved(cid, SETS[name])
    assert function(cid, *arguments, BLOCKING) == OK
    assert function(cid, *arguments, ONESHOT) == NOVALUE
    assert v.simxGetPingTime(cid)[0] == OK
    assert function(cid, *arguments, BUFFER) == OK


def test_a_script_drives_a_joint_in_stepped_mode_and_reads_simulated_time(cid: int) -> None:
    elbow = handle_of(cid, "elbow")
    stepped(cid, 0)
    v.simxGetJointPosition(cid, elbow, STREAMING)
    v.simxPauseCommunication(cid, True)
    v.simxSetJointTargetPosition(cid, elbow, 1.0, ONESHOT)
    v.simxPauseCommunication(cid, False)
    for _ in range(40):
        v.simxSynchronousTrigger(cid)
        v.simxGetPingTime(cid)
    assert v.simxGetLastCmdTime(cid) == 2000
    assert wait_until(
        lambda: v.simxGetJointPosition(cid, elbow, BUFFER)[1] == pytest.approx(1.0, abs=0.01), 5.0
    )
    assert v.simxGetConnectionId(cid) == 1
    assert v.simxUnpackFloats(v.simxPackFloats([0.5])) == [0.5]


def test_pause_and_close_over_the_network(cid: int) -> None:
    v.simxStartSimulation(cid, BLOCKING)
    assert v.simxPauseSimulation(cid, BLOCKING) == OK
    assert v.simxGetInMessageInfo(cid, v.simx_headeroffset_server_state)[1] & 3 == 3
    v.simxStopSimulation(cid, BLOCKING)
    assert v.simxCloseScene(cid, BLOCKING) == OK
    assert v.simxGetObjectHandle(cid, "ResizableFloor_5_25", BLOCKING)[0] == OK


def test_two_processes_share_one_port(cid: int, process: ServerProcess) -> None:
    code = (
        "import simx_client as v; b = v.simx_opmode_blocking\n"
        f"c = v.simxStart('127.0.0.1', {process.port}, True, True, 5000, 5)\n"
        "print(c, *v.simxGetIntegerSignal(c, 'from one', b), v.simxSetIntegerSignal(c, 'from two', 2, b))\n"
        "v.simxFinish(c)\n"
    )
    v.simxSetIntegerSignal(cid, "from one", 1, BLOCKING)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, cwd=ROOT)
    assert done.stdout.split() == ["0", "0", "1", "0"], done.stderr
    assert v.simxGetIntegerSignal(cid, "from two", BLOCKING) == (OK, 2)


def test_13_host_names_work_the_same_place_twice_is_minus_1_and_refusals_come_at_once(
    cid: int, process: ServerProcess
) -> None:
    assert v.simxStart("127.0.0.1", process.port, True, True, 5000, 5) == -1, "connected already"
    named = v.simxStart("localhost", process.port, True, True, 5000, 5)
    assert named == 1
    v.simxFinish(named)
    assert v.simxGetConnectionId(named) == -1
