"""Objects, sensors and signals as ``simx_client.Client`` shows them."""

from __future__ import annotations

import numpy as np
import pytest
from modern_world import messages_of

from simx_client import Client, errors

FREE_FALL = 9.81


# --- objects -------------------------------------------------------------------------------------


def test_a_joint_is_read_and_set_in_radians_and_looked_up_once(client: Client) -> None:
    sizes = messages_of(client)
    client.joint("shoulder").position = 0.25
    assert client.joint("shoulder").position == pytest.approx(0.25)
    assert client.joint("shoulder") is client.joint("shoulder")
    assert sizes == [2, 1, 1], "looked up, set, read"
    client.joint("shoulder").max_force = 12
    assert client.joint("shoulder").max_force == 12


def test_joints_reach_their_targets_and_tell_their_velocity_and_force(client: Client) -> None:
    shoulder, wrist = both = client.joints("shoulder", "wrist")
    with client.stepping() as step:
        shoulder.target_position = 0.5
        wrist.target_velocity = 1.0
        for _ in range(60):
            step()
        assert shoulder.position == pytest.approx(0.5, abs=0.01)
        assert both.velocities == pytest.approx([0.0, 1.0], abs=0.05)
        assert both.positions == pytest.approx([shoulder.position, wrist.position])
        assert both.forces == pytest.approx([shoulder.force, wrist.force])


def test_targets_are_write_only_and_say_so(client: Client) -> None:
    with pytest.raises(AttributeError, match="write only"):
        _ = client.joint("shoulder").target_position


def test_as_many_numbers_as_joints_are_needed(client: Client) -> None:
    with pytest.raises(ValueError, match="2 joints need as many numbers, got 3"):
        client.joints("shoulder", "wrist").positions = [0, 0, 0]


def test_poses_are_metres_and_xyzw_in_the_world_and_in_other_frames(client: Client) -> None:
    client.joints("shoulder", "wrist").positions = np.array([np.pi / 2, 0.0])
    tip = client.dummy("tip")
    assert tip.position == pytest.approx([0, 3.8, 1], abs=1e-6)
    assert tip.relative_to(client.object("hand")).position == pytest.approx([0.3, 0, 0], abs=1e-6)
    half = np.sqrt(0.5)
    position, quaternion = tip.pose
    assert quaternion == pytest.approx([0, 0, half, half], abs=1e-6)
    assert tip.relative_to(None).euler_angles == pytest.approx([0, 0, np.pi / 2], abs=1e-6)
    assert tip.pose.matrix @ [1, 0, 0, 1] == pytest.approx([*np.add(position, (0, 1, 0)), 1], abs=1e-6)


def test_a_pose_that_is_set_is_the_pose_that_is_read(client: Client) -> None:
    red, blue = client.object("red"), client.object("blue")
    red.pose = (0.1, 0.2, 0.3), (0, 0, np.sqrt(0.5), np.sqrt(0.5))
    assert red.position == pytest.approx([0.1, 0.2, 0.3])
    blue.relative_to(red).pose = [1, 0, 0], [0, 0, 0, 1]
    assert blue.position == pytest.approx([0.1, 1.2, 0.3], abs=1e-6)
    assert blue.pose.quaternion == pytest.approx(red.quaternion, abs=1e-6)
    blue.position = red.position - [1, 0, 0]
    assert blue.position == pytest.approx([-0.9, 0.2, 0.3], abs=1e-6)
    with pytest.raises(ValueError, match="needs 3 numbers, got 2"):
        blue.position = [1, 2]


def test_velocities_are_measured_in_world_axes_over_the_last_step(client: Client) -> None:
    shoulder, wheel, hand = client.joint("shoulder"), client.object("wheel"), client.object("hand")
    client.joint("axle").target_velocity = 2.0
    with client.stepping() as step:
        shoulder.target_position = 1.0
        for _ in range(10):
            step()
        # Not Euler rates: the axis is none of the three.
        assert wheel.angular_velocity == pytest.approx([np.sqrt(2), np.sqrt(2), 0], abs=0.02)
        before = hand.position
        step()
        assert hand.velocity == pytest.approx((hand.position - before) / 0.05, abs=1e-4)
        assert np.linalg.norm(hand.velocity) > 0.05


def test_objects_have_names_kinds_and_parents(client: Client) -> None:
    listed = client.objects()
    parent = client.joint("wrist").parent
    assert parent is not None
    assert parent.name in listed
    client.object("stand").parent = client.object("seer")
    parent = client.object("stand").parent
    assert parent is not None
    assert parent == client.object("seer")
    assert parent != client.object("stand")
    client.object("stand").parent = None
    assert client.object("stand").parent is None


# --- sensors -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "top", "bottom"), [("above", (9, 19), (45, 32)), ("plan", (16, 19), (48, 29))]
)
def test_images_stand_upright_and_depth_is_metres(
    client: Client, name: str, top: tuple[int, int], bottom: tuple[int, int]
) -> None:
    """Red is to the left and up, 2 m below the camera; blue to the right and down, 2.5 m below."""
    camera = client.camera(name)
    assert camera.resolution == (64, 48)
    assert (camera.near, camera.far) == pytest.approx((0.1, 5))
    picture, depth = camera.rgb(), camera.depth()
    assert (picture.shape, picture.dtype) == ((48, 64, 3), np.uint8)
    assert (depth.shape, depth.dtype) == ((48, 64), np.float32)
    reds, blues = picture[:, :, 0] > 100, picture[:, :, 2] > 100
    assert depth[reds & (depth < 2.2)] == pytest.approx(2.0, abs=1e-3)
    assert depth[blues].min() == pytest.approx(2.5, abs=1e-3)
    for colour, up, left in ((reds, True, True), (blues, False, False)):
        rows, columns = np.nonzero(colour)
        assert (rows.mean() < 24) == up
        assert (columns.mean() < 32) == left
    assert depth.max() == pytest.approx(5.0)
    assert camera.grey() == pytest.approx(picture.astype(int).sum(axis=2) // 3, abs=1)


@pytest.mark.parametrize("name", ["above", "plan"])
def test_each_pixel_tells_whose_it_is_and_the_image_stays_one_of_colours(client: Client, name: str) -> None:
    camera, red, blue = client.camera(name), client.object("red"), client.object("blue")
    before = camera.rgb()
    owners = camera.objects()
    assert (owners.shape, owners.dtype) == ((48, 64), np.int32)
    assert set(np.unique(owners)) == {-1, red.handle, blue.handle}
    for thing, channel, up, left in ((red, 0, True, True), (blue, 2, False, False)):
        # Highlights are white, so they have a little of every colour.
        seen = (before[:, :, channel] > 0) & (before.argmax(axis=2) == channel)
        assert np.array_equal(owners == thing.handle, seen)
        rows, columns = np.nonzero(owners == thing.handle)
        assert ((rows.mean() < 24), (columns.mean() < 32)) == (up, left)
    assert np.array_equal(camera.rgb(), before)


def test_pixels_and_depths_give_the_points_of_the_scene(client: Client) -> None:
    camera = client.camera("above")
    picture, depth = camera.rgb(), camera.depth()
    f = 32 / np.tan(camera.perspective_angle / 2)
    rows, columns = np.nonzero((picture[:, :, 0] > 100) & (depth < 2.2))
    ahead = depth[rows, columns]
    points = np.stack([(31.5 - columns) / f * ahead, (23.5 - rows) / f * ahead, ahead], axis=1)
    found = points @ camera.pose.matrix[:3, :3].T + camera.position
    pixel = 2 / f
    assert found.min(axis=0) == pytest.approx([-0.7, 0.2, 1.0], abs=pixel)
    assert found.max(axis=0) == pytest.approx([-0.3, 0.4, 1.0], abs=pixel)


def test_an_image_is_the_callers_own_and_lies_in_memory_as_libraries_want_it(client: Client) -> None:
    picture = client.camera("above").rgb()
    picture[:] = 7
    assert picture.flags.c_contiguous
    assert client.camera("above").depth().flags.writeable


def test_a_proximity_sensor_tells_point_distance_and_object(client: Client) -> None:
    eye = client.proximity_sensor("eye")
    with client.stepping() as step:
        step()
        detection = eye.read()
        assert detection is not None
        assert detection.distance == pytest.approx(0.9, abs=1e-5)
        assert detection.point == pytest.approx([0, 0, 0.9], abs=1e-5)
        assert detection.normal == pytest.approx([0, 0, -1], abs=1e-5)
        assert detection.object == client.object("wall")
        assert detection.object.name == "wall"
        client.object("wall").position = [1, 30, 1]
        step()
        assert eye.read() is None


def test_a_force_sensor_feels_the_weight(client: Client) -> None:
    cell = client.force_sensor("cell")
    assert cell.read() is None
    assert not cell.is_broken
    with client.stepping() as step:
        for _ in range(3):
            step()
        wrench = cell.read()
        assert wrench is not None
        assert np.linalg.norm(wrench.force) == pytest.approx(2 * FREE_FALL, rel=1e-3)
        assert np.linalg.norm(wrench.torque) == pytest.approx(2 * FREE_FALL * 0.2, rel=1e-3)


# --- signals, scripts, simulation ------------------------------------------------------------------


def test_signals_have_the_type_of_their_value(client: Client) -> None:
    for value in (3, 0.5, "grün", -1):
        client.signals["it"] = value
        read = client.signals["it"]
        assert (type(read), read) == (type(value), value)
    client.signals["it"] = b"\x00\xff"
    assert client.signals.buffers["it"] == b"\x00\xff"
    client.signals["n"] = np.float32(0.25)
    assert client.signals.floats["n"] == 0.25
    client.signals["n"] = np.int64(4)
    assert client.signals.get("n", None) == 4
    assert "it" in client.signals
    del client.signals["it"]
    assert "it" not in client.signals
    assert client.signals.get("it", "nothing") == "nothing"


def test_a_missing_signal_is_a_key_error_that_names_those_there_are(client: Client) -> None:
    client.signals["speed"] = 1.5
    with pytest.raises(errors.NoSuchSignal, match=r"^there is no float signal 'sped'; set are: 'speed'"):
        _ = client.signals.floats["sped"]
    with pytest.raises(KeyError):
        _ = client.signals["sped"]
    with pytest.raises(ValueError, match="needs a name"):
        client.signals[""] = 1


def test_a_name_in_two_kinds_must_be_asked_for_by_kind(client: Client) -> None:
    client.signals.ints["it"] = 1
    client.signals.strings["it"] = "one"
    with pytest.raises(ValueError, match="set in 2 kinds"):
        _ = client.signals["it"]
    assert (client.signals.ints["it"], client.signals.strings["it"]) == (1, "one")
