"""Many simulations stepped together, in worker processes and in this one."""

from __future__ import annotations

import os
import signal
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from processes import PENDULUM, read_line, running, server, spawn, wait_until
from world_processes import NotingSubprocess, children

from simx_client.client import Client, Servers, Worlds
from simx_client.client.worlds import worker
from simx_client.connection.clients import CLIENTS
from simx_client.errors import CallsFailed, ConnectionFailed

COUNT = 3


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    file = tmp_path / "pendulum.xml"
    file.write_text(PENDULUM)
    return file


@pytest.fixture
def forks(monkeypatch: pytest.MonkeyPatch) -> NotingSubprocess:
    """The processes of a test's worlds."""
    noting = NotingSubprocess()
    monkeypatch.setattr(worker, "subprocess", noting)
    return noting


def trajectory(servers: Servers) -> np.ndarray:
    """Watched positions of 20 steps, with other target velocities in each world: steps x worlds x values."""
    hinges = [answer.value for answer in servers.each(lambda calls, _: calls.simxGetObjectHandle("hinge"))]
    servers.each(lambda calls, _: (calls.simxSynchronous(True), calls.simxStartSimulation()))
    servers.watch(
        lambda calls, place: [
            calls.simxGetJointPosition(hinges[place]),
            calls.simxGetObjectPosition(hinges[place], -1),
        ]
    )
    rows: list[np.ndarray] = []
    for step in range(20):

        def push(calls: Any, place: int, step: int = step) -> None:
            calls.simxSetJointTargetVelocity(hinges[place], 0.3 * (step % 5) + 0.1 * place)

        rows.append(servers.step(push))
    servers.each(lambda calls, _: calls.simxStopSimulation())
    return np.array(rows)


def test_worlds_in_processes_are_equal_to_servers_bit_for_bit(scene: Path) -> None:
    with Worlds(scene, COUNT, processes=2) as worlds:
        in_processes = trajectory(worlds)
    with Worlds(scene, COUNT, processes=0) as worlds:
        alone = trajectory(worlds)
    with server(scene) as one, Client.many([one.port]) as servers:
        over_network = trajectory(servers)
    assert in_processes.shape == (20, COUNT, 4)
    assert np.array_equal(in_processes, alone)
    assert np.array_equal(in_processes[:, :1], over_network)
    assert len(np.unique(in_processes[-1, :, 0])) == COUNT


def test_a_world_that_refuses_a_call_leaves_the_others_unchanged(scene: Path) -> None:
    with Worlds(scene, COUNT, processes=2) as worlds:
        worlds.each(lambda calls, _: (calls.simxSynchronous(True), calls.simxStartSimulation()))
        worlds.watch(lambda calls, _: [calls.simxGetJointPosition(1)])
        with pytest.raises(CallsFailed, match="no object with handle -7") as failed:
            worlds.step(lambda calls, place: calls.simxGetJointPosition(-7) if place == 1 else None)
        (failure,) = failed.value.failures
        assert failure.server == 1
        assert np.isnan(worlds.observations).any(axis=1).tolist() == [False, True, False]
        assert not worlds.lost
        assert not np.isnan(worlds.step()).any()


@pytest.mark.parametrize("processes", [0, 2])
def test_the_end_of_the_block_ends_all_worlds(scene: Path, processes: int, forks: NotingSubprocess) -> None:
    with Worlds(scene, COUNT, processes=processes) as worlds:
        assert len(worlds.clients) == (0 if processes else COUNT)
        assert len(CLIENTS.all()) == len(worlds.clients)
        assert len(forks.started) == processes
        assert all(each.poll() is None for each in forks.started)
    assert not CLIENTS.all()
    assert forks.have_ended()
    with pytest.raises(CallsFailed, match="it was closed" if processes else "the server went away"):
        worlds.each(lambda calls, _: calls.simxGetObjects(1))
    worlds.close()


def test_worlds_whose_process_dies_are_lost_and_the_others_go_on(
    scene: Path, forks: NotingSubprocess
) -> None:
    with Worlds(scene, COUNT, processes=2) as worlds:
        worlds.each(lambda calls, _: (calls.simxSynchronous(True), calls.simxStartSimulation()))
        worlds.watch(lambda calls, _: [calls.simxGetJointPosition(1)])
        os.kill(forks.started[0].pid, signal.SIGKILL)
        with pytest.raises(CallsFailed, match=r"its process \(pid \d+\) ended by SIGKILL"):
            worlds.step()
        assert list(worlds.lost) == [0, 2]
        assert np.isnan(worlds.step()).any(axis=1).tolist() == [True, False, True]


def test_processes_end_with_a_program_that_is_killed(scene: Path) -> None:
    program = f"""
import threading
from simx_client.client import Worlds
worlds = Worlds({str(scene)!r}, 2, processes=2)
print("ready", flush=True)
threading.Event().wait()
"""
    with running(spawn("-c", program)) as process:
        assert read_line(process).strip() == "ready"
        workers = children(process.pid)
        assert len(workers) == 2
        process.kill()
        assert wait_until(lambda: not any(Path(f"/proc/{pid}").exists() for pid in workers), 30.0)


def test_a_world_draws_images(scene: Path) -> None:
    with Worlds("ur5_rg2_kinect", 2, processes=2, timeout=60) as worlds:  # the first image may take seconds
        cameras = worlds.each(lambda calls, _: calls.simxGetObjectHandle("kinect_rgb"))
        pictures = worlds.each(lambda calls, place: calls.simxGetVisionSensorImage(cameras[place].value, 0))
        first, second = (np.array(picture.value[1], np.uint8) for picture in pictures)
    assert first.size
    assert np.array_equal(first, second)


@pytest.mark.parametrize(
    ("count", "settings", "says"),
    [
        (0, {}, "count must be 1..1000, not 0"),
        (1001, {}, "count must be 1..1000, not 1001"),
        (2, {"processes": 3}, "processes must be 0..2 for 2 worlds, not 3"),
    ],
)
def test_impossible_numbers_are_refused(count: int, settings: dict[str, Any], says: str) -> None:
    with pytest.raises(ValueError, match=says):
        Worlds("two_link_arm", count, **settings)


def test_a_setting_that_cannot_be_used_leaves_no_world_behind() -> None:
    before = CLIENTS.all()
    with pytest.raises(ConnectionFailed, match="no_such_scene"):
        Worlds("no_such_scene", 2)
    assert CLIENTS.all() == before


def test_a_batch_of_reads_is_of_one_instant_while_the_simulation_runs(scene: Path) -> None:
    """The pacing thread makes no step within a batch."""
    with Worlds(scene, 1, speed="max", start=True) as worlds:
        worlds.each(lambda calls, _: calls.simxSetJointTargetVelocity(1, 1.0))
        seen: set[float] = set()

        def look() -> bool:
            (row,) = worlds.each(lambda calls, _: [calls.simxGetJointPosition(1) for _ in range(20)])
            assert len({answer.value for answer in row}) == 1
            seen.add(row[0].value)
            return len(seen) > 50

        assert wait_until(look, 30.0)
