"""The add-on that drives an arm: velocities and poses of the tip, grippers, limits, the end of silence, replays."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import msgpack
import numpy as np
import pytest
from real_world import BLOCKING, RealWorld, handle_of, start_stepped
from recordings import recorded, replay

import simx_client as v
from simx_client.protocol.add_ons.teleoperation import ADD_ON, ADD_ON_TYPE, HELD, SPEED, Arms
from simx_client.protocol.cli.exit_codes import DONE
from simx_server.app.server import open_world
from simx_server.settings.gathering import gather
from simx_server.settings.rules import SettingError
from simx_server.settings.settings import Settings

BENT = tuple(math.radians(angle) for angle in (110.0, 15.0, 65.0, 10.0, -90.0, 20.0))
"""The gripper points down."""

STEPS_HELD = round(HELD / 0.05)

FINGERS = """
<mujoco>
  <compiler angle="radian"/>
  <worldbody>
    <body name="base">
      <geom name="foot" type="box" size="0.1 0.1 0.05"/>
      <body name="upper" pos="0 0 0.1">
        <joint name="shoulder" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0.3 0 0.3" size="0.03"/>
        <body name="lower" pos="0.3 0 0.3">
          <joint name="elbow" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0.3 0 -0.1" size="0.03"/>
          <site name="end" pos="0.3 0 -0.1"/>
          <body name="finger" pos="0.32 0 -0.1">
            <joint name="slide" type="slide" axis="0 1 0" range="0 0.04" limited="true"/>
            <geom type="box" size="0.02 0.01 0.02" mass="0.05"/>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
  <actuator>
    <position joint="shoulder" kp="2000" kv="200"/><position joint="elbow" kp="2000" kv="200"/>
    <position joint="slide" kp="500" kv="50"/>
  </actuator>
</mujoco>
"""


class Operator:
    """A client in stepped mode that drives an arm."""

    def __init__(self, client: int) -> None:
        self.client = client

    def call(
        self, function: str, floats: tuple[float, ...] = (), integers: tuple[int, ...] = (), arm: str = ""
    ) -> tuple[int, bytes]:
        code, *_, buffer = v.simxCallScriptFunction(
            self.client, ADD_ON, ADD_ON_TYPE, function, list(integers), list(floats), [arm] * bool(arm), b"", BLOCKING
        )  # fmt: skip
        return code, bytes(buffer)

    def arms(self, name: str = "") -> Arms:
        code, buffer = self.call("arms", arm=name)
        assert code == v.simx_return_ok
        return msgpack.unpackb(buffer)

    def problem(self, function: str, *arguments: Any, **others: Any) -> str:
        code, _ = self.call(function, *arguments, **others)
        assert code == v.simx_return_remote_error_flag
        return " ".join(v.simxGetLastErrors(self.client, BLOCKING)[1])

    def place(self, name: str) -> np.ndarray:
        return np.array(v.simxGetObjectPosition(self.client, handle_of(self.client, name), -1, BLOCKING)[1])

    def step(self, count: int = 1) -> None:
        for _ in range(count):
            assert v.simxSynchronousTrigger(self.client) == v.simx_return_ok

    def bend(self) -> None:
        for number, angle in enumerate(BENT, 1):
            joint = handle_of(self.client, f"UR5_joint{number}")
            v.simxSetJointPosition(self.client, joint, angle, BLOCKING)
            v.simxSetJointTargetPosition(self.client, joint, angle, BLOCKING)
        self.step(2)


@pytest.fixture
def open_scene() -> Iterator[Callable[[str | Path], Operator]]:
    worlds: list[RealWorld] = []

    def open_one(scene: str | Path) -> Operator:
        worlds.append(RealWorld(scene))
        return Operator(worlds[-1].client())

    yield open_one
    for world in worlds:
        world.close()


@pytest.fixture
def operator(open_scene: Callable[[str], Operator]) -> Operator:
    """That of the UR5 with the gripper RG2."""
    operator = open_scene("pick_place")
    start_stepped(operator.client)
    operator.bend()
    return operator


def test_the_tip_moves_at_the_wanted_velocity_and_keeps_its_orientation(operator: Operator) -> None:
    before = operator.arms()
    start = operator.place("UR5_tip")
    for _ in range(20):
        assert operator.call("drive", (0.1, 0.0, -0.05, 0.0, 0.0, 0.0))[0] == v.simx_return_ok
        operator.step()
    assert operator.arms()["is_driven"]
    assert np.array(operator.arms()["position"]) - before["position"] == pytest.approx(
        [0.1, 0.0, -0.05], abs=1e-6
    )
    assert operator.arms()["quaternion"] == pytest.approx(before["quaternion"], abs=1e-6)
    assert operator.place("UR5_tip") - start == pytest.approx([0.1, 0.0, -0.05], abs=0.01)


def test_the_arm_stops_when_the_operator_is_silent(operator: Operator) -> None:
    start = np.array(operator.arms()["position"])
    operator.call("drive", (0.0, 0.0, -0.1, 0.0, 0.0, 0.0))
    operator.step(3 * STEPS_HELD)
    assert not operator.arms()["is_driven"]
    assert np.array(operator.arms()["position"]) - start == pytest.approx([0.0, 0.0, -0.1 * HELD], abs=1e-3)
    stopped = operator.place("UR5_tip")
    operator.step(10)
    assert operator.place("UR5_tip") == pytest.approx(stopped, abs=1e-3)


def test_it_stops_at_once_when_it_is_released(operator: Operator) -> None:
    start = np.array(operator.arms()["position"])
    operator.call("drive", (0.0, 0.0, -0.1, 0.0, 0.0, 0.0))
    operator.step()
    operator.call("release")
    operator.step(5)
    assert np.array(operator.arms()["position"]) - start == pytest.approx([0.0, 0.0, -0.005], abs=1e-3)


def test_a_pose_is_reached_at_a_limited_velocity(operator: Operator) -> None:
    before = operator.arms()
    goal = np.add(before["position"], (0.05, -0.05, -0.1))
    for count in range(40):
        operator.call("reach", (*goal.tolist(), *before["quaternion"]))
        operator.step()
        if not count:
            way = np.array(operator.arms()["position"]) - before["position"]
            assert np.linalg.norm(way) == pytest.approx(0.05 * SPEED, rel=1e-6)
    assert operator.place("UR5_tip") == pytest.approx(goal, abs=1e-3)


def test_a_velocity_is_limited_and_a_target_out_of_reach_waits_for_the_arm(operator: Operator) -> None:
    for _ in range(100):
        operator.call("drive", (9.0, 0.0, 0.0, 0.0, 0.0, 0.0))
        operator.step()
    there = operator.arms()["position"]
    assert math.hypot(*there) < 1.5, "a UR5 reaches less than a metre"
    for _ in range(10):
        operator.call("drive", (-0.2, 0.0, 0.0, 0.0, 0.0, 0.0))
        operator.step()
    assert operator.arms()["position"][0] < there[0] - 0.05, "it comes back at once"


def test_the_gripper_of_a_script_obeys_its_signal(operator: Operator) -> None:
    finger = handle_of(operator.client, "RG2_openCloseJoint")
    assert operator.arms()["gripper"] == "RG2_open"
    velocities = []
    for is_open in (0, 1):
        assert operator.call("gripper", integers=(is_open,))[0] == v.simx_return_ok
        operator.step(2)
        assert operator.arms()["is_open"] == bool(is_open)
        parameter = v.sim_jointfloatparam_velocity
        velocities.append(v.simxGetObjectFloatParameter(operator.client, finger, parameter, BLOCKING)[1])
    assert velocities[0] < 0 < velocities[1]


def test_fingers_with_motors_are_a_gripper_and_a_short_arm_keeps_no_orientation(
    open_scene: Callable[[Path], Operator], tmp_path: Path
) -> None:
    (tmp_path / "fingers.xml").write_text(FINGERS, encoding="utf-8")
    operator = open_scene(tmp_path / "fingers.xml")
    start_stepped(operator.client)
    assert operator.arms()["tip"] == "end"
    assert operator.arms()["gripper"] == "slide"
    operator.call("gripper", integers=(1,))
    start = np.array(operator.arms()["position"])
    for _ in range(20):
        operator.call("drive", (0.0, 0.0, 0.05, 0.0, 0.0, 0.0))
        operator.step()
    assert np.array(operator.arms()["position"]) - start == pytest.approx([0.0, 0.0, 0.05], abs=1e-5)
    slide = handle_of(operator.client, "slide")
    assert v.simxGetJointPosition(operator.client, slide, BLOCKING)[1] == pytest.approx(0.04, abs=2e-3)


def test_an_arm_is_found_by_what_carries_it_and_others_are_refused(operator: Operator) -> None:
    assert operator.arms()["names"] == ["UR5_tip", "UR5_ikTip"]
    assert operator.arms("UR5")["tip"] == "UR5_tip"
    assert operator.arms("UR5_ikTip")["tip"] == "UR5_ikTip"
    still = (0.0,) * 6
    assert "the arms of this scene: UR5_tip" in operator.problem("drive", still, arm="Cube")
    assert "nobody" in operator.problem("drive", still, arm="nobody")
    assert "takes 0 integers and 6 floats" in operator.problem("drive", still[1:])


def test_a_scene_without_an_arm_says_so(open_scene: Callable[[str], Operator]) -> None:
    operator = open_scene("pioneer_p3dx")
    arms = operator.arms()
    assert (arms["names"], arms["tip"]) == ([], "")
    assert "mobile robots" in arms["problem"]


def test_a_client_that_may_only_read_drives_nothing(open_scene: Callable[[str], Operator]) -> None:
    world = RealWorld("ur5")
    try:
        operator = Operator(world.client())
        (session,) = world.loop.service.clients.sessions.values()
        session.may_only_read = True
        code, _ = operator.call("drive", (0.1, 0.0, 0.0, 0.0, 0.0, 0.0))
        assert code != v.simx_return_ok
        assert not world.parts.arm_drive.has_work
    finally:
        world.close()


def test_a_replay_drives_the_arm_bit_for_bit(tmp_path: Path) -> None:
    file = tmp_path / "run.simxlog"
    with recorded("pick_place", file) as place:
        operator = Operator(place.client())
        start_stepped(operator.client)
        operator.bend()
        for count in range(25):
            if count < 15:
                operator.call("drive", (0.05, 0.02 * count, -0.03, 0.0, 0.0, 0.3))
            operator.step()
        operator.call("gripper", integers=(0,))
        operator.step(5)
    assert replay(file) == DONE


def test_the_flag_opens_the_web_viewer(tmp_path: Path) -> None:
    settings = gather({"teleop": "first"}, {})
    assert (settings.view, settings.operated_arm) == ("127.0.0.1:8080", "")
    settings = gather({"teleop": "UR5", "view": "9000"}, {})
    assert (settings.view, settings.operated_arm) == ("127.0.0.1:9000", "UR5")
    assert gather({}, {}).operated_arm is None
    with pytest.raises(
        SettingError, match="flag --teleop: with --count all servers would want the same page"
    ):
        gather({"teleop": "first", "count": "2"}, {})


def test_nothing_is_done_in_a_step_while_no_arm_is_driven() -> None:
    from contextlib import ExitStack

    with ExitStack() as stack:
        world = open_world(Settings(scene="ur5"), stack)
        world.simulation.start()
        assert "teleoperation" not in {world.STEP[number][0] for number, _ in world.find_stages()}
        world.arm_drive.drive("", (0.1, 0.0, 0.0, 0.0, 0.0, 0.0))
        assert "teleoperation" in {world.STEP[number][0] for number, _ in world.find_stages()}
