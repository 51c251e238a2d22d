"""FollowJointTrajectory and GripperCommand of the shipped UR5 with its RG2, and of other robots."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from action_client import ABORTED, CANCELED, SUCCEEDED, ActionClient
from processes import ROOT
from ros2_world import Ros2World, ros2_world

from simx_server.gateways.ros2.controllers.finding import find_arms
from simx_server.gateways.ros2.wire.names import Distribution
from simx_server.ros2_messages import BUILT_IN, BY_NAME
from simx_server.simulation.simulation import Simulation

pytestmark = pytest.mark.slow

NAMES = [
    "shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint", "wrist_1_joint", "wrist_2_joint", "wrist_3_joint",
]  # fmt: skip
NUMBERS = itertools.count(100)
"""Ids of goals, each of which is used once."""

GOAL = [-1.2, -1.4, 0.3, -1.5, 0.2, 0.1]


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Ros2World]:
    with ros2_world(tmp_path_factory.mktemp("arms"), scene=ROOT / "scenes" / "ur5_rg2_kinect.xml") as opened:
        yield opened


@pytest.fixture
def arm(server: Ros2World) -> ActionClient:
    kind = "control_msgs/action/FollowJointTrajectory"
    return ActionClient(server.peer(), "UR5_controller/follow_joint_trajectory", kind)


@pytest.fixture
def gripper(server: Ros2World) -> ActionClient:
    return ActionClient(
        server.peer(), "RG2_gripper_controller/gripper_cmd", "control_msgs/action/GripperCommand"
    )


def point(seconds: float, positions: list[float]) -> dict[str, Any]:
    return {
        "positions": positions,
        "time_from_start": {"sec": int(seconds), "nanosec": round(seconds % 1 * 1e9)},
    }


def trajectory(*points: dict[str, Any], names: list[str] | None = None, **header: Any) -> dict[str, Any]:
    return {"header": header, "joint_names": NAMES if names is None else names, "points": list(points)}


def positions(server: Ros2World) -> dict[str, float]:
    joints, scene = server.simulation.joints, server.simulation.scene
    return {name: joints.position(scene.resolve(name)) for name in (f"UR5_joint{n}" for n in range(1, 7))}


def test_an_arm_follows_a_trajectory_with_the_names_of_its_urdf(server: Ros2World, arm: ActionClient) -> None:
    arm.peer.trigger("start")
    half = [each / 2 for each in GOAL]
    assert arm.send(1, trajectory=trajectory(point(1, half), point(2, GOAL)))
    answer = arm.result(1)
    assert (answer["status"], answer["result"]["error_code"]) == (SUCCEEDED, 0)
    found = positions(server)
    assert found["UR5_joint3"] == pytest.approx(0.3, abs=0.05)
    assert found["UR5_joint1"] == pytest.approx(-1.2 + 1.5708, abs=0.05)
    seen = [arm.next_feedback() for _ in range(30)]
    assert seen[0]["joint_names"] == NAMES
    assert {each["index"] for each in seen} == {0}
    late = seen[25]
    desired, actual = late["desired"]["positions"], late["actual"]["positions"]
    assert actual == pytest.approx(desired, abs=0.2)
    assert late["error"]["positions"] == pytest.approx(desired - actual)
    arm.next_status(1, SUCCEEDED)


def test_earlier_releases_get_feedback_of_their_own_type(server: Ros2World, arm: ActionClient) -> None:
    kind = BUILT_IN.older.messages["control_msgs/action/FollowJointTrajectory_FeedbackMessage"]
    key = f"0/UR5_controller/follow_joint_trajectory/_action/feedback/{kind.dds_name}/{kind.hash}"
    arm.peer.listen(key)
    arm.peer.trigger("start")
    assert arm.send(2, trajectory=trajectory(point(3, GOAL)))
    feedback = kind.decode(arm.peer.next(key).payload)["feedback"]
    assert "index" not in feedback
    assert list(feedback["joint_names"]) == NAMES
    arm.cancel(2)


def test_a_canceled_arm_stays_where_it_is(server: Ros2World, arm: ActionClient) -> None:
    arm.peer.trigger("start")
    assert arm.send(3, trajectory=trajectory(point(1000, GOAL)))
    arm.next_feedback()
    assert arm.cancel(3)["return_code"] == 0
    assert arm.result(3)["status"] == CANCELED
    before, count = positions(server), server.simulation.step_count
    server.wait_until(lambda: server.simulation.step_count > count + 40)
    assert positions(server) == pytest.approx(before, abs=0.03)


def test_no_target_of_a_trajectory_is_set_after_the_stop(server: Ros2World, arm: ActionClient) -> None:
    joints, handle = server.simulation.joints, server.simulation.scene.resolve("UR5_joint1")
    arm.peer.trigger("start")
    assert arm.send(6, trajectory=trajectory(point(1000, GOAL)))
    arm.next_feedback()

    def stop_at_the_end_of_a_step() -> None:
        server.gateway.step_finished()
        server.simulation.stop()

    server.on_server(stop_at_the_end_of_a_step)
    assert arm.result(6)["status"] == ABORTED
    assert server.on_server(lambda: joints.target_position(handle)) == 0


def test_a_new_trajectory_replaces_the_one_before(server: Ros2World, arm: ActionClient) -> None:
    arm.peer.trigger("start")
    assert arm.send(4, trajectory=trajectory(point(1000, GOAL)))
    assert arm.send(5, trajectory=trajectory(point(0.5, GOAL[:2]), names=NAMES[:2]))
    assert arm.result(4)["status"] == CANCELED
    assert arm.result(5)["status"] == SUCCEEDED


def tolerance(field: str, **values: float) -> dict[str, Any]:
    return {field: [{"name": NAMES[0], **values}]}


FINE = tolerance("path_tolerance", position=1e-3)


@pytest.mark.parametrize(
    ("code", "goal"),
    [
        (-1, {"trajectory": trajectory()}),
        (-1, {"trajectory": trajectory(point(1, GOAL[:5]))}),
        (-1, {"trajectory": trajectory(point(1, GOAL), stamp={"sec": 1_800_000_000})}),
        (-1, {"trajectory": trajectory(point(1, GOAL)), **tolerance("goal_tolerance", position=-3.0)}),
        (-1, {"trajectory": trajectory(point(1, GOAL)), "multi_dof_trajectory": {"points": [{}]}}),
        (-1, {"trajectory": trajectory(point(1, GOAL)), "path_tolerance": [{"name": NAMES[0]}] * 7}),
        (-2, {"trajectory": trajectory(point(1, GOAL), names=[*NAMES[:5], "wrist_4_joint"])}),
        (-2, {"trajectory": trajectory(point(1, GOAL), names=[NAMES[0]] * 6)}),
        (-2, {"trajectory": trajectory(point(1, []), names=[])}),
        (-2, {"trajectory": trajectory(point(1, [0.1]), names=NAMES[1:2]), **tolerance("path_tolerance")}),
        (-3, {"trajectory": trajectory(point(0.1, GOAL), stamp={"sec": 0, "nanosec": 1})}),
        (-4, {"trajectory": trajectory(point(0.05, [1.0] * 6), point(9, GOAL)), **FINE}),
        (
            -5,
            {
                "trajectory": trajectory(point(0.1, GOAL)),
                "goal_time_tolerance": {"nanosec": 1},
                **tolerance("goal_tolerance", position=1e-9),
            },
        ),
    ],
)  # fmt: skip
def test_each_reason_against_a_trajectory_has_its_code(
    server: Ros2World, arm: ActionClient, code: int, goal: dict[str, Any]
) -> None:
    arm.peer.trigger("start")
    server.wait_until(lambda: server.simulation.step_count > 10)
    number = next(NUMBERS)
    assert arm.send(number, **goal)
    answer = arm.result(number)
    assert (answer["status"], answer["result"]["error_code"]) == (ABORTED, code), answer
    assert answer["result"]["error_string"]
    arm.cancel(0)


def test_a_stop_aborts_what_moves_and_nothing_starts_then(
    server: Ros2World, arm: ActionClient, gripper: ActionClient
) -> None:
    arm.peer.trigger("start")
    assert arm.send(7, trajectory=trajectory(point(1000, GOAL)))
    assert gripper.send(7, command={"position": 5.0})
    arm.peer.trigger("stop")
    assert arm.result(7)["status"] == ABORTED
    assert gripper.result(7)["status"] == ABORTED
    assert arm.send(8, trajectory=trajectory(point(1, GOAL)))
    assert "start it first" in arm.result(8)["result"]["error_string"]
    assert not gripper.send(8, command={"position": 0.0})


def test_an_arm_that_is_deleted_ends_its_goals(
    server: Ros2World, arm: ActionClient, gripper: ActionClient
) -> None:
    arm.peer.trigger("start")
    assert arm.send(9, trajectory=trajectory(point(1000, GOAL)))
    assert gripper.send(9, command={"position": 5.0})
    assert arm.peer.call_standard("DeleteEntity", "delete_entity", entity="UR5")["result"]["result"] == 1
    arm.next_status(9, ABORTED)
    gripper.next_status(9, ABORTED)


def test_humble_gets_each_feedback_once(tmp_path: Path) -> None:
    scene = ROOT / "scenes" / "ur5_rg2_kinect.xml"
    with ros2_world(tmp_path, scene=scene, distribution=Distribution.HUMBLE) as server:
        peer = server.peer()
        peer.watch()
        kind = BY_NAME["control_msgs/action/FollowJointTrajectory_FeedbackMessage"].dds_name
        peer.wait_for_token(lambda token: kind in token)
        key = f"0/UR5_controller/follow_joint_trajectory/_action/feedback/{kind}/TypeHashNotSupported"
        outlets = server.on_server(lambda: [each.publisher.key for each in server.gateway._offered.outlets])  # pyright: ignore[reportPrivateUsage]
        assert outlets.count(key) == 1


def test_a_gripper_closes_to_a_position_and_tells_when_it_is_stopped(
    server: Ros2World, gripper: ActionClient
) -> None:
    gripper.peer.trigger("start")
    joint = server.simulation.scene.resolve("RG2_openCloseJoint")
    server.wait_until(lambda: server.simulation.step_count > 40)
    middle = server.on_server(lambda: server.simulation.joints.position(joint)) - 0.02
    assert gripper.send(1, command={"position": middle, "max_effort": 15.0})
    answer = gripper.result(1)
    assert answer["status"] == SUCCEEDED
    assert answer["result"]["reached_goal"]
    assert not answer["result"]["stalled"]
    assert answer["result"]["position"] == pytest.approx(middle, abs=0.005)
    assert server.simulation.joints.max_force(joint) == 15.0
    assert gripper.send(2, command={"position": -5.0})
    answer = gripper.result(2)
    assert answer["result"]["stalled"]
    assert not answer["result"]["reached_goal"]
    assert not gripper.next_feedback()["reached_goal"]
    assert not gripper.send(3, command={"position": float("nan")})
    assert not gripper.send(4, command={"position": 0.0, "max_effort": -1.0})


@pytest.mark.parametrize(
    ("scene", "expected"),
    [
        ("youbot", [("youBot", 5, 1)]),
        ("jaco", [("Jaco", 6, 4)]),
        ("nao", [("NAO", 6, 0), ("NAO", 6, 0), ("NAO", 5, 0), ("NAO", 5, 0)]),
        ("pioneer_p3dx", []),
        ("models/simple_ackermann_steering", []),
        ("quadricopter", []),
    ],
)
def test_arms_and_grippers_are_found_in_shipped_robots(scene: str, expected: list[Any]) -> None:
    simulation = Simulation()
    simulation.load(ROOT / "scenes" / f"{scene}.xml")
    found = find_arms(simulation.scene, simulation.joints)
    assert [(arm.robot.name, len(arm.joints), len(arm.gripper)) for arm in found] == expected
