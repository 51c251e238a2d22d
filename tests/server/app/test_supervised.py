"""A supervised server that crashes is back at the same ports, where it was; unless it crashes there again and again."""

from __future__ import annotations

import os
import signal
import sys
from pathlib import Path

import pytest
from processes import server, wait_until
from recordings import kinds, replay

import simx_client as v
from simx_client.protocol.cli.exit_codes import DONE, FAILURE
from simx_server.recording.records import Kind

BLOCKING = v.simx_opmode_blocking
TIMEOUT = 20.0

pytestmark = [
    pytest.mark.skipif(sys.platform != "linux", reason="children are found in /proc"),
    pytest.mark.usefixtures("no_connection_left"),
]


def servers(supervisor: int) -> list[int]:
    """The children of a supervisor in the order of their starts; the first one is its watchdog."""
    children = Path(f"/proc/{supervisor}/task/{supervisor}/children")
    return [int(each) for each in children.read_text().split()][1:] if children.exists() else []


def test_a_crash_loses_one_step_at_most_and_a_server_that_crashes_for_ever_ends(
    scene: Path, tmp_path: Path
) -> None:
    recording = tmp_path / "run.simxlog"
    with server(scene, "--supervised", "--record", recording, "--workspace", tmp_path) as started:
        supervisor = started.process.pid
        client = v.simxStart("127.0.0.1", started.port, True, False, 5000, 5)
        assert v.simxSynchronous(client, True) == 0
        assert v.simxStartSimulation(client, BLOCKING) == 0
        for _ in range(5):
            assert v.simxSynchronousTrigger(client) == 0
        assert v.simxSetFloatSignal(client, "gain", 0.25, BLOCKING) == 0
        assert wait_until(lambda: Kind.PASS in kinds(recording), TIMEOUT)
        scene.unlink()  # the next server gets it from its supervisor, as it was
        (server_process,) = servers(supervisor)
        os.kill(server_process, signal.SIGSEGV)
        assert wait_until(lambda: v.simxGetConnectionId(client) == 2, TIMEOUT)
        errors = v.simxGetLastErrors(client, BLOCKING)[1]
        assert [each for each in errors if "ended by signal 11 (SIGSEGV) and was started again" in each], (
            errors
        )
        # It still steps the simulation, which went no further without it.
        assert v.simxSynchronousTrigger(client) == 0
        v.simxGetPingTime(client)
        assert v.simxGetLastCmdTime(client) in (250, 300)
        v.simxFinish(client)
        assert wait_until(lambda: recording.exists() and Kind.RESUMED in kinds(recording), TIMEOUT)

        def has_ended() -> bool:
            for each in servers(supervisor):
                os.kill(each, signal.SIGSEGV)
            return started.process.poll() is not None

        assert wait_until(has_ended, TIMEOUT)
        assert started.process.returncode == FAILURE
    assert replay(recording) == DONE
