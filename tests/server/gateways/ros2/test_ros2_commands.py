"""JointState messages move joints; bad ones change nothing, say why in the log, and the server goes on."""

from __future__ import annotations

import logging
import math
import struct
import threading
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from ros2_world import JOINT_STATE, SCENE, Ros2World, attachment, ros2_world

from simx_server.gateways.ros2.desk import Intake
from simx_server.ros2_messages import BY_NAME

KEY = f"0/joint_command/{JOINT_STATE}"
TYPE = BY_NAME["sensor_msgs/msg/JointState"]


def targets(server: Ros2World) -> list[float]:
    joints, scene = server.simulation.joints, server.simulation.scene
    return server.on_server(
        lambda: [joints.target_position(scene.resolve(name)) for name in ("shoulder", "elbow")]
    )


def wait_for_target(server: Ros2World, name: str, wanted: float) -> None:
    joints, handle = server.simulation.joints, server.simulation.scene.resolve(name)
    server.wait_until(lambda: joints.target_position(handle) == wanted)


def test_positions_become_targets_with_all_their_digits(server: Ros2World) -> None:
    peer = server.peer()
    peer.command(["elbow", "shoulder"], position=[0.1, -0.3])
    wait_for_target(server, "shoulder", -0.3)
    assert targets(server) == [-0.3, 0.1]


def test_joints_move_to_commanded_positions(server: Ros2World) -> None:
    peer = server.peer()
    server.on_server(server.simulation.start)
    peer.command(["shoulder", "elbow"], position=[0.5, -0.5])
    joints, scene = server.simulation.joints, server.simulation.scene
    for name, goal in (("shoulder", 0.5), ("elbow", -0.5)):
        handle = scene.resolve(name)
        server.wait_until(lambda handle=handle, goal=goal: abs(joints.position(handle) - goal) < 0.05)


def test_nan_leaves_a_joint_alone(server: Ros2World) -> None:
    peer = server.peer()
    peer.command(["shoulder", "elbow"], position=[0.2, 0.3])
    wait_for_target(server, "elbow", 0.3)
    peer.command(["shoulder", "elbow"], position=[math.nan, 0.4])
    wait_for_target(server, "elbow", 0.4)
    assert targets(server)[0] == 0.2


def test_the_first_array_with_a_number_moves_each_joint(server: Ros2World) -> None:
    joints, scene = server.simulation.joints, server.simulation.scene
    wheel = scene.resolve("wheel")
    server.peer().command(["shoulder", "wheel"], position=[0.6, math.nan], velocity=[9.0, 2.5])
    server.wait_until(lambda: joints.target_velocity(wheel) == 2.5)
    assert targets(server)[0] == 0.6
    assert server.on_server(lambda: joints.target_velocity(scene.resolve("shoulder"))) == 0.0


def test_an_effort_pushes_with_that_force_in_its_direction(server: Ros2World) -> None:
    joints, wheel = server.simulation.joints, server.simulation.scene.resolve("wheel")
    peer = server.peer()
    peer.trigger("start")
    server.wait_until(lambda: server.simulation.step_count > 100)  # the arm is at rest
    peer.trigger("pause")
    peer.command(["wheel"], effort=[-1e-4])
    server.wait_until(lambda: joints.max_force(wheel) == 1e-4)
    for _ in range(4):
        peer.trigger("step")
    velocity, force = server.on_server(lambda: (joints.velocity(wheel), joints.force(wheel)))
    assert velocity < -0.2
    assert force == pytest.approx(1e-4, rel=0.01)


def test_a_joint_without_motor_is_put_there_at_once(tmp_path: Path) -> None:
    scene = SCENE.replace(
        "</mujoco>", '<custom><text name="simx:joint:elbow" data="mode=passive"/></custom></mujoco>'
    )
    with ros2_world(tmp_path, scene=scene) as server:
        server.peer().command(["elbow"], position=[0.7])
        joints, elbow = server.simulation.joints, server.simulation.scene.resolve("elbow")
        server.wait_until(lambda: joints.position(elbow) == pytest.approx(0.7))


def test_messages_of_humble_are_taken_too(server: Ros2World) -> None:
    key = "0/joint_command/sensor_msgs::msg::dds_::JointState_/TypeHashNotSupported"
    server.peer().command(["shoulder"], key, position=[-0.9])
    wait_for_target(server, "shoulder", -0.9)


def hostile(**fields: object) -> bytes:
    return TYPE.encode(fields)


GOOD = hostile(name=["shoulder"], position=[0.5])

CASES: dict[str, tuple[bytes | Callable[[], bytes], str]] = {
    "nothing": (b"", "JointState"),
    "half a header": (b"\0\1", "JointState"),
    "big endian": (b"\0\0" + GOOD[2:], "JointState"),
    "cut in the middle": (GOOD[:-5], "JointState"),
    "a count beyond the bytes": (GOOD[:16] + struct.pack("<I", 0xFFFF_FFFF) + GOOD[20:], "JointState"),
    "more bytes than fields": (GOOD + bytes(100), "JointState"),
    "an unknown joint": (hostile(name=["shoulders"], position=[1.0]), "did you mean 'shoulder'"),
    "fewer numbers than names": (
        hostile(name=["shoulder", "elbow"], position=[1.0]),
        "position has 1 numbers for 2 names",
    ),
    "more numbers than names": (
        hostile(name=["shoulder"], velocity=[1.0, 2.0]),
        "velocity has 2 numbers for 1 names",
    ),
    "no names": (hostile(), "names no joints"),
    "a joint twice": (
        lambda: hostile(name=["shoulder"] * 20_000, position=[0.1] * 20_000),  # takes a while, as below
        "'shoulder' is named twice",
    ),
    "a name that is several lines": (hostile(name=["a\nb\x1b[2J"], position=[1.0]), "no joint 'a b [2J'"),
    "infinity": (hostile(name=["shoulder"], position=[math.inf]), "is inf; valid: numbers up to 1e+09"),
    "a number beyond all sense": (hostile(name=["shoulder"], position=[1e300]), "is 1e+300; valid"),
    "a name that is not text": (GOOD.replace(b"shoulder", b"should\xff\xff"), "UTF-8"),
    "a long name": (hostile(name=["x" * 100_000], position=[1.0]), "there is no joint"),
    "very many names": (lambda: hostile(name=["shoulder"] * 60_000, position=[1.0]), "60000 names"),
}


@pytest.mark.parametrize("case", CASES)
def test_a_bad_message_changes_nothing_and_the_log_says_why(
    server: Ros2World, case: str, caplog: pytest.LogCaptureFixture
) -> None:
    payload, reason = CASES[case]
    caplog.set_level(logging.INFO)
    before = targets(server)
    server.on_server(server.gateway._client.session._logged.clear)
    peer = server.peer()
    peer.put(KEY, payload() if callable(payload) else payload)
    server.wait_until(lambda: any("joint_command" in record.message for record in caplog.records))
    text = "\n".join(record.message for record in caplog.records)
    assert reason in text
    assert len(text) < 5000
    assert "Traceback" not in caplog.text
    assert all(record.message.isprintable() for record in caplog.records)
    assert targets(server) == before
    peer.command(["shoulder"], position=[0.25])
    wait_for_target(server, "shoulder", 0.25)


def test_a_message_with_another_hash_is_thrown_away_with_a_warning(
    server: Ros2World, caplog: pytest.LogCaptureFixture
) -> None:
    peer, before = server.peer(), targets(server)
    key = f"0/joint_command/sensor_msgs::msg::dds_::JointState_/RIHS01_{'0' * 64}"
    peer.put(key, hostile(name=["shoulder"], position=[0.123]))
    server.wait_until(lambda: "knows another sensor_msgs/msg/JointState" in caplog.text)
    assert targets(server) == before
    peer.put(f"{key}\x1b[2J", GOOD)
    server.wait_until(lambda: "0 [2J);" in caplog.text)
    assert targets(server) == before


def test_a_message_beyond_the_limit_is_not_read(server: Ros2World, caplog: pytest.LogCaptureFixture) -> None:
    server.peer().put(KEY, bytes(3 << 20))
    server.wait_until(lambda: "at most 1048576 are read" in caplog.text)


def test_waiting_messages_meet_the_limit_of_a_client(
    server: Ros2World, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(server.gateway._guard, "_most_waiting", lambda: 100_000)
    peer, may_go_on = server.peer(), threading.Event()
    server.loop.service.queue.post(may_go_on.wait)
    for _ in range(5):
        peer.put(KEY, hostile(name=["x" * 60_000], position=[1.0]))
    end = time.monotonic() + 30
    while "too much waits to be executed" not in caplog.text:
        assert time.monotonic() < end
    may_go_on.set()
    peer.command(["shoulder"], position=[0.31])
    wait_for_target(server, "shoulder", 0.31)
    assert server.gateway._guard._waiting == 0


def test_each_message_has_a_turn(server: Ros2World, monkeypatch: pytest.MonkeyPatch) -> None:
    known = server.gateway._offered._known.values()
    intake = next(each for each in known if isinstance(each, Intake) and each.offer.topic == "/joint_command")
    waiting, serve, taken = intake.subscription._waiting, intake.serve, list[int]()

    def counted() -> None:
        before = len(waiting)
        serve()
        taken.append(before - len(waiting))

    monkeypatch.setattr(intake, "serve", counted)
    peer, may_go_on = server.peer(), threading.Event()
    server.loop.service.queue.post(may_go_on.wait)
    for position in (0.1, 0.2, 0.3):
        peer.command(["shoulder"], position=[position])
    end = time.monotonic() + 30
    while len(waiting) < 3:
        assert time.monotonic() < end
    may_go_on.set()
    wait_for_target(server, "shoulder", 0.3)
    assert taken == [1, 1, 1]


def test_a_request_behind_a_message_in_slices_is_answered_for_itself(
    server: Ros2World, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("simx_server.service.calls.batches.SLICE", 0.0)
    peer, may_go_on = server.peer(), threading.Event()
    server.loop.service.queue.post(may_go_on.wait)
    peer.command(["elbow", "wheel", "shoulder"], position=[0.1] * 3)
    for _ in range(10):
        server.loop.service.queue.post(lambda: None)  # others for whom a batch is cut
    answers: list[bool] = []
    asking = threading.Thread(target=lambda: answers.append(peer.trigger("start")["success"]))
    asking.start()
    may_go_on.set()
    asking.join(30)
    assert answers == [True]
    wait_for_target(server, "shoulder", 0.1)


def test_of_a_flood_the_newest_messages_are_executed_and_others_are_served(server: Ros2World) -> None:
    peer, other = server.peer(), server.peer()
    for number in range(1000):  # ten times as many as are kept
        peer.put(KEY, hostile(name=["shoulder"], position=[number * 1e-3]), attachment(number + 1))
    assert other.trigger("start")["success"]
    wait_for_target(server, "shoulder", 999 * 1e-3)


def test_commands_count_as_calls_of_one_client(server: Ros2World) -> None:
    session, executed = server.gateway._client.session, server.gateway._client.session.called
    before = executed["simxSetJointTargetPosition"]
    server.peer().command(["shoulder", "elbow"], position=[0.11, 0.12])
    wait_for_target(server, "elbow", 0.12)
    assert session.name == "ros2 /simx"
    assert executed["simxSetJointTargetPosition"] == before + 2
