"""The tutorial's scene as a client sees it: pictures and their colours, depth, the gripper, a grasp, a reset."""

import math

import numpy as np
import pytest
from real_world import BLOCKING, RealWorld, handle_of, start_stepped, step

import simx_client as v
from simx_server.service.warm_up import warm_up

pytestmark = [pytest.mark.slow, pytest.mark.gl]

VIEW = [90, -45, 90, 0, -100, 0]  # degrees: ball, green cube and yellow cylinder are in the picture
GRASP = [78.0, 12.2, 110.7, -32.9, -90.0, -12.0]  # the pads stand around a ball at (-0.2, 0.35, 0.025)
BALL = np.array([-0.525, 0.15, 0.075])
NEAR, FAR = 0.01, 3.5
FOCAL = 320 / math.tan(math.radians(57) / 2)  # pixels: the angle belongs to the 640 columns
COLOUR_TOLERANCE = 6


@pytest.fixture(scope="module", params=["opengl", "raycast"])
def tutorial(request):
    """The world at the view pose, and the pictures of both cameras; with and without OpenGL."""
    with pytest.MonkeyPatch.context() as patch:
        if request.param == "raycast":
            patch.setenv("MUJOCO_GL", "disable")
        world = RealWorld("ur5_rg2_kinect")
        cid = world.client()
        try:
            images = warm_up(world.parts)  # as a server does before it is ready
            assert images is not None
            images.result(60.0)
            start_stepped(cid)
            go(cid, VIEW)
            step(cid, 2.0)
            pictures = {}
            for name in ("kinect_rgb", "kinect_depth"):
                code, resolution, image = v.simxGetVisionSensorImage(cid, handle_of(cid, name), 0, BLOCKING)
                assert (code, resolution) == (0, [640, 480])
                pictures[name] = np.array(image, dtype=np.uint8).reshape(480, 640, 3)[::-1]
            backend = world.parts.rendering.backend
            assert backend is not None
            if backend.name == "raycast" and request.param == "opengl":
                pytest.skip("no OpenGL on this machine: apt-get install libegl1 libopengl0 libgl1-mesa-dri")
            yield world, cid, pictures
        finally:
            world.close()


def go(cid, degrees):
    joints = [handle_of(cid, f"UR5_joint{number}") for number in range(1, 7)]
    v.simxPauseCommunication(cid, True)
    for joint, angle in zip(joints, degrees, strict=True):
        v.simxSetJointTargetPosition(cid, joint, math.radians(angle), v.simx_opmode_oneshot)
    v.simxPauseCommunication(cid, False)


def camera_pose(cid):
    """Position and axes (columns: x = left in the picture, y = up, z = view) of the hand camera."""
    sensor = handle_of(cid, "kinect_rgb")
    position = v.simxGetObjectPosition(cid, sensor, -1, BLOCKING)[1]
    x, y, z, w = v.simxGetObjectQuaternion(cid, sensor, -1, BLOCKING)[1]
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    return np.array(position), rotation


def project(cid, point):
    """(column, row from the top, depth) of a world point, by V-REP's camera model."""
    position, rotation = camera_pose(cid)
    left, up, depth = rotation.T @ (np.asarray(point) - position)
    return 320 - FOCAL * left / depth, 240 - FOCAL * up / depth, depth


def assert_colour(picture, point, expected):
    column, row = point
    patch = picture[row - 2 : row + 3, column - 2 : column + 3].reshape(-1, 3).astype(int)
    assert np.abs(np.median(patch, axis=0) - expected).max() <= COLOUR_TOLERANCE, np.median(patch, axis=0)


def pixel(cid, point):
    column, row, _ = project(cid, point)
    return round(column), round(row)


def test_the_three_things_have_the_colours_of_the_authors_image(tutorial):
    _, cid, pictures = tutorial
    rgb = pictures["kinect_rgb"]
    assert_colour(rgb, pixel(cid, (-0.644, 0.274, 0.2)), (186, 218, 0))  # top of the yellow cylinder
    assert_colour(rgb, pixel(cid, (-0.75, 0.105, 0.05)), (62, 172, 23))  # front of the green cube
    light, dark = (197, 195, 188), (180, 177, 169)
    assert_colour(rgb, pixel(cid, (-0.25, 0.25, 0.0)), light)
    assert_colour(rgb, pixel(cid, (-0.25, -0.1, 0.0)), dark)


def test_the_balls_centre_is_where_the_camera_numbers_project_it(tutorial):
    _, cid, pictures = tutorial
    r, g, b = (pictures["kinect_rgb"][:, :, channel].astype(int) for channel in range(3))
    rows, columns = np.nonzero((b > 120) & (b > r + 60) & (g > r + 40))
    column, row, _ = project(cid, BALL)
    # Half way between the outermost pixels: the outline of a sphere is symmetric, its shading is not.
    assert (columns.min() + columns.max()) / 2 == pytest.approx(column, abs=2)
    assert (rows.min() + rows.max()) / 2 == pytest.approx(row, abs=2)


def test_the_depth_image_is_grey_and_follows_the_formula_at_the_balls_centre(tutorial):
    _, cid, pictures = tutorial
    grey = pictures["kinect_depth"]
    assert (grey[:, :, 0] == grey[:, :, 1]).all()
    assert (grey[:, :, 0] == grey[:, :, 2]).all()
    position, rotation = camera_pose(cid)
    column, row = pixel(cid, BALL)
    ray = rotation @ np.array([(320 - column) / FOCAL, (240 - row) / FOCAL, 1.0])
    to_ball = BALL - position
    # The nearer root of |t * ray - to_ball| = 0.05; t is the depth along the view axis.
    a, b, c = ray @ ray, ray @ to_ball, to_ball @ to_ball - 0.05**2
    depth = (b - math.sqrt(b * b - a * c)) / a
    assert int(grey[row, column, 0]) == pytest.approx(255 * (depth - NEAR) / (FAR - NEAR), abs=2)


def test_the_depth_buffer_agrees_with_the_depth_image(tutorial):
    _, cid, pictures = tutorial
    code, resolution, buffer = v.simxGetVisionSensorDepthBuffer(cid, handle_of(cid, "kinect_depth"), BLOCKING)
    assert (code, resolution, len(buffer)) == (0, [640, 480], 640 * 480)
    depth = np.array(buffer).reshape(480, 640)[::-1]
    assert np.abs(depth * 255 - pictures["kinect_depth"][:, :, 0]).max() <= 1.001
    assert 0.0 <= depth.min() < depth.max() <= 1.0


def test_grey_scale_is_the_integer_mean_and_a_third_of_the_values(tutorial):
    _, cid, pictures = tutorial
    sensor = handle_of(cid, "kinect_rgb")
    code, resolution, image = v.simxGetVisionSensorImage(cid, sensor, 1, BLOCKING)
    assert (code, resolution, len(image)) == (0, [640, 480], 640 * 480)
    mean = pictures["kinect_rgb"].astype(int).sum(axis=2) // 3
    assert (np.array(image, dtype=np.uint8).reshape(480, 640)[::-1] == mean).all()


def test_the_first_image_at_the_start_pose_is_all_black():
    world = RealWorld("ur5_rg2_kinect")
    cid = world.client()
    try:
        _, _, image = v.simxGetVisionSensorImage(cid, handle_of(cid, "kinect_rgb"), 0, BLOCKING)
        assert not any(image)
        _, _, image = v.simxGetVisionSensorImage(cid, handle_of(cid, "kinect_depth"), 0, BLOCKING)
        assert set(image) == {-1}  # 255 as a signed byte: nothing up to the far plane
    finally:
        world.close()


@pytest.fixture
def ball_world():
    world = RealWorld("ur5_rg2_kinect_ball")
    yield world
    world.close()


def call_gripper(cid, function):
    result = v.simxCallScriptFunction(
        cid, "RG2", v.sim_scripttype_childscript, function, [], [], [], b"", BLOCKING
    )
    assert result[0] == 0
    return result


def test_a_ball_is_grasped_lifted_and_held_for_five_seconds(ball_world):
    cid = ball_world.client()
    start_stepped(cid)
    ball, fingers = handle_of(cid, "Ball"), handle_of(cid, "RG2_openCloseJoint")
    above = [78.0, 0.0, 110.7, -20.7, -90.0, -12.0]
    go(cid, above)
    step(cid, 2.5)
    go(cid, GRASP)
    step(cid, 1.5)
    code, ints, floats, strings, data = call_gripper(cid, "rg2Close")
    assert (code, ints, strings, data) == (0, [], [], bytearray())
    assert floats == pytest.approx([-0.05])
    step(cid, 2.0)
    assert v.simxGetJointPosition(cid, fingers, BLOCKING)[1] == pytest.approx(0.0025, abs=0.002)
    go(cid, above)
    step(cid, 1.5)
    lifted = np.array(v.simxGetObjectPosition(cid, ball, -1, BLOCKING)[1])
    assert lifted[2] > 0.08
    step(cid, 5.0)
    held = np.array(v.simxGetObjectPosition(cid, ball, -1, BLOCKING)[1])
    assert np.abs(held - lifted).max() < 0.001
    call_gripper(cid, "rg2Open")
    step(cid, 1.5)
    assert v.simxGetObjectPosition(cid, ball, -1, BLOCKING)[1][2] < 0.03


def test_the_integer_signal_of_the_stock_gripper_works_too(ball_world):
    cid = ball_world.client()
    start_stepped(cid)
    fingers = handle_of(cid, "RG2_openCloseJoint")
    for value, reached in ((0, lambda q: q < -0.045), (1, lambda q: q > 0.053)):
        v.simxSetIntegerSignal(cid, "RG2_open", value, BLOCKING)
        step(cid, 2.5)
        assert reached(v.simxGetJointPosition(cid, fingers, BLOCKING)[1])


def test_the_same_calls_give_the_same_numbers_bit_for_bit_after_a_stop(ball_world):
    cid = ball_world.client()

    def run():
        start_stepped(cid)
        go(cid, VIEW)
        step(cid, 1.0)
        data = ball_world.simulation.data
        state = (data.qpos.tobytes(), data.qvel.tobytes())
        v.simxStopSimulation(cid, BLOCKING)
        return state, ball_world.simulation.data.qpos.tobytes()

    before = ball_world.simulation.data.qpos.tobytes()
    first, restored = run()
    assert restored == before
    assert run() == (first, before)
