"""Images and camera infos: upright, in metres, with the lens of the sensor, and rendered for listeners only."""

from __future__ import annotations

import threading
from concurrent.futures import Future
from typing import Any

import numpy as np
import pytest
from processes import ROOT
from real_world import BLOCKING
from ros2_contents import Contents
from ros2_world import CAMERA_INFO, IMAGE, JOINT_STATE, Ros2World, Sent

import simx_client as v
from simx_server.scene.poses import frames

pytestmark = pytest.mark.gl

COLOUR, INFO, DEPTH, DEPTH_INFO = (
    f"0/eye/image_raw/{IMAGE}",
    f"0/eye/camera_info/{CAMERA_INFO}",
    f"0/eye/depth/image_raw/{IMAGE}",
    f"0/eye/depth/camera_info/{CAMERA_INFO}",
)
WIDTH, HEIGHT = 64, 48


def pixels(sent: Sent) -> np.ndarray:
    return np.asarray(sent.value["data"]).reshape(HEIGHT, WIDTH, 3)


def optical(server: Ros2World, point: list[float]) -> np.ndarray:
    """A point of the world in the camera's optical frame."""
    data = server.simulation.data
    right, up, back = np.array(data.cam_xmat[0]).reshape(3, 3).T
    return np.array([right, -up, -back]) @ (np.array(point) - data.cam_xpos[0])


def test_image_and_info_have_stamp_and_frame_of_one_step(server: Ros2World) -> None:
    peer = server.peer()
    for key in (COLOUR, INFO):
        peer.listen(key)
    server.on_server(server.simulation.start)
    image = peer.next(COLOUR, lambda sent: sent.stamp > 0.5)
    server.on_server(server.simulation.stop)
    info = peer.next(INFO, lambda sent: sent.stamp == image.stamp)
    assert image.value["header"] == info.value["header"]
    assert image.value["header"]["frame_id"] == "eye_optical_frame"
    assert (info.value["width"], info.value["height"]) == (WIDTH, HEIGHT)


def test_the_image_is_that_of_the_remote_api_with_the_rows_from_the_top(server: Ros2World) -> None:
    peer = server.peer()
    peer.listen(COLOUR)
    eye = server.simulation.scene.resolve("eye")
    future: Future[Any] = server.on_server(lambda: server.world.parts.vision.image(eye, as_grey=False))
    size, rows = future.result(30)
    assert size == [WIDTH, HEIGHT]
    expected = np.frombuffer(rows, np.uint8).reshape(HEIGHT, WIDTH, 3)[::-1]
    assert np.array_equal(pixels(peer.next(COLOUR)), expected)


@pytest.mark.parametrize(("x", "z"), [(1.0, 0.5), (0.6, 1.0)])
def test_the_camera_matrix_puts_a_point_where_the_image_shows_it(
    server: Ros2World, x: float, z: float
) -> None:
    """The red box is found in the image, and its middle where the matrix projects it."""
    box = server.simulation.scene.resolve("box")
    server.on_server(lambda: frames.set_position(server.simulation, box, -1, [x, -0.3, z]))
    data = server.simulation.data
    eye = data.cam_xpos[0].copy()
    forward = -np.array(data.cam_xmat[0]).reshape(3, 3)[:, 2]
    place = [float(v) for v in eye + 2.5 * forward + np.array([0.0, x - 0.8, z - 0.75])]
    server.on_server(lambda: frames.set_position(server.simulation, box, -1, place))
    peer = server.peer()
    for key in (COLOUR, INFO):
        peer.listen(key)
    image = pixels(peer.next(COLOUR)).astype(int)
    k = np.asarray(peer.next(INFO).value["k"]).reshape(3, 3)
    is_red = (image[..., 0] > 60) & (image[..., 0] > 2 * image[..., 1]) & (image[..., 0] > 2 * image[..., 2])
    rows, columns = np.nonzero(is_red)
    assert len(rows) > 4
    seen = optical(server, place)
    assert seen[2] > 0
    u, v, _ = k @ (seen / seen[2])
    assert u == pytest.approx(columns.mean(), abs=1.0)
    assert v == pytest.approx(rows.mean(), abs=1.0)


def test_depth_is_in_metres_along_the_axis_with_infinity_beyond_the_range(server: Ros2World) -> None:
    peer = server.peer()
    for key in (DEPTH, DEPTH_INFO):
        peer.listen(key)
    data = server.simulation.data
    eye, matrix = data.cam_xpos[0].copy(), np.array(data.cam_xmat[0]).reshape(3, 3)
    place = [float(v) for v in eye - 2.0 * matrix[:, 2]]
    box = server.simulation.scene.resolve("box")
    server.on_server(lambda: frames.set_position(server.simulation, box, -1, place))
    image = peer.next(DEPTH).value
    assert (image["encoding"], image["step"]) == ("32FC1", 4 * WIDTH)
    metres = np.frombuffer(np.asarray(image["data"]).tobytes(), "<f4").reshape(HEIGHT, WIDTH)
    middle = metres[HEIGHT // 2, WIDTH // 2]
    assert 1.8 < middle < 2.0
    assert np.isinf(metres[0]).all() or metres[0].max() > middle
    assert peer.next(DEPTH_INFO).value["header"]["frame_id"] == "eye_optical_frame"


def test_nothing_is_rendered_without_a_listener(server: Ros2World, monkeypatch: pytest.MonkeyPatch) -> None:
    vision, rendered = server.world.parts.vision, threading.Event()
    image = vision.image

    def seen(*arguments: Any, **more: Any) -> Any:
        rendered.set()
        return image(*arguments, **more)

    monkeypatch.setattr(vision, "image", seen)
    peer = server.peer()
    peer.listen(f"0/joint_states/{JOINT_STATE}")
    peer.listen(INFO)
    server.on_server(server.simulation.start)
    peer.next(f"0/joint_states/{JOINT_STATE}", lambda sent: sent.stamp > 1.0)
    peer.next(INFO)
    assert not rendered.is_set()
    peer.listen(COLOUR)
    peer.next(COLOUR)
    assert rendered.is_set()


def test_a_renderer_that_is_slow_is_asked_for_one_image_at_a_time(
    server: Ros2World, monkeypatch: pytest.MonkeyPatch
) -> None:
    vision = server.world.parts.vision
    futures: list[Future[Any]] = []

    def slow(*_: Any, **__: Any) -> Any:
        futures.append(Future())
        return futures[-1]

    monkeypatch.setattr(vision, "image", slow)
    peer = server.peer()
    peer.listen(COLOUR)
    server.on_server(server.simulation.start)
    server.wait_until(lambda: len(futures) == 1)
    count = server.simulation.step_count
    server.wait_until(lambda: server.simulation.step_count > count + 50)
    assert len(futures) == 1
    futures[0].set_result(([WIDTH, HEIGHT], bytes(WIDTH * HEIGHT * 3)))
    peer.next(COLOUR, lambda sent: not pixels(sent).any())  # one of a test before may come first
    server.wait_until(lambda: len(futures) == 2)
    futures[1].set_exception(RuntimeError("the renderer has a fault"))
    server.wait_until(lambda: len(futures) == 3)
    futures[2].set_result(([WIDTH, HEIGHT], bytes(WIDTH * HEIGHT * 3)))
    peer.next(COLOUR)


def test_the_kinect_of_the_upright_arm_looks_over_the_floor_and_sees_it_when_the_arm_bends() -> None:
    contents = Contents(ROOT / "scenes" / "ur5_rg2_kinect.xml")
    contents.start()
    contents.step()

    def seen() -> np.ndarray:
        """The image of the topic, which has to be that of the remote API at the same step, upright."""
        message = contents.message("/kinect_rgb/image_raw")
        image = np.asarray(message["data"]).reshape(message["height"], message["width"], 3)
        handle = contents.handle("kinect_rgb")
        code, (width, height), values = v.simxGetVisionSensorImage(contents.cid, handle, 0, BLOCKING)
        assert code == v.simx_return_ok
        rows = np.array(values, np.int16).astype(np.uint8).reshape(height, width, 3)
        assert np.array_equal(image, rows[::-1])
        return image

    assert not seen().any()
    for joint, goal in (("UR5_joint2", 0.5), ("UR5_joint3", 0.8), ("UR5_joint4", 0.2)):
        v.simxSetJointTargetPosition(contents.cid, contents.handle(joint), goal, BLOCKING)
    contents.step(80)
    brightness = seen().mean(axis=2)
    assert brightness.any()
    contents.close()
