"""Stepped runs repeated: the same calls give the same states, bit for bit, whatever else the server does or did."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from busy_scene import BUSY
from loopback import LoopbackTransport
from processes import read_line, server, wait_until
from real_world import BLOCKING, Open, RealWorld, handle_of, start_stepped

import simx_client as v
from bench.load.lookers import looking
from simx_client.connection.clients import CLIENTS
from simx_client.connection.connection import Connection
from simx_client.protocol.zenoh.keys import VIEWER
from simx_server.app import cli
from simx_server.scene.editing.model_state import get_state
from simx_server.viewer.launching import missing

pytestmark = [pytest.mark.slow, pytest.mark.gl]

PASSES = 15

SOON = 30.0
"""Seconds for an answer, while the first images are made on busy cores."""

Run = Callable[[int], list[list[float]]]
"""Drives a client through a stepped run, and stops; what it read after each pass."""


@pytest.fixture
def busy(tmp_path: Path) -> str:
    path = tmp_path / "busy.xml"
    path.write_text(BUSY)
    return str(path)


def run(client: int, *, after_step: Callable[[], object] = lambda: None) -> list[list[float]]:
    """Positions of all joints, and those of all shapes, after each pass; the joints follow a course."""
    connection = CLIENTS.get(client)
    assert connection is not None
    connection.timeout = SOON
    _, joints, *_ = v.simxGetObjectGroupData(client, v.sim_object_joint_type, 0, BLOCKING)
    start_stepped(client)
    course = []
    for count in range(PASSES):
        v.simxPauseCommunication(client, True)
        for number, joint in enumerate(joints):
            v.simxSetJointTargetPosition(
                client, joint, 0.3 * np.sin(0.1 * count + number), v.simx_opmode_oneshot
            )
            v.simxSetJointTargetVelocity(
                client, joint, 0.2 * np.cos(0.1 * count - number), v.simx_opmode_oneshot
            )
        v.simxPauseCommunication(client, False)
        assert v.simxSynchronousTrigger(client) == v.simx_return_ok
        after_step()
        values = []
        for kind, what in ((v.sim_object_joint_type, 15), (v.sim_object_shape_type, 9)):
            code, _, _, floats, _ = v.simxGetObjectGroupData(client, kind, what, BLOCKING)
            assert code == v.simx_return_ok
            values += floats
        course.append([v.simxGetLastCmdTime(client), *values])
    v.simxStopSimulation(client, BLOCKING)
    return course


def seen(place: RealWorld, client: int, do: Callable[[], object] = lambda: None) -> np.ndarray:
    """All of the state that the next step depends on, after each pass of a run, with what the client read."""
    states: list[np.ndarray] = []

    def note() -> None:
        states.append(get_state(place.simulation.model, place.simulation.data))
        do()

    read = run(client, after_step=note)
    assert len({state.tobytes() for state in states}) == PASSES  # it moves
    return np.hstack([np.array(states), np.array(read)])


def edit_and_run(client: int) -> None:
    """Another run, in which the scene is edited, things are moved and joints are set."""
    code, joints, *_ = v.simxGetObjectGroupData(client, v.sim_object_joint_type, 0, BLOCKING)
    assert code == v.simx_return_ok
    _, shapes, *_ = v.simxGetObjectGroupData(client, v.sim_object_shape_type, 0, BLOCKING)
    start_stepped(client)
    for _ in range(3):
        v.simxSetJointPosition(client, joints[0], 0.5, BLOCKING)
        v.simxSetJointForce(client, joints[0], 3.0, BLOCKING)
        v.simxSetObjectPosition(client, shapes[-1], -1, (0.4, 0.4, 0.8), BLOCKING)
        code, dummy = v.simxCreateDummy(client, 0.1, None, BLOCKING)
        assert code == v.simx_return_ok
        code, copies = v.simxCopyPasteObjects(client, shapes[-1:], BLOCKING)
        assert code == v.simx_return_ok
        v.simxSynchronousTrigger(client)
        v.simxRemoveObject(client, copies[0], BLOCKING)
        v.simxSetObjectParent(client, dummy, shapes[0], True, BLOCKING)
        v.simxSynchronousTrigger(client)
    v.simxStopSimulation(client, BLOCKING)


@pytest.fixture(params=["ur5_rg2_kinect", "quadricopter", "busy"])
def scene(request: pytest.FixtureRequest, busy: str) -> str:
    return busy if request.param == "busy" else request.param


def test_a_run_is_the_same_on_a_fresh_server_and_on_a_used_one(world: Open, scene: str) -> None:
    first, second = world(scene), world(scene)
    expected = seen(*first)
    assert np.array_equal(seen(*first), expected)
    edit_and_run(second[1])
    assert np.array_equal(seen(*second), expected)
    assert v.simxLoadScene(second[1], scene, 0, BLOCKING) == v.simx_return_ok
    assert np.array_equal(seen(*second), expected)


def test_a_run_is_the_same_with_a_camera_that_streams(world: Open, busy: str) -> None:
    expected = seen(*world(busy))
    place, client = world(busy)
    eye = handle_of(client, "eye")
    codes = []
    picture = lambda: codes.append(  # noqa: E731
        v.simxGetVisionSensorImage(client, eye, 0, v.simx_opmode_buffer)[0]
    )
    v.simxGetVisionSensorImage(client, eye, 0, v.simx_opmode_streaming)
    assert np.array_equal(seen(place, client, picture), expected)
    assert v.simx_return_ok in codes


def test_a_run_is_the_same_with_a_viewer_that_reads_all_along(world: Open, busy: str) -> None:
    expected = seen(*world(busy))
    place, client = world(busy)
    viewer = _viewer(place)
    hinge, ball = handle_of(viewer, "hinge"), handle_of(viewer, "ball")

    def look() -> None:
        assert v.simxGetJointPosition(viewer, hinge, BLOCKING)[0] == v.simx_return_ok
        v.simxGetObjectVelocity(viewer, ball, v.simx_opmode_streaming)
        v.simxGetObjectGroupData(viewer, v.sim_object_shape_type, 9, BLOCKING)
        v.simxSetJointPosition(viewer, hinge, 1.0, BLOCKING)  # which it may not

    assert np.array_equal(seen(place, client, look), expected)


def _viewer(place: RealWorld) -> int:
    transport = LoopbackTransport(place.loop)
    transport.client = VIEWER + transport.client
    connection = Connection(lambda: transport, where=transport.client)
    client = CLIENTS.add(connection)
    connection.connect(1.0)
    return client


def of_a_process(scene: str | Path) -> list[list[float]]:
    """A run on a server in a separate process."""
    with server(scene, "--speed", "max") as process:
        client = v.simxStart("127.0.0.1", process.port, True, True, 5000, 5)
        course = run(client)
        v.simxFinish(client)
    return course


@pytest.fixture(scope="module")
def elsewhere(tmp_path_factory: pytest.TempPathFactory) -> list[list[float]]:
    """A run of the busy scene on a server in a separate process."""
    path = tmp_path_factory.mktemp("elsewhere") / "busy.xml"
    path.write_text(BUSY)
    return of_a_process(path)


def test_clients_of_two_server_processes_read_the_same_numbers(
    busy: str, elsewhere: list[list[float]]
) -> None:
    assert of_a_process(busy) == elsewhere


@pytest.mark.skipif(missing() is not None, reason="needs the extra viewer")
def test_a_run_is_the_same_while_a_page_is_looked_at_and_its_recording_replays(
    busy: str, elsewhere: list[list[float]], tmp_path: Path
) -> None:
    recording = tmp_path / "run.simxlog"
    with server(busy, "--speed", "max", "--view", "0", "--record", recording) as watched:
        url = read_line(watched.process, 60).split()[1]
        pictures: list[int] = []

        def see() -> None:
            """Now and then the page shows something new before it goes on."""
            if (count := len(pictures)) < 5:
                assert wait_until(lambda: len(pictures) > count, 20)

        with looking(url, 1, lambda _, window: pictures.append(len(window))):
            client = v.simxStart("127.0.0.1", watched.port, True, True, 5000, 5)
            assert run(client, after_step=see) == elsewhere
            v.simxFinish(client)
        watched.process.terminate()
        assert watched.process.wait(20) == 0
    assert cli.main(["--replay", str(recording)]) == 0
