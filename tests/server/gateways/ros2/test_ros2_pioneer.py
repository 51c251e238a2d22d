"""The Pioneer, driven by another implementation of ROS 2, measures what an old script reads at the same step."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from processes import ROOT
from real_world import BLOCKING, handle_of
from ros2_contents import in_frame, matrix
from ros2_world import Ros2World, ros2_world
from sdk_peer import SdkPeer, sdk_peer

import simx_client as v

pytestmark = pytest.mark.slow

TWIST = "geometry_msgs/msg/Twist"


@pytest.fixture
def pioneer(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[Ros2World]:
    monkeypatch.setenv("MUJOCO_GL", "disable")
    with ros2_world(tmp_path, scene=ROOT / "scenes" / "pioneer_p3dx.xml") as world:
        yield world


@pytest.fixture
def sdk(pioneer: Ros2World) -> Iterator[SdkPeer]:
    with sdk_peer(pioneer.port) as peer:
        yield peer


def twist(x: float, turn: float) -> dict[str, dict[str, float]]:
    return {"linear": {"x": x, "y": 0.0, "z": 0.0}, "angular": {"x": 0.0, "y": 0.0, "z": turn}}


def pose_of(cid: int, name: str) -> np.ndarray:
    handle = handle_of(cid, name)
    place = v.simxGetObjectPosition(cid, handle, -1, BLOCKING)[1]
    return matrix(place, v.simxGetObjectQuaternion(cid, handle, -1, BLOCKING)[1])


def nanoseconds(message: Any) -> int:
    stamp = message["header"]["stamp"]
    return stamp["sec"] * 1_000_000_000 + stamp["nanosec"]


def wanted_scan(cid: int) -> list[float]:
    """The scan by the remote API: per value the nearest point, +Inf without echo, NaN where no sensor looks."""
    base = np.linalg.inv(pose_of(cid, "Pioneer_p3dx"))
    found = [math.nan] * 35
    for number in range(1, 17):
        name = f"Pioneer_p3dx_ultrasonicSensor{number}"
        _, echo, point, _, _ = v.simxReadProximitySensor(cid, handle_of(cid, name), BLOCKING)
        sensor = base @ pose_of(cid, name)
        x, y, _, _ = sensor @ ([*point, 1.0] if echo else [0, 0, 1, 0])
        place = round((math.degrees(math.atan2(y, x)) + 170) / 10)
        distance = math.hypot(x, y) if echo else math.inf
        found[place] = distance if math.isnan(found[place]) else min(found[place], distance)
    return found


def test_pioneer_driven_by_the_sdk_measures_what_the_remote_api_reads(
    pioneer: Ros2World, sdk: SdkPeer
) -> None:
    cid = pioneer.client()
    for topic, kind, qos in (
        ("/scan", "sensor_msgs/msg/LaserScan", None),
        ("/odom", "nav_msgs/msg/Odometry", None),
        ("/tf", "tf2_msgs/msg/TFMessage", None),
        ("/tf_static", "tf2_msgs/msg/TFMessage", ":1:,1:,:,:,,"),
    ):
        sdk.do("subscribe", topic, kind, qos)
    fixed = sdk.next("/tf_static")
    assert v.simxSynchronous(cid, True) == v.simx_return_ok
    start = pose_of(cid, "Pioneer_p3dx")
    assert v.simxStartSimulation(cid, BLOCKING) == v.simx_return_ok
    joints = pioneer.simulation.joints
    motors = [handle_of(cid, f"Pioneer_p3dx_{side}Motor") for side in ("left", "right")]

    def has_targets(targets: list[float]) -> bool:
        return np.allclose([*map(joints.target_velocity, motors)], targets)

    for command in (twist(0.4, 0.0), twist(0.2, -0.8)):
        sdk.do("publish", "/cmd_vel", TWIST, command)
        speed, turn = command["linear"]["x"], command["angular"]["z"]
        targets = [(speed - turn * 0.1655) / 0.0975, (speed + turn * 0.1655) / 0.0975]
        pioneer.wait_until(partial(has_targets, targets))
        for _ in range(6):
            assert v.simxSynchronousTrigger(cid) == v.simx_return_ok
        now = pioneer.on_server(lambda: pioneer.simulation.step_count) * 50_000_000

        def is_of_now(message: Any, now: int = now) -> bool:
            return nanoseconds(message) == now

        odometry, scan = sdk.next("/odom", is_of_now), sdk.next("/scan", is_of_now)
        moving = sdk.next("/tf", lambda message: is_of_now(message["transforms"][0]))

        base = np.linalg.inv(start) @ pose_of(cid, "Pioneer_p3dx")
        place, turn_ = odometry["pose"]["pose"]["position"], odometry["pose"]["pose"]["orientation"]
        assert np.allclose(matrix([*place.values()], [*turn_.values()]), base, atol=1e-6)
        assert np.allclose(scan["ranges"], wanted_scan(cid), atol=1e-5, equal_nan=True)
        assert any(math.isfinite(each) for each in scan["ranges"])
        frames: dict[str, tuple[str, np.ndarray]] = {}
        for each in (*fixed["transforms"], *moving["transforms"]):
            moved, turned = each["transform"]["translation"], each["transform"]["rotation"]
            pose = matrix([*moved.values()], [*turned.values()])
            frames[each["child_frame_id"]] = each["header"]["frame_id"], pose
        assert np.allclose(in_frame(frames, "base_link", "odom"), base, atol=1e-6)
        wheel = np.linalg.inv(start) @ pose_of(cid, "Pioneer_p3dx_leftWheel")
        assert np.allclose(in_frame(frames, "Pioneer_p3dx_leftWheel", "odom"), wheel, atol=1e-6)
    assert base[0, 3] > 0.1
