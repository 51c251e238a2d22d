"""The topics of annotated objects agree with the remote API at the same simulation step."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest
from processes import ROOT
from ray_painter import RayPainter
from real_world import BLOCKING, render_with
from ros2_contents import HEAD, Contents, in_frame, matrix

import simx_client as v
from simx_server.errors import CommandError
from simx_server.gateways.ros2.endpoints import Published
from simx_server.scene.formats.annotations import SceneError
from simx_server.scene.formats.loader import load_text

SCENES = ROOT / "scenes"
Make = Callable[[str | Path], Contents]


@pytest.fixture
def node(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[Make]:
    """Opens a scene, given as a file or as the text of one."""
    monkeypatch.setenv("MUJOCO_GL", "disable")
    opened: list[Contents] = []

    def make(scene: str | Path) -> Contents:
        if isinstance(scene, str):
            path = tmp_path / f"scene{len(opened)}.xml"
            path.write_text(scene, encoding="utf-8")
            scene = path
        opened.append(Contents(scene))
        return opened[-1]

    yield make
    for each in opened:
        each.close()


def twist(x: float = 0.0, y: float = 0.0, turn: float = 0.0) -> dict[str, dict[str, float]]:
    return {"linear": {"x": x, "y": y, "z": 0.0}, "angular": {"x": 0.0, "y": 0.0, "z": turn}}


def yaw(pose: np.ndarray) -> float:
    return math.atan2(pose[1, 0], pose[0, 0])


# --- the Pioneer ----------------------------------------------------------------------------------


def test_pioneer_scan_holds_the_points_that_the_remote_api_reads(node: Make) -> None:
    pioneer = node(SCENES / "pioneer_p3dx.xml")
    assert pioneer.message("/scan") is None  # sensors have no result before the first step
    pioneer.start()
    pioneer.send("/cmd_vel", twist(0.3, turn=0.5), "Twist")
    pioneer.step(8)
    scan = pioneer.message("/scan")
    base = np.linalg.inv(pioneer.pose("Pioneer_p3dx"))
    wanted: dict[int, float] = {}
    silent: set[int] = set()
    for number in range(1, 17):
        name = f"Pioneer_p3dx_ultrasonicSensor{number}"
        _, found, point, _, _ = v.simxReadProximitySensor(pioneer.cid, pioneer.handle(name), BLOCKING)
        sensor = base @ pioneer.pose(name)
        x, y, _, _ = sensor @ [*point, 1.0] if found else sensor @ [0, 0, 1, 0]
        place = round((math.degrees(math.atan2(y, x)) + 170) / 10)
        if found:
            wanted[place] = min(wanted.get(place, math.inf), math.hypot(x, y))
        else:
            silent.add(place)
    assert wanted
    assert silent
    ranges = scan["ranges"]
    assert len(ranges) == 35
    for place, distance in enumerate(ranges.tolist()):
        if place in wanted:
            assert distance == pytest.approx(wanted[place], abs=1e-5)
        elif place in silent:
            assert distance == math.inf
        else:
            assert math.isnan(distance)
    assert scan["angle_min"] == pytest.approx(math.radians(-170))
    assert scan["angle_max"] == pytest.approx(math.radians(170))
    assert scan["angle_increment"] == pytest.approx(math.radians(10))
    assert scan["header"] == {"stamp": {"sec": 0, "nanosec": 400_000_000}, "frame_id": "Pioneer_p3dx"}


def test_pioneer_odometry_and_transforms_are_the_remote_apis_poses(node: Make) -> None:
    pioneer = node(SCENES / "pioneer_p3dx.xml")
    # Placed elsewhere before the start: the odometry starts there.
    handle = pioneer.handle("Pioneer_p3dx")
    v.simxSetObjectOrientation(pioneer.cid, handle, -1, (0.0, 0.0, 0.7), BLOCKING)
    v.simxSetObjectPosition(pioneer.cid, handle, -1, (-0.5, 0.2, 0.1388), BLOCKING)
    start = pioneer.pose("Pioneer_p3dx")
    pioneer.start()
    pioneer.send("/cmd_vel", twist(0.4, turn=-0.6), "Twist")
    pioneer.step(9)
    pose = np.linalg.inv(start) @ pioneer.pose("Pioneer_p3dx")
    odometry = pioneer.message("/odom")
    place, turn = odometry["pose"]["pose"]["position"], odometry["pose"]["pose"]["orientation"]
    assert np.allclose(matrix([*place.values()], [*turn.values()]), pose, atol=1e-6)
    assert (odometry["header"]["frame_id"], odometry["child_frame_id"]) == ("odom", "base_link")
    _, linear, _ = v.simxGetObjectVelocity(pioneer.cid, handle, BLOCKING)
    back = pioneer.pose("Pioneer_p3dx")[:3, :3].T
    assert np.allclose([*odometry["twist"]["twist"]["linear"].values()], back @ linear, atol=1e-6)
    assert odometry["twist"]["twist"]["angular"]["z"] == pytest.approx(-0.6, abs=0.05)
    assert odometry["pose"]["covariance"][0] > 0
    frames = pioneer.transforms()
    assert frames["base_link"][0] == "odom"
    assert np.allclose(frames["base_link"][1], pose, atol=1e-6)
    assert "odom" not in frames  # left to localisation
    for name in ("Pioneer_p3dx", "Pioneer_p3dx_leftWheel", "Pioneer_p3dx_ultrasonicSensor3"):
        remote = np.linalg.inv(start) @ pioneer.pose(name)
        assert np.allclose(in_frame(frames, name, "odom"), remote, atol=1e-6), name


def test_pioneer_drives_as_commanded_and_stops_when_commands_cease(node: Make) -> None:
    pioneer = node(SCENES / "pioneer_p3dx.xml")
    pioneer.start()
    pioneer.send("/cmd_vel", {"twist": twist(0.2)}, "TwistStamped")
    pioneer.step(9)
    before = pioneer.pose("Pioneer_p3dx")
    joints = [pioneer.handle(f"Pioneer_p3dx_{side}Motor") for side in ("left", "right")]

    def targets() -> list[float]:
        return [
            v.simxGetObjectFloatParameter(pioneer.cid, joint, v.sim_jointfloatparam_velocity, BLOCKING)[1]
            for joint in joints
        ]

    assert targets() == pytest.approx([0.2 / 0.0975] * 2, rel=0.05)
    pioneer.step(1)
    step = np.linalg.inv(before) @ pioneer.pose("Pioneer_p3dx")
    assert step[0, 3] / 0.05 == pytest.approx(0.2, rel=0.1)
    pioneer.step(3)  # 0.5 s are over
    assert targets() == pytest.approx([0.0, 0.0], abs=0.05)
    # Turning anticlockwise the left wheel turns backward, by the track between the wheels.
    pioneer.send("/cmd_vel", twist(turn=1.0), "Twist")
    pioneer.step(6)
    assert targets() == pytest.approx([-0.1655 / 0.0975, 0.1655 / 0.0975], rel=0.1)


@pytest.mark.parametrize("value", [math.nan, math.inf, 1e9, -1e300, 1.7e308])
def test_a_twist_that_no_wheel_can_follow_is_refused(node: Make, value: float) -> None:
    pioneer = node(SCENES / "pioneer_p3dx.xml")
    with pytest.raises(
        CommandError, match=r"/cmd_vel has linear\.x, linear\.y and angular\.z of .*finite numbers"
    ):
        pioneer.send("/cmd_vel", twist(value), "Twist")


def test_a_drive_of_the_next_scene_has_its_own_timeout(node: Make, tmp_path: Path) -> None:
    wheels = "".join(
        f'<body name="{side}_wheel" pos="0 {y} 0"><joint name="{side}" axis="0 1 0"/><geom size="0.05"/></body>'
        for side, y in (("left", 0.2), ("right", -0.2))
    )
    text = (
        f'{HEAD}<body name="car" pos="0 0 1"><freejoint/><geom size="0.1"/>{wheels}</body></worldbody><actuator>'
        '<velocity joint="left"/><velocity joint="right"/></actuator><custom><text name="simx:ros2:car" '
        'data="drive=diff left=left right=right radius=0.05 timeout={}"/></custom></mujoco>'
    )
    car, other = node(text.replace("{}", "5")), tmp_path / "other.xml"
    other.write_text(text.replace("{}", "0.1"), encoding="utf-8")
    car.world.simulation.load(other)
    car.offers()
    car.start()
    car.send("/cmd_vel", twist(1.0), "Twist")
    joints, left = car.world.simulation.joints, car.handle("left")
    assert joints.target_velocity(left) == pytest.approx(20.0)
    car.step(3)
    assert joints.target_velocity(left) == 0.0


def test_copies_of_a_robot_have_names_of_their_own(node: Make) -> None:
    two = node(
        '<mujoco><include file="' + str(SCENES / "models" / "pioneer_p3dx.xml") + '"/>'
        '<worldbody><geom type="plane" size="5 5 0.1"/></worldbody>'
        '<custom><text name="simx:copies:Pioneer_p3dx" data="y=1"/></custom></mujoco>'
    )
    own = {"/cmd_vel", "/odom", "/scan"}
    assert own | {f"/Pioneer_p3dx_0{topic}" for topic in own} <= two.topics()
    two.start()
    two.send("/Pioneer_p3dx_0/cmd_vel", twist(turn=1.0), "Twist")
    two.step(5)
    assert abs(yaw(two.pose("Pioneer_p3dx"))) < 0.01
    assert yaw(two.pose("Pioneer_p3dx#0")) > 0.1
    assert two.message("/Pioneer_p3dx_0/odom")["child_frame_id"] == "Pioneer_p3dx_0/base_link"
    frames = two.transforms()
    assert frames["Pioneer_p3dx#0"][0] == "Pioneer_p3dx_0/base_link"
    assert frames["Pioneer_p3dx"][0] == "base_link"


# --- the other robots -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("command", "expected"),
    [
        (twist(0.2), (0.2, 0.0, 0.0)),
        (twist(y=0.2), (0.0, 0.2, 0.0)),
        (twist(turn=0.5), (0.0, 0.0, 0.5)),
    ],
)
def test_youbot_drives_in_each_direction(
    node: Make, command: dict[str, dict[str, float]], expected: tuple[float, ...]
) -> None:
    youbot = node(SCENES / "youbot.xml")
    youbot.start()
    youbot.send("/cmd_vel", command, "Twist")
    youbot.step(9)
    moved = youbot.message("/odom")["twist"]["twist"]
    found = moved["linear"]["x"], moved["linear"]["y"], moved["angular"]["z"]
    assert found == pytest.approx(expected, abs=0.05)
    # The frame stands on the floor below the robot, which drives along y of the dummy.
    frames = youbot.transforms()
    dummy = in_frame(frames, "youBot_ref", "base_link")
    assert dummy[:3, 1] == pytest.approx([1, 0, 0], abs=1e-6)
    assert dummy[:3, 2] == pytest.approx([0, 0, 1], abs=1e-6)


def test_ur5_has_the_names_and_zeros_of_its_urdf_on_topics_of_ros2_control(node: Make) -> None:
    ur5 = node(SCENES / "ur5.xml")
    names = [*(f"shoulder_{each}_joint" for each in ("pan", "lift")), "elbow_joint"]
    names += [f"wrist_{number}_joint" for number in (1, 2, 3)]
    assert ur5.message("/robot_joint_states")["name"] == names
    ur5.start()
    wanted = [0.1 - math.pi / 2, -math.pi / 2 - 0.2, 0.3, -math.pi / 2, -0.2, 0.1]
    ur5.send("/robot_joint_commands", {"name": names, "position": wanted})
    ur5.step(40)
    assert ur5.message("/robot_joint_states")["position"] == pytest.approx(wanted, abs=0.01)
    scene = [0.1, -0.2, 0.3, 0.0, -0.2, 0.1]
    for number, value in enumerate(scene, 1):
        joint = ur5.handle(f"UR5_joint{number}")
        assert v.simxGetJointPosition(ur5.cid, joint, BLOCKING)[1] == pytest.approx(value, abs=0.01)
    assert "UR5_joint1" in ur5.message("/joint_states")["name"]
    with pytest.raises(CommandError, match="there is no joint 'elbow'"):
        ur5.send("/robot_joint_commands", {"name": ["elbow"], "position": [0.0]})


def test_quadricopter_feels_its_weight(node: Make) -> None:
    flyer = node(SCENES / "quadricopter.xml")
    assert flyer.message("/imu/data")["linear_acceleration"]["z"] == pytest.approx(9.81)
    flyer.start()
    flyer.step(1)
    assert flyer.message("/imu/data") is None  # the velocity of the step before is not known
    for _ in range(3):
        flyer.step()
        imu = flyer.message("/imu/data")
    assert imu["header"]["frame_id"] == "imu_link"
    assert imu["linear_acceleration"]["z"] == pytest.approx(9.81, abs=3)
    assert flyer.message("/odom")["header"]["frame_id"] == "odom"
    assert flyer.transforms()["imu_link"][0] == "Quadricopter"


# --- single keys ----------------------------------------------------------------------------------


def test_an_imu_that_falls_feels_nothing_and_one_that_turns_measures_its_rate(node: Make) -> None:
    scene = node(
        HEAD + '<body name="stone" pos="0 0 50" quat="0 1 0 0"><freejoint/><geom size="0.1"/></body>'
        '<body name="disc"><joint name="axle" axis="0 0 1"/><geom type="cylinder" size="0.1 0.01"/></body>'
        '</worldbody><actuator><velocity joint="axle" kv="1"/></actuator><custom>'
        '<text name="simx:ros2:stone" data="imu=/fall frame=stone_imu"/>'
        '<text name="simx:ros2:disc" data="imu=turn"/></custom></mujoco>'
    )
    scene.start()
    v.simxSetJointTargetVelocity(scene.cid, scene.handle("axle"), 2.0, BLOCKING)
    for count in range(10):
        scene.step()
        if count == 5:
            scene.offers()  # they are listed again now and then, and measuring goes on
        fall, turn = scene.message("/fall"), scene.message("/turn")
    assert [*fall["linear_acceleration"].values()] == pytest.approx([0, 0, 0], abs=1e-3)
    assert fall["orientation"]["x"] == pytest.approx(1.0)
    assert [*turn["angular_velocity"].values()] == pytest.approx([0, 0, 2.0], abs=0.02)
    assert turn["linear_acceleration"]["z"] == pytest.approx(9.81, abs=1e-6)
    assert scene.message("/turn")["angular_velocity"] == turn["angular_velocity"]  # the same step again
    assert turn["header"]["frame_id"] == "disc"


RING = (
    HEAD
    + '<body name="wall" pos="2 0 0"><geom type="box" size="0.1 1 1"/></body>'
    + '<body name="lidar"><replicate count="8" euler="0 0 0.78539816">'
    + '<site name="ray" zaxis="1 0 0"/></replicate></body></worldbody><sensor>'
    + "".join(f'<rangefinder site="ray{number}" cutoff="5"/>' for number in range(8))
    + "</sensor><custom>"
    + '<text name="simx:ros2:lidar" data="scan=/scan frame=laser forward=y"/>'
    + '<text name="simx:ros2:ray0" data="range=/front frame=front_range"/></custom></mujoco>'
)


def test_a_ring_of_rangefinders_has_one_value_for_each(node: Make) -> None:
    ring = node(RING)
    ring.start()
    ring.step()
    scan = ring.message("/scan")
    assert scan["header"]["frame_id"] == "laser"
    assert scan["angle_increment"] == pytest.approx(math.pi / 4)
    angles = [scan["angle_min"] + place * scan["angle_increment"] for place in range(len(scan["ranges"]))]
    near = {round(math.degrees(angle)): value for angle, value in zip(angles, scan["ranges"], strict=True)}
    assert len(near) == 8
    # The wall stands at x, which is to the right of a frame that looks along y.
    assert near[-90] == pytest.approx(1.9, abs=1e-5)
    assert near[90] == math.inf
    assert scan["range_max"] == pytest.approx(5.0)
    looks = ring.transforms()["laser"]
    assert looks[0] == "lidar"
    assert looks[1][:3, 0] == pytest.approx([0, 1, 0], abs=1e-9)


@pytest.mark.parametrize(("keys", "seconds"), [("", 0.05), (" rate=5", 0.2), (" rate=1000", 0.05)])
def test_a_scan_tells_the_time_between_two(node: Make, keys: str, seconds: float) -> None:
    ring = node(RING.replace("scan=/scan", f"scan=/scan{keys}"))
    ring.start()
    ring.step()
    assert ring.message("/scan")["scan_time"] == pytest.approx(seconds)


def test_a_range_is_the_distance_along_x_of_its_frame(node: Make) -> None:
    ring = node(RING)
    ring.start()
    ring.step()
    front = ring.message("/front")
    assert front["range"] == pytest.approx(1.9, abs=1e-5)
    assert (front["min_range"], front["max_range"], front["field_of_view"]) == (0, 5, 0)
    frames = ring.transforms()
    assert in_frame(frames, "front_range", "world")[:3, 0] == pytest.approx([1, 0, 0], abs=1e-9)


def test_the_scene_sets_rate_root_and_whether_there_are_transforms(node: Make) -> None:
    body = '<body name="box"><joint name="hinge"/><geom size="0.1"/></body></worldbody><custom>'
    scene = node(HEAD + body + '<text name="simx:ros2:world" data="root=map rate=5"/></custom></mujoco>')
    assert scene.transforms()["box"][0] == "map"
    periods = {each.topic: each.period for each in scene.offers() if isinstance(each, Published)}
    assert periods["/tf"] == periods["/joint_states"] == pytest.approx(0.2)
    without = node(HEAD + body + '<text name="simx:ros2:world" data="tf=no"/></custom></mujoco>')
    assert not {"/tf", "/tf_static"} & without.topics()


def test_a_camera_has_other_names_and_a_jpeg_of_its_image(node: Make) -> None:
    scene = node(
        HEAD + '<body name="ball" pos="0 0.5 0.3"><geom size="0.3" rgba="1 0 0 1"/></body>'
        '<camera name="eye" pos="0 -2 0" xyaxes="1 0 0 0 0 1" resolution="64 48"/></worldbody><custom>'
        '<text name="simx:ros2:eye" data="topic=front/camera frame=lens rate=10 compressed=yes"/>'
        "</custom></mujoco>"
    )
    render_with(scene.world, RayPainter())
    assert "/eye/image_raw" not in scene.topics()
    image = scene.message("/front/camera/image_raw")
    packed = scene.message("/front/camera/image_raw/compressed")
    assert packed["header"] == image["header"]
    assert packed["header"]["frame_id"] == "lens"
    assert packed["format"] == "rgb8; jpeg compressed bgr8"
    wanted = image["data"].reshape(48, 64, 3).astype(int)
    found = np.asarray(cv2.imdecode(packed["data"], cv2.IMREAD_COLOR))[:, :, ::-1].astype(int)
    assert np.abs(found - wanted).mean() < 4
    top, bottom = wanted[:24, :, 0].mean(), wanted[24:, :, 0].mean()
    assert top > bottom + 5  # the red ball is above the middle
    # z of the frame looks forward, x to the right, y down.
    turn = in_frame(scene.transforms(), "lens", "world")[:3, :3]
    assert np.allclose(turn, [[1, 0, 0], [0, 0, 1], [0, -1, 0]], atol=1e-9)


def test_joints_are_renamed_and_left_out(node: Make) -> None:
    scene = node(
        HEAD + '<body name="a"><joint name="one"/><geom size="0.1"/>'
        '<body name="b"><joint name="two"/><geom size="0.1"/></body></body></worldbody><custom>'
        '<text name="simx:ros2:one" data="name=shoulder"/><text name="simx:ros2:two" data="publish=no"/>'
        "</custom></mujoco>"
    )
    assert scene.message("/joint_states")["name"] == ["shoulder"]
    scene.start()
    scene.send("/joint_command", {"name": ["shoulder"], "velocity": [0.5]})
    scene.step(10)
    _, position = v.simxGetJointPosition(scene.cid, scene.handle("one"), BLOCKING)
    assert scene.message("/joint_states")["position"] == pytest.approx([position])


def test_a_transform_follows_what_is_placed_elsewhere_between_steps(node: Make) -> None:
    scene = node(HEAD + '<body name="box"><freejoint/><geom size="0.1"/></body></worldbody></mujoco>')

    def place(z: float) -> None:
        scene.execute([("simxSetObjectPosition", [scene.handle("box"), -1, [0.0, 0.0, z]])])
        assert scene.transforms()["box"][1][2, 3] == pytest.approx(z)

    place(2.0)
    scene.start()
    scene.step()
    place(5.0)
    scene.world.simulation.pause()
    place(7.0)


def test_a_fixed_odometry_frame_stands_where_the_run_started(node: Make) -> None:
    scene = node(
        HEAD
        + '<body name="car" pos="1 2 0.5" quat="0.70710678 0 0 0.70710678"><freejoint/><geom size="0.1"/>'
        '</body></worldbody><custom><text name="simx:ros2:car" data="odom=/odom base=car_link odom_frame=start '
        'parent_frame=world"/></custom></mujoco>'
    )
    scene.start()
    start = scene.pose("car")
    scene.step(4)
    frames = scene.transforms()
    assert np.allclose(in_frame(frames, "start", "world"), start, atol=1e-6)
    assert np.allclose(in_frame(frames, "car", "world"), scene.pose("car"), atol=1e-6)


def test_the_odometry_frame_is_level_where_the_base_starts_tilted(node: Make) -> None:
    scene = node(
        HEAD
        + '<body name="car" pos="0 0 0.5" euler="0 0.4 0"><freejoint/><geom size="0.1"/></body></worldbody>'
        '<custom><text name="simx:ros2:car" data="odom=/odom parent_frame=world"/></custom></mujoco>'
    )
    scene.start()
    scene.step()
    frames = scene.transforms()
    assert np.allclose(in_frame(frames, "odom", "world")[:3, :3], np.eye(3), atol=1e-9)
    turn = scene.message("/odom")["pose"]["pose"]["orientation"]
    assert turn["y"] == pytest.approx(math.sin(0.2), abs=1e-3)
    assert np.allclose(in_frame(frames, "car", "world"), scene.pose("car"), atol=1e-6)


@pytest.mark.parametrize(
    ("data", "said"),
    [
        ("left=one radius=1", "needs drive= beside it"),
        ("drive=diff left=one", "has a drive, which needs right, radius"),
        ("drive=diff left=one right=car radius=1", "right=car, which is no joint of the scene"),
        ("drive=mecanum left=one right=one radius=1", "two joints in left and two in right"),
        ("odom=/odom forward=z", "forward=z and up=z, which are not at right angles"),
        ("scan=/scan angle_min_deg=90 angle_max_deg=0", "a scan from 90 to 0 degrees"),
        ("range=/range", "is for a proximity sensor; the object is a shape"),
        ("name=a", "is for a joint; the object is a shape"),
        ("scan=/a#0", "valid for scan is a topic such as /odom"),
        ("scan=/scan increment_deg=1e-300", "valid for increment_deg is a number from 0.01 to 360"),
        ("odom=/odom rate=1e300", "valid for rate is a number from 0.001 to 10000"),
        ("root=map", "which is for the scene: simx:ros2:world"),
        ("states=/states joints=one", "valid for joints is joints such as arm1:shoulder"),
        ("states=/states joints=none:a", "joints=none, which is no joint of the scene"),
    ],
)
def test_a_wrong_annotation_is_refused_with_what_is_valid(data: str, said: str) -> None:
    text = (
        HEAD + '<body name="car"><joint name="one"/><geom size="0.1"/></body></worldbody><custom>'
        f'<text name="simx:ros2:car" data="{data}"/></custom></mujoco>'
    )
    with pytest.raises(SceneError) as raised:
        load_text(text)
    assert said in str(raised.value)


def test_a_wrong_key_of_the_scene_is_refused() -> None:
    text = HEAD + '</worldbody><custom><text name="simx:ros2:world" data="odom=/odom"/></custom></mujoco>'
    with pytest.raises(SceneError, match="has odom=; valid for the scene are rate, tf, root, helper"):
        load_text(text)
