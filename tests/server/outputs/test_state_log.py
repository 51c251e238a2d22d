"""State logs: what is in them, read back with MCAP's own reader and Foxglove's own schemas."""

from __future__ import annotations

import errno
import logging
import math
import sys
from collections.abc import Iterator
from concurrent.futures import Future
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from processes import server, wait_until
from real_world import BLOCKING, RealWorld, start_stepped, step
from state_logs import read

import simx_client as v
from simx_client.protocol.cli.exit_codes import FAILURE
from simx_client.protocol.cli.installing import extra_line
from simx_server.app.server import serve
from simx_server.errors import CommandError
from simx_server.outputs.filming import Shot
from simx_server.outputs.packages import NewFile, OutputError
from simx_server.outputs.state_log import StateLog, state_log
from simx_server.outputs.state_log.images import Images
from simx_server.outputs.state_log.mcap_file import McapWriter
from simx_server.outputs.state_log.poses import Places
from simx_server.scene.editing.renaming import rename
from simx_server.scene.poses.frames import get_pose
from simx_server.scene.poses.placing import object_pose
from simx_server.settings.gathering import gather
from simx_server.settings.rules import SettingError

pytestmark = [pytest.mark.slow, pytest.mark.gl]

NEEDED = "needs the extra log"
pytest.importorskip("foxglove_schemas_protobuf", reason=NEEDED)
reader = pytest.importorskip("mcap.reader", reason=NEEDED)
exceptions = pytest.importorskip("mcap.exceptions", reason=NEEDED)


SCENE = """
<mujoco>
  <option gravity="0 0 0"/>
  <worldbody>
    <geom name="floor" type="plane" size="0 0 1" rgba="1 1 1 1"/>
    <body name="arm" pos="0 0 1">
      <joint name="hinge" axis="0 1 0"/>
      <joint name="slide" type="slide" axis="0 0 1"/>
      <geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.05" rgba="1 0 0 1"/>
      <site name="tip" pos="0.4 0 0"/>
      <camera name="eye" pos="0 0 0.5" resolution="32 24"/>
      <body pos="0.4 0 0"><geom type="box" size="0.1 0.2 0.3" rgba="0 1 0 1"/></body>
    </body>
    <body name="block" pos="0.5 0 3"><freejoint/><geom type="ellipsoid" size="0.1 0.2 0.3" mass="1"/></body>
    <body name="thing" pos="-1 0 1"><joint name="ball" type="ball"/><geom type="mesh" mesh="tetra"/></body>
    <light name="lamp" pos="0 0 3" mode="targetbody" target="arm"/>
    <camera name="follower" pos="2 0 2" mode="targetbody" target="arm" resolution="32 24"/>
  </worldbody>
  <asset><mesh name="tetra" vertex="0 0 0 0.3 0 0 0 0.3 0 0 0 0.3"/></asset>
  <actuator><velocity name="hinge" joint="hinge" kv="10"/></actuator>
</mujoco>
"""
"""By topic: times in nanoseconds and messages."""


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "arm.xml"
    path.write_text(SCENE)
    return path


@pytest.fixture
def place(scene: Path) -> Iterator[RealWorld]:
    opened = RealWorld(scene)
    yield opened
    opened.close()


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "run.mcap"


def transform(message: Any, name: str) -> tuple[list[float], list[float]]:
    """World position and quaternion xyzw of a frame."""
    (found,) = [each for each in message.transforms if each.child_frame_id == name]
    assert found.parent_frame_id == "world"
    place, turn = found.translation, found.rotation
    return [place.x, place.y, place.z], [turn.x, turn.y, turn.z, turn.w]


def test_log_has_the_pose_of_every_object_and_every_joint_after_each_step(
    place: RealWorld, path: Path
) -> None:
    sim = place.simulation
    log = StateLog(place.parts, path)
    sim.start()
    sim.joints.set_target_velocity(sim.scene.resolve("hinge"), 1.0)
    sim.joints.set_position(sim.scene.resolve("slide"), 0.1)
    expected = []
    for _ in range(10):
        place.parts.step()
        expected.append({item.name: object_pose(sim, item) for item in sim.scene.objects.values()})
    hinge = sim.scene.resolve("hinge")
    moved = sim.joints.position(hinge), sim.joints.velocity(hinge)
    sim.stop()
    log.close()
    logged = read(path)
    times = [time for time, _ in logged["/tf"]]
    assert len(times) == 13  # as it was loaded, at the start, after each pass, and after the stop
    assert times[-1] - times[0] == 500_000_000
    for (time, message), poses in zip(logged["/tf"][2:-1], expected, strict=True):
        assert {each.child_frame_id for each in message.transforms} == set(poses)
        for name, (position, (w, x, y, z)) in poses.items():
            assert np.allclose(transform(message, name)[0], position, atol=1e-12), name
            assert np.allclose(transform(message, name)[1], (x, y, z, w), atol=1e-9), name
        for each in message.transforms:
            assert each.timestamp.seconds * 1_000_000_000 + each.timestamp.nanos == time
    joints = {joint.name: joint for joint in logged["/joints"][-2][1].joints}
    assert set(joints) == {"hinge", "slide"}  # a ball has no single number
    assert (joints["hinge"].position, joints["hinge"].velocity) == moved
    assert moved[1] > 0.5
    assert [message.state for _, message in logged["/simulation"]] == [
        "stopped",
        *["running"] * 11,
        "stopped",
    ]
    assert logged["/simulation"][5][1].pass_count == 4
    assert logged["/simulation"][5][1].time == pytest.approx(0.2)


def test_scene_in_the_log_has_every_shape_in_a_frame_that_is_there(place: RealWorld, path: Path) -> None:
    StateLog(place.parts, path).close()
    logged = read(path)
    ((_, update),) = logged["/scene"]
    frames = {each.child_frame_id for each in logged["/tf"][0][1].transforms} | {"world"}
    by_frame = {entity.frame_id: entity for entity in update.entities}
    assert set(by_frame) == {"world", "arm", "shape1", "block", "thing"}
    assert set(by_frame) <= frames
    assert all(entity.frame_locked for entity in update.entities)
    capsule = by_frame["arm"].cylinders[0]
    assert (capsule.size.x, capsule.size.z) == pytest.approx((0.1, 0.4))
    assert capsule.pose.position.x == pytest.approx(0.2)
    assert sorted(round(ball.pose.position.x, 6) for ball in by_frame["arm"].spheres) == [0.0, 0.4]
    assert (capsule.color.r, capsule.color.g) == (1.0, 0.0)
    box = by_frame["shape1"].cubes[0]
    assert (box.size.x, box.size.y, box.size.z) == pytest.approx((0.2, 0.4, 0.6))
    assert by_frame["block"].spheres[0].size.z == pytest.approx(0.6)
    mesh = by_frame["thing"].triangles[0]
    assert (len(mesh.points), len(mesh.indices)) == (4, 12)
    assert by_frame["world"].cubes[0].size.x == pytest.approx(10.0)


def test_signals_are_logged_when_they_change_and_messages_when_they_come(
    place: RealWorld, path: Path
) -> None:
    log = StateLog(place.parts, path)
    client = place.client()
    start_stepped(client)
    for value in (0.5, 0.5, 1.5):
        v.simxSetFloatSignal(client, "speed", value, BLOCKING)
        step(client, 0.1)
    v.simxSetStringSignal(client, "word", b"yes\xff", BLOCKING)
    v.simxSetIntegerSignal(client, "count", 7, BLOCKING)
    v.simxClearFloatSignal(client, "speed", BLOCKING)
    v.simxAddStatusbarMessage(client, "half way", BLOCKING)
    step(client, 0.05)
    log.close()
    logged = read(path)
    assert [(m.is_set, m.value) for _, m in logged["/signals/speed"]] == [
        (True, 0.5),
        (True, 1.5),
        (False, 0.0),
    ]
    assert [m.value for _, m in logged["/signals/word"]] == ["yes\ufffd"]
    assert [m.value for _, m in logged["/signals/count"]] == [7]
    ((_, message),) = logged["/log"]
    assert (message.message, message.level) == ("half way", state_log.INFO)


def test_signals_of_two_kinds_may_have_one_name(place: RealWorld, path: Path) -> None:
    log = StateLog(place.parts, path)
    place.parts.signals.set_integer("a/b \N{SNOWMAN}", 7)
    place.parts.signals.set_float("a/b \N{SNOWMAN}", math.inf)
    place.simulation.start()
    log.close()
    found = {message.DESCRIPTOR.name: message.value for _, message in read(path)["/signals/a/b \N{SNOWMAN}"]}
    assert found == {"IntegerSignal": 7, "FloatSignal": math.inf}


def test_text_that_is_no_utf_8_is_logged_and_stops_nothing(
    place: RealWorld, path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """Programs of old send Latin-1."""
    log = StateLog(place.parts, path)
    client = place.client()
    _, block = v.simxGetObjectHandle(client, "block", BLOCKING)
    rename(place.simulation, block, "Kl\udcf6tzchen")
    v.simxAddStatusbarMessage(client, b"gr\xfcn", BLOCKING)  # pyright: ignore[reportArgumentType]
    v.simxSetIntegerSignal(client, b"gr\xfcn", 7, BLOCKING)  # pyright: ignore[reportArgumentType]
    start_stepped(client)
    step(client, 0.1)
    log.close()
    logged = read(path)
    assert [message.message for _, message in logged["/log"]] == ["gr?n"]
    assert [message.value for _, message in logged["/signals/gr?n"]] == [7]
    assert transform(logged["/tf"][-1][1], "Kl?tzchen")[0] == pytest.approx([0.5, 0, 3])
    assert len(logged["/tf"]) == 4
    assert "ERROR" not in caplog.text


def test_renamed_object_has_its_new_name_until_the_stop(place: RealWorld, path: Path) -> None:
    sim = place.simulation
    log = StateLog(place.parts, path)
    sim.start()
    place.parts.step()
    rename(sim, sim.scene.resolve("block"), "brick")
    place.parts.step()
    sim.stop()
    log.close()
    names = [{each.child_frame_id for each in message.transforms} for _, message in read(path)["/tf"]]
    assert ["block" in each for each in names] == [True, True, True, False, True]
    assert ["brick" in each for each in names] == [False, False, False, True, False]


def test_fault_of_the_log_ends_it_and_not_the_run(
    place: RealWorld, path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def fail(self: Places, sim: object) -> None:
        raise ValueError("a fault")

    log = StateLog(place.parts, path)
    place.simulation.start()
    place.parts.step()
    monkeypatch.setattr(Places, "state", fail)
    for _ in range(3):
        place.parts.step()
    log.close()
    assert place.simulation.step_count == 4
    assert caplog.text.count("ends here; the server goes on") == 1
    assert len(read(path)["/tf"]) == 3


def test_places_are_looked_for_once_after_an_edit(
    place: RealWorld, path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[Places] = []

    def counted(sim: Any) -> Places:
        made.append(Places(sim))
        return made[-1]

    monkeypatch.setattr(state_log, "Places", counted)
    log = StateLog(place.parts, path)
    place.simulation.start()
    place.parts.step()
    place.simulation.model_edited()
    for _ in range(5):
        place.parts.step()
    log.close()
    assert len(made) == 2


def test_what_is_edited_in_a_run_is_in_the_log_and_the_next_run_follows(place: RealWorld, path: Path) -> None:
    log = StateLog(place.parts, path)
    client = place.client()
    start_stepped(client)
    step(client, 0.5)
    _, block = v.simxGetObjectHandle(client, "block", BLOCKING)
    code, (copy,) = v.simxCopyPasteObjects(client, [block], BLOCKING)
    assert code == v.simx_return_ok
    step(client, 0.1)
    name = place.simulation.scene.get(copy).name
    v.simxStopSimulation(client, BLOCKING)
    start_stepped(client)
    step(client, 0.1)
    log.close()
    logged = read(path)
    names = [{each.child_frame_id for each in message.transforms} for _, message in logged["/tf"]]
    assert [name in each for each in names] == [False] * 12 + [True] * 2 + [False] * 4
    shown = [{entity.frame_id for entity in message.entities} for _, message in logged["/scene"]]
    assert [name in each for each in shown] == [False, True, False]
    times = [time for time, _ in logged["/simulation"]]
    assert times == sorted(times)
    assert times[-1] - times[0] == 700_000_000
    assert {message.run for _, message in logged["/simulation"]} == {0, 1, 2}


def test_images_of_a_camera_are_in_the_log(place: RealWorld, path: Path) -> None:
    sim = place.simulation
    log = StateLog(place.parts, path, Shot(place.parts, "follower"), fps=10)
    sim.start()
    assert wait_until(lambda: sim.step_count >= 20, 60.0, lambda: place.loop.turn(0.01))
    log.close()
    pictures = read(path)["/camera/follower"]
    assert len(pictures) == 11
    assert log.unseen == 0
    _, picture = pictures[-1]
    assert (picture.format, picture.frame_id, picture.data[:2]) == ("jpeg", "follower", b"\xff\xd8")


def test_images_that_fail_are_counted_and_told_once(path: Path, caplog: pytest.LogCaptureFixture) -> None:
    class Failing:
        name = "eye"

        def ask(self) -> Future[Any]:
            picture: Future[Any] = Future()
            picture.set_exception(CommandError("the driver is gone"))
            return picture

    shot: Any = Failing()
    writer = McapWriter(path)
    pictures = Images(shot, 10.0, writer)
    for number in range(3):
        pictures.take(number / 10, number)
    pictures.finish()
    writer.close()
    assert pictures.unseen == 3
    assert caplog.text.count("an image is missing in the state log: the driver is gone") == 1


def test_moving_a_static_shape_or_a_colour_is_seen(place: RealWorld, path: Path) -> None:
    sim = place.simulation
    log = StateLog(place.parts, path)
    sim.start()
    for count in range(30):
        sim.model.geom_rgba[1] = (0, 0, count / 30, 1)
        sim.model.site_pos[0] = (0.4, 0, count)
        sim.model_edited()
        sim.changed()
        place.parts.step()
    tip = sim.scene.resolve("tip")
    expected = get_pose(sim, tip)[0]
    log.close()
    logged = read(path)
    assert np.allclose(transform(logged["/tf"][-1][1], "tip")[0], expected)
    assert 2 <= len(logged["/scene"]) <= 4  # at most once a second


def test_slow_writing_leaves_passes_out_in_real_time_and_holds_them_at_full_speed(
    scene: Path, path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(state_log, "MOST_WAITING", 0)
    hurried, free = RealWorld(scene, speed=1e9), RealWorld(scene)
    log = StateLog(hurried.parts, path)
    hurried.simulation.start()
    assert wait_until(lambda: hurried.simulation.step_count >= 20, 60.0, hurried.loop.turn)
    log.close()
    assert log.left_out == 20
    log = StateLog(free.parts, path.with_name("b.mcap"))
    free.simulation.start()
    for _ in range(5):
        free.loop.turn()
    assert free.simulation.step_count == 0
    log.close()
    for each in (hurried, free):
        each.close()


def test_full_disk_ends_the_log_and_not_the_server(
    place: RealWorld, path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def full(self: NewFile, data: bytes) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")

    log = StateLog(place.parts, path)
    monkeypatch.setattr(NewFile, "write", full)
    place.simulation.start()
    for _ in range(20):
        place.parts.step()
    with caplog.at_level(logging.ERROR):
        log.close()
    assert (
        "ends here: No space left on device; what is in it can be read from its beginning, and the server goes on"
        in caplog.text
    )
    assert place.simulation.step_count == 20


def test_file_that_is_there_is_not_written_over(place: RealWorld, path: Path) -> None:
    path.write_bytes(b"a log")
    with pytest.raises(OutputError, match="exists already and is not written over; give another --state-log"):
        StateLog(place.parts, path)


@pytest.mark.parametrize("missing", ["mcap.writer", "foxglove_schemas_protobuf.Log_pb2"])
def test_without_the_packages_it_prints_the_line_that_installs_them(
    missing: str, scene: Path, path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setitem(sys.modules, missing, None)
    assert serve(gather({"scene": str(scene), "state_log": str(path)}, {})) == FAILURE
    assert (
        f"--state-log needs the package {missing}, which is not installed; {extra_line('log')}" in caplog.text
    )


def test_flags_that_cannot_be_used_say_what_is_valid() -> None:
    with pytest.raises(
        SettingError, match=r"flag --state-log: 'a.bag' cannot be used; valid: .* ends in \.mcap"
    ):
        gather({"state_log": "a.bag"}, {})
    with pytest.raises(SettingError, match="flag --state-log: does not go together with --count"):
        gather({"state_log": "a.mcap", "count": "2"}, {})


def test_what_is_logged_is_in_the_file_soon_also_when_it_is_little(place: RealWorld, path: Path) -> None:
    log = StateLog(place.parts, path)
    place.simulation.start()
    place.parts.step()
    assert wait_until(lambda: len(read(path)["/tf"]) == 3, 20.0)
    log.close()


def test_killed_server_leaves_a_log_up_to_its_last_second(scene: Path, path: Path) -> None:
    with server(scene, "--start", "--speed", "20", "--state-log", path) as process:
        assert wait_until(lambda: path.stat().st_size > 20_000, 60.0)
        process.kill()
    logged = read(path)
    assert len(logged["/tf"]) > 10
    assert math.isclose(logged["/simulation"][-1][1].time, 0.05 * logged["/simulation"][-1][1].pass_count)
