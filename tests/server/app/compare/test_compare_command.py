"""``simx compare`` with real processes: our own server is the original, with the same physics or with other ones."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from original_library import library_path, needs_library
from processes import server
from test_compare_proxies import scene

from simx_client.protocol.cli.exit_codes import DIVERGED, DONE, FAILURE
from simx_server.app.compare.command import main

pytestmark = pytest.mark.system

LEGACY = """
import vrep
client = vrep.simxStart("127.0.0.1", 19997, True, True, 5000, 1)
assert client >= 0
hinge = vrep.simxGetObjectHandle(client, "hinge", 0x10000)[1]
vrep.simxSynchronous(client, True)
vrep.simxStartSimulation(client, 0x10000)
for step in range(12):
    vrep.simxSetJointTargetPosition(client, hinge, 0.8 if step > 3 else 0.0, 0x10000)
    vrep.simxSynchronousTrigger(client)
vrep.simxStopSimulation(client, 0x10000)
vrep.simxFinish(client)
"""
BINDING = '''
"""A binding of the original's library."""
import ctypes
_c = ctypes.CDLL("LIBRARY")  # remoteApi
def simxStart(connectionAddress, connectionPort, *others):
    return _c.simxStart(connectionAddress.encode(), connectionPort, *others)
def simxGetObjectHandle(client, name, mode):
    handle = ctypes.c_int()
    return _c.simxGetObjectHandle(client, name.encode(), ctypes.byref(handle), mode), handle.value
def simxSetJointTargetPosition(client, joint, value, mode):
    return _c.simxSetJointTargetPosition(client, joint, ctypes.c_float(value), mode)
simxSynchronous, simxSynchronousTrigger = _c.simxSynchronous, _c.simxSynchronousTrigger
simxStartSimulation, simxStopSimulation, simxFinish = _c.simxStartSimulation, _c.simxStopSimulation, _c.simxFinish
'''
ZMQ = """
from coppeliasim_zmqremoteapi_client import RemoteAPIClient
sim = RemoteAPIClient().require("sim")
hinge = sim.getObject("/hinge")
sim.setStepping(True)
sim.startSimulation()
for step in range(12):
    sim.setJointTargetPosition(hinge, 0.8 if step > 3 else 0.0)
    sim.step()
sim.stopSimulation()
"""


@needs_library
def test_a_legacy_program_departs_with_other_physics_and_the_recording_serves_again(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    program, recorded, shown = (tmp_path / name for name in ("program.py", "original.npz", "result.html"))
    program.write_text(LEGACY)
    (tmp_path / "vrep.py").write_text(BINDING.replace("LIBRARY", str(library_path())))
    with server(scene(tmp_path), "--legacy-port", "0") as place:
        (port,) = re.findall(r"legacy/127\.0\.0\.1:(\d+)", place.ready)
        original = [
            "--original",
            f"127.0.0.1:{port}",
            "--save",
            str(recorded),
            "--page",
            str(shown),
            "--json",
        ]
        weak = scene(tmp_path, gain=0.04)
        assert main([str(program), "--scene", str(weak), *original]) == DIVERGED
    told = json.loads(capfd.readouterr().out)
    joint = next(each for each in told["departures"] if each["quantity"] == "joint")
    assert (joint["object"], joint["time"]) == ("hinge", pytest.approx(0.35, abs=0.1))
    assert "box" not in {each["object"] for each in told["departures"]}
    assert "<svg" in shown.read_text()
    # By the project's own client, and against the file
    assert main([str(program), "--scene", str(scene(tmp_path)), "--recorded", str(recorded)]) == DONE
    assert "equal: every quantity stays within its tolerance" in capfd.readouterr().out


def test_a_program_of_the_zeromq_api_is_equal_with_the_same_physics(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("zmq")
    pytest.importorskip("coppeliasim_zmqremoteapi_client")
    program = tmp_path / "program.py"
    program.write_text(ZMQ)
    path = scene(tmp_path)
    with server(path, "--zmq", "0") as place:
        (port,) = re.findall(r"zmq/127\.0\.0\.1:(\d+)", place.ready)
        assert main([str(program), "--scene", str(path), "--original", f"127.0.0.1:{port}"]) == DONE
    shown = capfd.readouterr().out
    assert "compared 4 objects" in shown
    assert "tolerances: position 0.002 m" in shown


def test_what_cannot_be_compared_is_told(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    program, path = tmp_path / "program.py", scene(tmp_path)
    program.write_text("print('no call')")
    words = [str(program), "--scene", str(path)]
    assert main([*words, "--original", "127.0.0.1:1"]) == FAILURE
    assert "no simulator listens at 127.0.0.1:1; start CoppeliaSim" in capfd.readouterr().err
    assert main([*words, "--original", "a b"]) == FAILURE
    assert "valid is HOST" in capfd.readouterr().err
    with server(path, "--legacy-port", "0") as place:
        (port,) = re.findall(r"legacy/127\.0\.0\.1:(\d+)", place.ready)
        assert main([*words, "--original", f"legacy:127.0.0.1:{port}"]) == FAILURE
    assert "made no call through the legacy port; it needs the original's library" in capfd.readouterr().err
    with pytest.raises(SystemExit, match="2"):
        main([*words, "--recorded", "x.npz", "--save", "y.npz"])
