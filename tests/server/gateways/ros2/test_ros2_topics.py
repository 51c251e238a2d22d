"""Topics without any annotation: time, joints and transforms, for those who listen, with one stamp for each step."""

from __future__ import annotations

import itertools
import logging
import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from real_world import start_stepped
from ros2_world import CLOCK, JOINT_STATE, TF, Ros2World, Sent, ros2_world, seconds

import simx_client as v
from simx_server.gateways.ros2.content.clock import Clock
from simx_server.gateways.ros2.endpoints import Offer, Published
from simx_server.gateways.ros2.wire.names import Distribution, Place
from simx_server.scene.poses import frames
from simx_server.simulation.simulation import SimulationState

JOINTS, TIME, MOVING, FIXED = (
    f"0/joint_states/{JOINT_STATE}",
    f"0/clock/{CLOCK}",
    f"0/tf/{TF}",
    f"0/tf_static/{TF}",
)


def by_child(sent: Sent) -> dict[str, Mapping[str, Any]]:
    return {each["child_frame_id"]: each for each in sent.value["transforms"]}


def stamps_of(transforms: Sent) -> set[float]:
    return {seconds(each["header"]["stamp"]) for each in transforms.value["transforms"]}


def matrix(each: Mapping[str, Any]) -> np.ndarray:
    """4 x 4 of a transform."""
    move, turn = each["transform"]["translation"], each["transform"]["rotation"]
    x, y, z, w = (turn[name] for name in "xyzw")
    made = np.eye(4)
    made[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    made[:3, 3] = [move[name] for name in "xyz"]
    return made


def in_world(transforms: Mapping[str, Mapping[str, Any]], frame: str) -> np.ndarray:
    """Pose of a frame, by its parents up to the world."""
    pose = np.eye(4)
    while frame != "world":
        pose = matrix(transforms[frame]) @ pose
        frame = transforms[frame]["header"]["frame_id"]
    return pose


def pause_after_steps(server: Ros2World) -> None:
    """Start, make some steps, and pause."""
    server.on_server(server.simulation.start)
    server.wait_until(lambda: server.simulation.step_count > 20)
    server.on_server(server.simulation.pause)


def test_the_graph_shows_node_topics_and_services(server: Ros2World) -> None:
    peer = server.peer()
    peer.watch()
    peer.wait_for_token(lambda token: "/step_simulation" in token.replace("%", "/"))
    for kind, name in [
        ("NN", ""),
        ("MP", "clock"),
        ("MP", "joint_states"),
        ("MP", "tf"),
        ("MP", "tf_static"),
        ("MP", "eye%image_raw"),
        ("MP", "eye%camera_info"),
        ("MS", "joint_command"),
        *(("SS", f"simx%{verb}") for verb in ("start", "stop", "pause", "reset", "step")),
        *(("SS", f"{verb}_simulation_state") for verb in ("get", "set")),
        *(("SS", f"{verb}_simulation") for verb in ("reset", "step")),
    ]:
        start = "/%/%/simx" + (f"/%{name}/" if name else "")
        token = peer.wait_for_token(lambda token, kind=kind, start=start: f"/{kind}{start}" in token)
        assert token.split("/")[3] == "0"
    numbers = [token.split("/")[4] for token in peer.tokens]
    assert len(numbers) == len(set(numbers))


def test_each_publisher_counts_from_1_with_its_own_id(server: Ros2World) -> None:
    peer = server.peer()
    for key in (JOINTS, TIME):
        peer.listen(key)
    server.on_server(server.simulation.start)
    joints = [peer.next(JOINTS) for _ in range(5)]
    time = peer.next(TIME)
    for before, after in itertools.pairwise(joints):
        assert after.number == before.number + 1
    assert joints[0].number >= 1
    assert {len(sent.attachment) for sent in joints} == {33}
    assert {sent.attachment[16] for sent in joints} == {16}
    assert joints[0].attachment[17:] == joints[1].attachment[17:] != time.attachment[17:]


def test_all_topics_of_a_step_have_one_stamp_the_time_of_the_step(server: Ros2World) -> None:
    peer = server.peer()
    server.on_server(lambda: (server.simulation.start(), server.simulation.pause()))
    for key in (JOINTS, TIME, MOVING):
        peer.listen(key)
    for key in (JOINTS, TIME, MOVING):  # each comes once the server knows that somebody listens
        peer.next(key)
    for steps in range(1, 25):
        assert peer.trigger("step")["success"]
        stamp = peer.next(JOINTS, lambda sent, steps=steps: sent.stamp > (steps - 0.5) * 0.05).stamp
        assert stamp / 0.05 == pytest.approx(steps, abs=1e-6)
        peer.next(TIME, lambda sent, stamp=stamp: seconds(sent.value["clock"]) == stamp)
        moving = peer.next(MOVING, lambda sent, stamp=stamp: stamps_of(sent) & {stamp} != set())
        assert stamps_of(moving) == {stamp}


def test_joint_states_are_those_of_the_remote_api_with_the_sign_of_ros(server: Ros2World) -> None:
    peer = server.peer()
    pause_after_steps(server)
    joints, scene = server.simulation.joints, server.simulation.scene

    def read() -> list[tuple[float, float, float]]:
        handles = [scene.resolve(name) for name in ("shoulder", "elbow", "wheel")]
        return [(joints.position(each), joints.velocity(each), joints.force(each)) for each in handles]

    expected = server.on_server(read)
    peer.listen(JOINTS)
    state = peer.next(JOINTS).value
    assert state["name"] == ["shoulder", "elbow", "wheel"]
    for position, velocity, effort, (q, dq, f) in zip(
        state["position"], state["velocity"], state["effort"], expected, strict=True
    ):
        assert (position, velocity, effort) == (q, dq, -f)
    assert any(f for *_, f in expected)


def test_transforms_agree_with_the_remote_api(server: Ros2World) -> None:
    peer = server.peer()
    pause_after_steps(server)
    peer.listen(MOVING)
    peer.listen(FIXED, is_late=True)
    transforms = by_child(peer.next(FIXED)) | by_child(peer.next(MOVING))
    assert transforms["arm"]["header"]["frame_id"] == "world"
    assert transforms["forearm"]["header"]["frame_id"] == "arm"
    for name in ("arm", "forearm", "tip", "box", "stand", "eye", "wheel_holder"):
        handle = server.simulation.scene.resolve(name)
        position, (w, *xyz) = server.on_server(
            lambda handle=handle: frames.get_pose(server.simulation, handle)
        )
        pose = in_world(transforms, name)
        assert pose[:3, 3] == pytest.approx(position, abs=1e-9), name
        expected = matrix(
            {
                "transform": {
                    "translation": dict.fromkeys("xyz", 0.0),
                    "rotation": dict(zip("xyzw", (*xyz, w), strict=True)),
                }
            }
        )
        assert pose[:3, :3] == pytest.approx(expected[:3, :3], abs=1e-9), name


def test_a_frame_is_in_one_of_both_topics_and_has_one_parent(server: Ros2World) -> None:
    peer = server.peer()
    peer.listen(MOVING)
    peer.listen(FIXED, is_late=True)
    fixed, moving = peer.next(FIXED), peer.next(MOVING)
    names = [each["child_frame_id"] for sent in (fixed, moving) for each in sent.value["transforms"]]
    assert len(names) == len(set(names))
    assert set(by_child(moving)) == {"arm", "forearm", "wheel_holder", "box"}
    assert not any(name.startswith("/") for name in names)


def test_the_optical_frame_looks_along_z_with_x_to_the_right_and_y_down(server: Ros2World) -> None:
    peer = server.peer()
    peer.listen(FIXED, is_late=True)
    pose = in_world(by_child(peer.next(FIXED)), "eye_optical_frame")
    data = server.simulation.data
    right, up, back = np.array(data.cam_xmat[0]).reshape(3, 3).T
    assert pose[:3, 0] == pytest.approx(right, abs=1e-9)
    assert pose[:3, 1] == pytest.approx(-up, abs=1e-9)
    assert pose[:3, 2] == pytest.approx(-back, abs=1e-9)
    assert pose[:3, 3] == pytest.approx(data.cam_xpos[0], abs=1e-9)


def test_static_transforms_are_sent_again_when_something_was_placed_elsewhere(server: Ros2World) -> None:
    peer = server.peer()
    peer.listen(FIXED, is_late=True)
    assert by_child(peer.next(FIXED))["stand"]["transform"]["translation"]["x"] == pytest.approx(2.0)
    stand = server.simulation.scene.resolve("stand")
    server.on_server(lambda: frames.set_position(server.simulation, stand, -1, [3.0, 0.0, 0.5]))
    moved = peer.next(FIXED, lambda sent: by_child(sent)["stand"]["transform"]["translation"]["x"] > 2.5)
    assert by_child(moved)["stand"]["transform"]["translation"]["x"] == pytest.approx(3.0)
    server.on_server(lambda: frames.set_position(server.simulation, stand, -1, [2.0, 0.0, 0.5]))
    peer.next(FIXED, lambda sent: by_child(sent)["stand"]["transform"]["translation"]["x"] < 2.5)


def test_a_late_transient_local_subscriber_gets_the_static_transforms_and_a_plain_one_does_not(
    server: Ros2World,
) -> None:
    late, plain = server.peer(), server.peer()
    plain.listen(FIXED)
    plain.listen(TIME)
    late.listen(FIXED, is_late=True)
    sent = late.next(FIXED)
    assert len(sent.attachment) == 33
    assert sent.number >= 1
    plain.next(TIME)
    assert not plain.got(FIXED)


def test_no_message_is_made_while_nobody_listens(server: Ros2World, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []
    for outlet in server.gateway._offered.outlets:
        if isinstance(outlet.offer, Published) and not outlet.publisher.qos.is_transient_local:
            name = outlet.offer.topic

            def made(_: Any, name: str = name) -> None:
                asked.append(name)

            offer = outlet.offer.__class__(outlet.offer.topic, outlet.offer.type, made, outlet.offer.qos)
            monkeypatch.setattr(outlet, "offer", offer)
    server.on_server(server.simulation.start)
    server.wait_until(lambda: server.simulation.step_count > 20)
    assert asked == []
    peer = server.peer()
    peer.listen(TIME)
    server.wait_until(lambda: len(asked) > 0)
    assert set(asked) == {"/clock"}


def test_a_paused_simulation_repeats_the_time_and_shows_latecomers_the_present_state(
    server: Ros2World,
) -> None:
    pause_after_steps(server)
    now = server.simulation.time
    peer = server.peer()
    peer.listen(TIME)
    peer.listen(MOVING)
    assert [seconds(peer.next(TIME).value["clock"]) for _ in range(2)] == pytest.approx([now, now])
    assert seconds(peer.next(MOVING).value["transforms"][0]["header"]["stamp"]) == pytest.approx(now)
    assert not peer.got(MOVING)


def test_a_simulation_that_waits_for_a_trigger_repeats_the_time(server: Ros2World) -> None:
    cid = server.client()
    start_stepped(cid)
    assert v.simxSynchronousTrigger(cid) == v.simx_return_ok
    server.wait_until(lambda: server.simulation.step_count == 1)
    peer = server.peer()
    peer.listen(TIME)
    peer.listen(JOINTS)
    assert [seconds(peer.next(TIME).value["clock"]) for _ in range(2)] == pytest.approx([0.05] * 2)
    assert peer.next(JOINTS).stamp == pytest.approx(0.05)
    v.simxFinish(cid)


def test_time_jumps_back_to_0_with_a_stop_and_starts_again(server: Ros2World) -> None:
    peer = server.peer()
    peer.listen(TIME)
    server.on_server(server.simulation.start)
    peer.next(TIME, lambda sent: seconds(sent.value["clock"]) > 0.5)
    server.on_server(server.simulation.stop)
    peer.next(TIME, lambda sent: seconds(sent.value["clock"]) == 0.0)
    server.on_server(server.simulation.start)
    assert peer.next(TIME, lambda sent: seconds(sent.value["clock"]) > 0.0).value["clock"]["sec"] == 0
    assert server.simulation.state is SimulationState.RUNNING


def test_a_namespace_and_a_domain_are_in_keys_and_tokens(tmp_path: Path) -> None:
    with ros2_world(tmp_path, place=Place(7, "/arm")) as server:
        peer = server.peer()
        peer.listen(f"7/arm/joint_states/{JOINT_STATE}")
        peer.listen(JOINTS)
        peer.watch()
        peer.watch(7)
        server.on_server(server.simulation.start)
        assert peer.next(f"7/arm/joint_states/{JOINT_STATE}").value["name"]
        peer.wait_for_token(lambda token: "/NN/%/%arm/simx" in token)
        peer.wait_for_token(lambda token: "/MP/%/%arm/simx/%arm%joint_states/" in token)
        assert not [token for token in peer.tokens if token.startswith("@ros2_lv/0/")]
        assert not peer.got(JOINTS)
        assert peer.trigger("pause", "7/arm/simx")["success"]


def test_humble_gets_its_own_hash_and_its_services_answer(tmp_path: Path) -> None:
    with ros2_world(tmp_path, distribution=Distribution.HUMBLE) as server:
        key = "0/joint_states/sensor_msgs::msg::dds_::JointState_/TypeHashNotSupported"
        peer = server.peer()
        peer.listen(key)
        peer.watch()
        server.on_server(server.simulation.start)
        assert peer.next(key).value["name"] == ["shoulder", "elbow", "wheel"]
        token = peer.wait_for_token(lambda token: "%joint_states" in token)
        assert "/TypeHashNotSupported/" in token


def test_a_scene_that_is_loaded_brings_its_own_topics(tmp_path: Path) -> None:
    other = tmp_path / "other.xml"
    other.write_text(
        "<mujoco><worldbody><body name='pole'><joint name='pivot'/><geom size='.1'/></body>"
        "<camera name='front' resolution='32 32'/></worldbody></mujoco>",
        encoding="utf-8",
    )
    with ros2_world(tmp_path) as server:
        peer = server.peer()
        peer.watch()
        peer.listen(JOINTS)
        peer.wait_for_token(lambda token: "%eye%image_raw" in token)
        server.on_server(lambda: server.simulation.load(other))
        peer.wait_for_token(lambda token: "%front%image_raw" in token)
        assert peer.next(JOINTS, lambda sent: sent.value["name"] == ["pivot"])
        assert not [token for token in peer.tokens if "%eye%" in token]


def test_stamps_of_a_message_are_no_multiples_of_rounding_errors(server: Ros2World) -> None:
    peer = server.peer()
    peer.listen(TIME)
    server.on_server(server.simulation.start)
    clock = peer.next(TIME, lambda sent: seconds(sent.value["clock"]) > 5).value["clock"]
    assert clock["nanosec"] % 50_000_000 == 0
    assert 0 <= clock["nanosec"] < 1_000_000_000
    assert math.isfinite(clock["sec"])


def test_a_fault_in_one_kind_of_topic_leaves_the_others(
    server: Ros2World, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    (clock,) = [each for each in server.gateway._contents if isinstance(each, Clock)]

    def broken() -> Iterable[Offer]:
        raise ZeroDivisionError("a fault")

    peer = server.peer()
    peer.watch()
    peer.wait_for_token(lambda token: "%clock" in token)
    with monkeypatch.context() as changed:
        changed.setattr(clock, "offers", broken)
        server.on_server(server.gateway._renew)
        peer.wait_for_no_token(lambda token: "%clock" in token)
    assert "Clock" in caplog.text
    assert any("%joint_states" in token for token in peer.tokens)
    server.on_server(server.gateway._renew)
    peer.wait_for_token(lambda token: "%clock" in token)


def test_of_two_topics_with_one_name_the_first_stays_and_the_log_says_so(
    server: Ros2World, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    caplog.set_level(logging.INFO)
    (clock,) = [each for each in server.gateway._contents if isinstance(each, Clock)]
    first = list(clock.offers())
    with monkeypatch.context() as changed:
        changed.setattr(clock, "offers", lambda: [*first, *first])
        server.on_server(server.gateway._renew)
    assert "/clock" in caplog.text
    assert "two objects have it" in caplog.text
    peer = server.peer()
    peer.listen(TIME)
    peer.next(TIME)
    server.on_server(server.gateway._renew)
