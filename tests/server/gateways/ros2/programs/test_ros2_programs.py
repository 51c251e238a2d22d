"""Programs of ROS 2's users drive scenes of V-REP's own: a wall follower, an arm's trajectories, a depth camera."""

from __future__ import annotations

import re
from pathlib import Path

import mujoco
import numpy as np
import pytest
from real_world import BLOCKING, handle_of
from ros2_world import Ros2World, ros2_world
from sdk_examples import output_of, run_example, start_example
from vrep_samples import sample

import simx_client as v
from simx_server.ros2_messages import BY_NAME
from simx_server.scene.formats.vrep.conversion.geometry.colliding import decomposition
from simx_server.scene.poses.frames import get_pose

SECONDS = 8.0
"""Simulated, of the wall follower."""

pytestmark = [pytest.mark.slow, pytest.mark.gl]


def floats(text: str) -> list[float]:
    return [float(each) for each in re.findall(r"-?\d+\.\d+", text)]


def start(server: Ros2World) -> int:
    cid = server.client()
    assert v.simxStartSimulation(cid, BLOCKING) == v.simx_return_ok
    return cid


def test_an_arm_of_a_scene_follows_the_trajectory_of_a_program(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Four of its joints have motors; physics does not move the other two, which are put where they belong."""
    monkeypatch.setattr(decomposition, "is_available", lambda: False)  # it takes seconds
    joints = {"waist": 0.4, "shoulder1": -0.2, "shoulder2": 0.2, "elbow": 0.3, "wrist1": -0.3, "wrist2": 0.5}
    with ros2_world(tmp_path, scene=sample("BusbotVREPscene.ttt")) as server:
        cid = start(server)
        goals = [f"{name}={angle}" for name, angle in joints.items()]
        said = run_example(server.port, "move_arm.py", "ResizableFloor_5_25_element_controller", *goals)
        assert said == "result 0 the goal is reached\n"
        for name, angle in joints.items():
            code, position = v.simxGetJointPosition(cid, handle_of(cid, name), BLOCKING)
            assert code == v.simx_return_ok
            assert position == pytest.approx(angle, abs=0.06)


def test_a_program_finds_what_is_nearest_to_a_camera(tmp_path: Path) -> None:
    with ros2_world(tmp_path, scene=sample("vision_sensor.ttt")) as server:
        cid = start(server)
        eye = handle_of(cid, "Vision_sensor")
        code, _, depth = v.simxGetVisionSensorDepthBuffer(cid, eye, BLOCKING)
        assert code == v.simx_return_ok
        said = run_example(server.port, "find_nearest.py", "/Vision_sensor")
        place, turn = server.on_server(lambda: get_pose(server.simulation, eye))
    right, down, forward = floats(said)
    near, far = 0.01, 10.0  # those of the sensor in the file
    assert forward == pytest.approx(near + min(depth) * (far - near), abs=1e-3)
    # The optical frame is that of V-REP's sensor, turned half around the axis of sight.
    turned = np.zeros(3)
    mujoco.mju_rotVecQuat(turned, np.array([-right, -down, forward]), np.array(turn))
    found = np.add(place, turned)
    assert found[0] == pytest.approx(
        -0.25, abs=0.01
    )  # the front of a cube of 0.5 m, whose middle is at 0, 0, 0.25
    assert abs(found[1]) < 0.26
    assert 0.0 < found[2] < 0.5
    red, green, blue = map(int, said.split("colour")[1].split())
    assert red > 100
    assert green == blue == 0


def test_a_program_follows_walls_by_the_scan_of_a_hokuyo(tmp_path: Path) -> None:
    scene, hokuyo = sample("controlledViaLegacyRemoteApi.ttt"), sample("Hokuyo URG 04LX UG01_Fast.ttm")
    with ros2_world(tmp_path, scene=scene) as server:
        cid = server.client()
        robot = handle_of(cid, "remoteApiControlledBubbleRob")
        code, scanner = v.simxLoadModel(cid, str(hokuyo), 1, BLOCKING)
        assert code == v.simx_return_ok
        for code in (
            v.simxSetObjectParent(cid, scanner, robot, True, BLOCKING),
            v.simxSetObjectPosition(cid, scanner, robot, (0.14, 0.0, 0.0), BLOCKING),
            v.simxSetObjectOrientation(cid, scanner, robot, (0.0, 0.0, 0.0), BLOCKING),
            v.simxSynchronous(cid, True),
            v.simxStartSimulation(cid, BLOCKING),
        ):
            assert code == v.simx_return_ok
        peer = server.peer()
        twist = BY_NAME["geometry_msgs/msg/Twist"]
        peer.listen(command := f"0/cmd_vel/{twist.dds_name}/{twist.hash}")
        peer.watch()
        # Of the two vision sensors of this model, the first one looks to the right.
        program = start_example(
            server.port, "follow_wall.py", "--scan", "/fastHokuyo_sensor1/scan",
            *("--yaw", -60, "--distance", 0.3, "--speed", 0.2, "--turn", 1.5, "--seconds", SECONDS),
        )  # fmt: skip
        for topic in ("%fastHokuyo_sensor1%scan/", "%odom/"):
            peer.wait_for_token(lambda token, topic=topic: "/MS/" in token and topic in token)
        for _ in range(round(SECONDS / 0.05) + 1):
            assert v.simxSynchronousTrigger(cid) == v.simx_return_ok
            peer.next(command)  # the program answers each scan
        driven, nearest = floats(output_of(program))
        place = server.on_server(lambda: get_pose(server.simulation, robot)[0])
    assert driven > 1.0
    assert nearest > 0.15
    assert place[1] > 0.3  # along a row of boxes, which lies across
