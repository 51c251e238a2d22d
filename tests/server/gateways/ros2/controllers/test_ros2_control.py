"""ros2_control moves the shipped UR5 by two topics, with the state machine of its hardware interface."""

from __future__ import annotations

import logging
import math
from collections.abc import Iterator

import pytest
from processes import ROOT
from real_world import BLOCKING
from ros2_world import Ros2World, ros2_world
from topic_based_system import TopicBasedSystem

import simx_client as v

pytestmark = pytest.mark.slow

NAMES = [
    "shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint", "wrist_1_joint", "wrist_2_joint", "wrist_3_joint",
]  # fmt: skip
STEP = 0.05


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Ros2World]:
    with ros2_world(tmp_path_factory.mktemp("control"), scene=ROOT / "scenes" / "ur5.xml") as opened:
        yield opened


class Loop:
    """The loop of a controller manager: read, update, write; one turn for each simulation step."""

    def __init__(self, server: Ros2World, system: TopicBasedSystem) -> None:
        self._server, self.system = server, system
        self._cid = server.client()
        self._steps = 0
        assert v.simxSynchronous(self._cid, True) == v.simx_return_ok
        assert v.simxStartSimulation(self._cid, BLOCKING) == v.simx_return_ok
        peer = server.peer()
        peer.watch()
        peer.wait_for_token(lambda token: "%robot_joint_commands/" in token)
        self.read()
        self.system.commands["position"] = [*self.system.states["position"]]  # as controllers start

    def read(self) -> None:
        assert v.simxSynchronousTrigger(self._cid) == v.simx_return_ok
        self._steps += 1
        self.system.read(self._steps * STEP)

    def arrived(self, values: list[float], interface: str = "position") -> None:
        """Wait until the server has the commands."""
        joints, scene = self._server.simulation.joints, self._server.simulation.scene
        handles = [scene.resolve(f"UR5_joint{number}") for number in range(1, 7)]
        offsets = [
            math.pi / 2,
            math.pi / 2,
            0.0,
            math.pi / 2,
            0.0,
            0.0,
        ]  # of the URDF's zero, which the scene notes
        if interface == "velocity":
            self._server.wait_until(
                lambda: all(
                    joints.target_velocity(handle) == value
                    for handle, value in zip(handles, values, strict=True)
                )
            )
        else:
            self._server.wait_until(
                lambda: all(
                    abs(joints.target_position(handle) - value - offset) < 1e-6
                    for handle, value, offset in zip(handles, values, offsets, strict=True)
                )
            )


def loop(server: Ros2World) -> Loop:
    return Loop(server, TopicBasedSystem(server.peer(), dict.fromkeys(NAMES, ("position",))))


def test_a_position_controller_moves_the_arm_step_by_step(server: Ros2World) -> None:
    controlled = loop(server)
    system = controlled.system
    began = [*system.states["position"]]
    goal = [-1.2, -1.4, 0.3, -1.5, 0.2, 0.1]
    for turn in range(1, 31):
        system.commands["position"] = [a + (b - a) * turn / 30 for a, b in zip(began, goal, strict=True)]
        assert system.write()
        controlled.arrived(system.commands["position"])
        controlled.read()
    for _ in range(10):
        controlled.read()
    assert system.states["position"] == pytest.approx(goal, abs=0.02)
    assert system.states["velocity"] == pytest.approx([0.0] * 6, abs=0.05)
    assert any(abs(each) > 1.0 for each in system.states["effort"])  # gravity


def test_commands_that_are_the_state_are_not_sent_and_the_arm_stays(server: Ros2World) -> None:
    controlled = loop(server)
    system = controlled.system
    before = [*system.states["position"]]
    assert not system.write()
    system.commands["position"][5] += 0.4
    assert system.write()
    controlled.arrived(system.commands["position"])
    for _ in range(20):
        controlled.read()
    assert system.states["position"] == pytest.approx([*before[:5], before[5] + 0.4], abs=0.02)


def test_a_velocity_interface_needs_a_threshold_below_zero(server: Ros2World) -> None:
    system = TopicBasedSystem(server.peer(), dict.fromkeys(NAMES, ("velocity",)), threshold=-1.0)
    controlled = Loop(server, system)
    system.commands["velocity"] = velocities = [0.0, 0.0, 0.0, 0.0, 0.0, 0.3]
    assert system.write()
    controlled.arrived(velocities, "velocity")
    system.threshold = 1e-5  # the default: the positions are those commanded, so it does not send
    assert not system.write()


def test_joints_with_different_interfaces_are_refused_and_the_arm_stays(
    server: Ros2World, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.INFO)
    joints = {NAMES[0]: ("position",), NAMES[1]: ("velocity",), NAMES[2]: ("position",)}
    system = TopicBasedSystem(server.peer(), joints)
    controlled = Loop(server, system)
    before = [*system.states["position"]]
    system.commands["position"] = [1.0, 0.0, 1.0]
    assert system.write()
    server.wait_until(lambda: "position has 2 numbers for 3 names" in caplog.text)
    for _ in range(3):
        controlled.read()
    assert system.states["position"] == pytest.approx(before, abs=0.02)
