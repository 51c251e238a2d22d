"""``simx_client.Client``: typed objects, arrays and exceptions; in one process, and over a real server."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from processes import ROOT, ServerProcess, server
from real_world import RealWorld

import simx_client as v
from simx_client import Client, errors
from simx_client.clients import CLIENTS
from simx_client.protocol.codec import decode_batch
from simx_client.redirect import VARIABLE, format_redirects

SCENE = """
<mujoco>
  <statistic extent="1"/>
  <visual><map znear="0.1" zfar="5"/></visual>
  <worldbody>
    <light pos="0 0 4"/>
    <body name="red" pos="-0.5 0.3 0.5" mocap="true"><geom type="box" size="0.2 0.1 0.5" rgba="1 0 0 1"/></body>
    <body name="blue" pos="0.5 -0.3 0" mocap="true"><geom type="box" size="0.2 0.1 0.5" rgba="0 0 1 1"/></body>
    <camera name="above" pos="0 0 3" fovy="60" resolution="64 48"/>
    <camera name="plan" pos="0 0 3" projection="orthographic" fovy="2" resolution="64 48"/>
    <body name="arm" pos="0 3 1">
      <joint name="shoulder" axis="0 0 1"/><geom type="capsule" fromto="0 0 0 0.5 0 0" size="0.05"/>
      <body name="hand" pos="0.5 0 0">
        <joint name="wrist" axis="0 0 1"/><geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.05"/>
        <site name="tip" pos="0.3 0 0"/>
      </body>
    </body>
    <body name="seer" pos="0 -3 1"><geom size="0.05"/><site name="eye" euler="0 90 0"/></body>
    <body name="wall" pos="1 -3 1" mocap="true"><geom type="box" size="0.1 1 1"/></body>
    <body name="wheel" pos="-5 0 1">
      <joint name="axle" axis="1 1 0"/><geom size="0.1" contype="0"/>
    </body>
    <body name="stand" pos="5 0 1"><geom size="0.05"/>
      <body name="weight" pos="0.2 0 0">
        <geom type="box" size="0.05 0.05 0.05" mass="2"/><site name="cell" pos="-0.2 0 0"/>
      </body>
    </body>
  </worldbody>
  <actuator><position name="shoulder" joint="shoulder" kp="200" kv="40"/><velocity name="wrist" joint="wrist" kv="10"/>
    <velocity name="axle" joint="axle" kv="10"/>
  </actuator>
  <sensor><rangefinder site="eye"/><force site="cell"/><torque site="cell"/></sensor>
</mujoco>
"""
FREE_FALL = 9.81


@pytest.fixture
def world(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[RealWorld]:
    monkeypatch.setenv("MUJOCO_GL", "disable")
    (tmp_path / "scene.xml").write_text(SCENE)
    world = RealWorld(tmp_path / "scene.xml")
    yield world
    world.close()


@pytest.fixture
def client(world: RealWorld) -> Client:
    return Client.of(world.client())


def messages_of(client: Client) -> list[int]:
    """The number of calls in each message that a client sends from now on."""
    transport: Any = CLIENTS._connections[client.id]._transport
    sizes: list[int] = []
    send = transport.send

    def counted(payload: bytes, deadline: float) -> None:
        sizes.append(len(decode_batch(payload).calls))
        send(payload, deadline)

    transport.send = counted
    return sizes


# --- objects -------------------------------------------------------------------------------------


def test_a_joint_is_read_and_set_in_radians_and_looked_up_once(client: Client) -> None:
    sizes = messages_of(client)
    client.joint("shoulder").position = 0.25
    assert client.joint("shoulder").position == pytest.approx(0.25)
    assert client.joint("shoulder") is client.joint("shoulder")
    assert sizes == [2, 1, 1], "looked up, set, read"
    client.joint("shoulder").max_force = 12
    assert client.joint("shoulder").max_force == 12


def test_joints_reach_their_targets_and_tell_their_velocity_and_force(client: Client) -> None:
    shoulder, wrist = both = client.joints("shoulder", "wrist")
    with client.stepping() as step:
        shoulder.target_position = 0.5
        wrist.target_velocity = 1.0
        for _ in range(60):
            step()
        assert shoulder.position == pytest.approx(0.5, abs=0.01)
        assert both.velocities == pytest.approx([0.0, 1.0], abs=0.05)
        assert both.positions == pytest.approx([shoulder.position, wrist.position])
        assert both.forces == pytest.approx([shoulder.force, wrist.force])


def test_targets_are_write_only_and_say_so(client: Client) -> None:
    with pytest.raises(AttributeError, match="write only"):
        _ = client.joint("shoulder").target_position


def test_as_many_numbers_as_joints_are_needed(client: Client) -> None:
    with pytest.raises(ValueError, match="2 joints need as many numbers, got 3"):
        client.joints("shoulder", "wrist").positions = [0, 0, 0]


def test_poses_are_metres_and_xyzw_in_the_world_and_in_other_frames(client: Client) -> None:
    client.joints("shoulder", "wrist").positions = np.array([np.pi / 2, 0.0])
    tip = client.dummy("tip")
    assert tip.position == pytest.approx([0, 3.8, 1], abs=1e-6)
    assert tip.relative_to(client.object("hand")).position == pytest.approx([0.3, 0, 0], abs=1e-6)
    half = np.sqrt(0.5)
    position, quaternion = tip.pose
    assert quaternion == pytest.approx([0, 0, half, half], abs=1e-6)
    assert tip.relative_to(None).euler_angles == pytest.approx([0, 0, np.pi / 2], abs=1e-6)
    assert tip.pose.matrix @ [1, 0, 0, 1] == pytest.approx([*np.add(position, (0, 1, 0)), 1], abs=1e-6)


def test_a_pose_that_is_set_is_the_pose_that_is_read(client: Client) -> None:
    red, blue = client.object("red"), client.object("blue")
    red.pose = (0.1, 0.2, 0.3), (0, 0, np.sqrt(0.5), np.sqrt(0.5))
    assert red.position == pytest.approx([0.1, 0.2, 0.3])
    blue.relative_to(red).pose = [1, 0, 0], [0, 0, 0, 1]
    assert blue.position == pytest.approx([0.1, 1.2, 0.3], abs=1e-6)
    assert blue.pose.quaternion == pytest.approx(red.quaternion, abs=1e-6)
    blue.position = red.position - [1, 0, 0]
    assert blue.position == pytest.approx([-0.9, 0.2, 0.3], abs=1e-6)
    with pytest.raises(ValueError, match="needs 3 numbers, got 2"):
        blue.position = [1, 2]


def test_velocities_are_measured_in_world_axes_over_the_last_pass(client: Client) -> None:
    shoulder, wheel, hand = client.joint("shoulder"), client.object("wheel"), client.object("hand")
    client.joint("axle").target_velocity = 2.0
    with client.stepping() as step:
        shoulder.target_position = 1.0
        for _ in range(10):
            step()
        # Not Euler rates: the axis is none of the three.
        assert wheel.angular_velocity == pytest.approx([np.sqrt(2), np.sqrt(2), 0], abs=0.02)
        before = hand.position
        step()
        assert hand.velocity == pytest.approx((hand.position - before) / 0.05, abs=1e-4)
        assert np.linalg.norm(hand.velocity) > 0.05


def test_objects_have_names_kinds_and_parents(client: Client) -> None:
    listed = client.objects()
    assert listed["shoulder"] == "joint"
    assert listed["above"] == "camera"
    assert listed["eye"] == "proximity sensor"
    parent = client.joint("wrist").parent
    assert parent is not None
    assert parent.name in listed
    client.object("stand").parent = client.object("seer")
    parent = client.object("stand").parent
    assert parent is not None
    assert parent.name == "seer"
    client.object("stand").parent = None
    assert client.object("stand").parent is None


# --- sensors -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "top", "bottom"), [("above", (9, 19), (45, 32)), ("plan", (16, 19), (48, 29))]
)
def test_pictures_stand_upright_and_depth_is_metres(
    client: Client, name: str, top: tuple[int, int], bottom: tuple[int, int]
) -> None:
    """Red is to the left and up, 2 m below the camera; blue to the right and down, 2.5 m below."""
    camera = client.camera(name)
    assert camera.resolution == (64, 48)
    assert (camera.near, camera.far) == pytest.approx((0.1, 5))
    picture, depth = camera.rgb(), camera.depth()
    assert (picture.shape, picture.dtype) == ((48, 64, 3), np.uint8)
    assert (depth.shape, depth.dtype) == ((48, 64), np.float32)
    reds, blues = picture[:, :, 0] > 100, picture[:, :, 2] > 100
    assert depth[reds & (depth < 2.2)] == pytest.approx(2.0, abs=1e-3)
    assert depth[blues].min() == pytest.approx(2.5, abs=1e-3)
    for colour, up, left in ((reds, True, True), (blues, False, False)):
        rows, columns = np.nonzero(colour)
        assert (rows.mean() < 24) == up
        assert (columns.mean() < 32) == left
    assert depth.max() == pytest.approx(5.0)
    assert camera.grey() == pytest.approx(picture.astype(int).sum(axis=2) // 3, abs=1)


def test_pixels_and_depths_give_the_points_of_the_scene(client: Client) -> None:
    camera = client.camera("above")
    picture, depth = camera.rgb(), camera.depth()
    f = 32 / np.tan(camera.perspective_angle / 2)
    rows, columns = np.nonzero((picture[:, :, 0] > 100) & (depth < 2.2))
    ahead = depth[rows, columns]
    points = np.stack([(31.5 - columns) / f * ahead, (23.5 - rows) / f * ahead, ahead], axis=1)
    found = points @ camera.pose.matrix[:3, :3].T + camera.position
    pixel = 2 / f
    assert found.min(axis=0) == pytest.approx([-0.7, 0.2, 1.0], abs=pixel)
    assert found.max(axis=0) == pytest.approx([-0.3, 0.4, 1.0], abs=pixel)


def test_a_picture_is_the_callers_own_and_lies_in_memory_as_libraries_want_it(client: Client) -> None:
    picture = client.camera("above").rgb()
    picture[:] = 7
    assert picture.flags.c_contiguous
    assert client.camera("above").depth().flags.writeable


def test_a_proximity_sensor_tells_point_distance_and_object(client: Client) -> None:
    eye = client.proximity_sensor("eye")
    with client.stepping() as step:
        step()
        detection = eye.read()
        assert detection is not None
        assert detection.distance == pytest.approx(0.9, abs=1e-5)
        assert detection.point == pytest.approx([0, 0, 0.9], abs=1e-5)
        assert detection.normal == pytest.approx([0, 0, -1], abs=1e-5)
        assert detection.object.name == "wall"
        client.object("wall").position = [1, 30, 1]
        step()
        assert eye.read() is None


def test_a_force_sensor_feels_the_weight(client: Client) -> None:
    cell = client.force_sensor("cell")
    assert cell.read() is None
    assert not cell.is_broken
    with client.stepping() as step:
        for _ in range(3):
            step()
        wrench = cell.read()
        assert wrench is not None
        assert np.linalg.norm(wrench.force) == pytest.approx(2 * FREE_FALL, rel=1e-3)
        assert np.linalg.norm(wrench.torque) == pytest.approx(2 * FREE_FALL * 0.2, rel=1e-3)


# --- signals, scripts, simulation ------------------------------------------------------------------


def test_signals_have_the_type_of_their_value(client: Client) -> None:
    for value in (3, 0.5, "grün", -1):
        client.signals["it"] = value
        read = client.signals["it"]
        assert (type(read), read) == (type(value), value)
    client.signals["it"] = b"\x00\xff"
    assert client.signals.buffers["it"] == b"\x00\xff"
    client.signals["n"] = np.float32(0.25)
    assert client.signals.floats["n"] == 0.25
    client.signals["n"] = np.int64(4)
    assert client.signals.get("n", None) == 4
    assert "it" in client.signals
    del client.signals["it"]
    assert "it" not in client.signals
    assert client.signals.get("it", "nothing") == "nothing"


def test_a_missing_signal_is_a_key_error_that_names_those_there_are(client: Client) -> None:
    client.signals["speed"] = 1.5
    with pytest.raises(errors.NoSuchSignal, match=r"^there is no float signal 'sped'; set are: 'speed'"):
        _ = client.signals.floats["sped"]
    with pytest.raises(KeyError):
        _ = client.signals["sped"]
    with pytest.raises(ValueError, match="needs a name"):
        client.signals[""] = 1


def test_a_name_in_two_kinds_must_be_asked_for_by_kind(client: Client) -> None:
    client.signals.ints["it"] = 1
    client.signals.strings["it"] = "one"
    with pytest.raises(ValueError, match="set in 2 kinds"):
        _ = client.signals["it"]
    assert (client.signals.ints["it"], client.signals.strings["it"]) == (1, "one")


def test_the_simulation_tells_state_and_time(client: Client) -> None:
    simulation = client.simulation
    assert (simulation.state, simulation.time) == ("stopped", 0)
    simulation.time_step = 0.01
    assert simulation.time_step == 0.01
    simulation.start()
    assert simulation.state == "running"
    with pytest.raises(errors.SimxError, match="stop it first"):
        simulation.time_step = 0.02
    simulation.pause()
    assert simulation.state == "paused"
    simulation.stop()
    assert (simulation.state, simulation.time) == ("stopped", 0)


# --- stepping and together ---------------------------------------------------------------------------


def test_a_pass_with_all_that_is_set_and_watched_is_one_message(client: Client) -> None:
    both, tip, eye = client.joints("shoulder", "wrist"), client.dummy("tip"), client.proximity_sensor("eye")
    with client.stepping(lambda: (both.positions, tip.position, client.simulation.time)) as step:
        assert step.latest[2] == 0
        sizes = messages_of(client)
        for turn in range(1, 4):
            both.target_positions = [0.1 * turn, 0.0]
            positions, where, seconds = step()
            assert seconds == pytest.approx(0.05 * turn)
        assert sizes == [2 + 1 + 4] * 3
        assert positions == pytest.approx(both.positions)
        assert where == pytest.approx(tip.position)
        assert eye.read() is not None


def test_stepping_again_gives_the_same_numbers_and_leaves_the_simulation_as_it_was(client: Client) -> None:
    shoulder = client.joint("shoulder")

    def run() -> list[float]:
        shoulder.target_position = 1.0
        return [step() for _ in range(5)]

    with client.stepping(lambda: shoulder.position) as step:
        first = run()
        assert step.restart() == 0.0
        assert run() == first
        assert first[-1] > 0.01
    assert client.simulation.state == "stopped"
    client.simulation.start()
    client.simulation.pause()
    with client.stepping():
        assert client.simulation.state == "running"
    assert client.simulation.state == "paused"
    client.simulation.start()
    with client.stepping():
        pass
    assert client.simulation.state == "running"
    assert v.simxSynchronousTrigger(client.id) == v.simx_return_remote_error_flag, "stepped mode is over"


def test_what_is_watched_may_change_and_may_be_missing(client: Client) -> None:
    seen: list[str] = ["shoulder"]
    with client.stepping(
        lambda: ([client.joint(n).position for n in seen], client.signals.get("s", None))
    ) as step:
        assert step() == ([pytest.approx(0)], None)
        seen.append("wrist")
        client.signals["s"] = 2
        assert step() == ([pytest.approx(0), pytest.approx(0)], 2)


def test_pictures_come_with_the_step_too_and_show_what_the_pass_left(client: Client) -> None:
    camera, red = client.camera("above"), client.object("red")
    with client.stepping(lambda: (camera.rgb(), camera.depth())) as step:
        sizes = messages_of(client)
        for x in (-0.5, 0.5):
            red.position = [x, 0.3, 0.5]
            picture, depth = step()
            columns = np.nonzero((picture[:, :, 0] > 100) & (depth < 2.2))[1]
            assert (columns.mean() < 32) == (x < 0)
        assert sizes == [1 + 1 + 4] * 2


def test_an_exception_within_stepping_ends_it_and_comes_out(client: Client) -> None:
    def program() -> None:
        with client.stepping():
            client.joint("shoulder").position = 0.5
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        program()
    assert client.simulation.state == "stopped"
    assert client.joint("shoulder").position == 0.0, "what was set was dropped"


def test_stepping_does_not_nest(client: Client) -> None:
    with client.stepping(), pytest.raises(RuntimeError, match="stepping already"), client.stepping():
        pass


def test_together_is_one_message_in_order_and_reads_see_what_was_set(client: Client) -> None:
    shoulder, wrist = client.joints("shoulder", "wrist")
    sizes = messages_of(client)
    with client.together():
        shoulder.position = 0.1
        wrist.position = 0.2
    with client.together():
        shoulder.position = 0.3
        assert shoulder.position == pytest.approx(0.3)
    assert sizes == [2, 2]


def test_an_exception_within_together_drops_what_was_not_sent(client: Client) -> None:
    shoulder = client.joint("shoulder")

    def program() -> None:
        with client.together():
            shoulder.position = 0.5
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        program()
    assert shoulder.position == 0.0


# --- what goes wrong -----------------------------------------------------------------------------


def test_a_wrong_name_suggests_the_nearest(client: Client) -> None:
    with pytest.raises(errors.NoSuchObject, match=r"^no object named 'sholder'; did you mean 'shoulder'"):
        client.joint("sholder")
    with pytest.raises(LookupError):
        client.object("sholder")


def test_an_object_of_another_kind_is_said_with_both_kinds(client: Client) -> None:
    with pytest.raises(errors.WrongKind, match=r"^'red' is a shape, not a joint; client.object"):
        client.joint("red")
    with pytest.raises(TypeError, match="'shoulder' is a joint, not a camera"):
        client.camera("shoulder")


def test_a_removed_object_is_gone_and_its_name_is_looked_up_anew(client: Client) -> None:
    red, again = client.object("red"), client.object("red")
    v.simxRemoveObject(client.id, red.handle, v.simx_opmode_blocking)
    with pytest.raises(
        errors.ObjectGone, match=r"^object 'red' was removed from the scene; look it up again"
    ):
        _ = again.position
    with pytest.raises(errors.NoSuchObject):
        client.object("red")
    client.object("blue").remove()
    with pytest.raises(errors.NoSuchObject):
        client.object("blue")


def test_objects_of_a_scene_that_another_client_replaced_are_gone(
    world: RealWorld, client: Client, tmp_path: Path
) -> None:
    shoulder = client.joint("shoulder")
    (tmp_path / "other.xml").write_text(SCENE)
    world.simulation.load(tmp_path / "other.xml")
    for _ in range(2):
        with pytest.raises(
            errors.ObjectGone, match=r"^joint 'shoulder' belongs to a scene that was replaced"
        ):
            _ = shoulder.position
    assert client.joint("shoulder").position == 0.0


def test_a_refusal_has_the_servers_reason_and_the_call(client: Client) -> None:
    with pytest.raises(
        errors.RemoteError,
        match=r"^there is no child script of 'red'.*\(simxCallScriptFunction\('red', 1, 'go'",
    ):
        client.call("go", client.object("red"))


def test_what_waits_for_a_step_is_refused_by_the_step(client: Client) -> None:
    with client.stepping() as step:
        client.object("red").parent = client.object("blue")
        with pytest.raises(errors.RemoteError, match=r"mocap .*\(simxSetObjectParent"):
            step()
        step()
    assert client.simulation.state == "stopped"


def test_no_answer_in_time_and_no_server_have_exceptions_of_their_own(
    world: RealWorld, client: Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    shoulder = client.joint("shoulder")
    client.timeout = 0.02
    with monkeypatch.context() as patch:
        patch.setattr(world.engine, "turn", lambda max_wait=0.0: None)
        with pytest.raises(TimeoutError, match=r"^no answer within 0\.02 s \(simxGetJointPosition"):
            _ = shoulder.position
    client.timeout = 2.0
    assert shoulder.position == 0.0
    CLIENTS._connections[client.id]._transport.lose()  # type: ignore[union-attr]
    with pytest.raises(ConnectionError, match=r"^the server went away at"):
        _ = shoulder.position


def test_a_closed_client_says_so(client: Client) -> None:
    shoulder = client.joint("shoulder")
    client.close()
    with pytest.raises(errors.NotConnected, match="this client was closed"):
        _ = shoulder.position


@pytest.mark.parametrize(
    ("address", "port", "where"),
    [
        ("here", None, ("here", 19997)),
        ("here:7", None, ("here", 7)),
        ("lab-3@router:7447", None, ("lab-3@router", 7447)),
        ("::1", None, ("::1", 19997)),
        ("[::1]:7", None, ("[::1]", 7)),
        ("here", 8, ("here", 8)),
    ],
)
def test_the_port_may_stand_in_the_address(address: str, port: int | None, where: tuple[str, int]) -> None:
    from simx_client.modern.opening import split_port

    assert split_port(address, port) == where


def test_a_port_in_two_places_and_an_impossible_one_are_refused() -> None:
    with pytest.raises(ValueError, match="leave one out"):
        Client("here:7", 8)
    with pytest.raises(ValueError, match=r"must be 1\.\.65535"):
        Client("here", 70000)


# --- the surface stays what it is ------------------------------------------------------------------


def test_the_client_is_no_part_of_the_drop_in_surface_and_loaded_only_when_asked_for() -> None:
    assert "Client" not in v.__all__
    program = """
        import sys, simx_client
        assert "Client" not in dir(simx_client)
        print([m for m in sys.modules if m.startswith(("simx_client.modern", "numpy"))])
        from simx_client import Client
        print([m for m in sys.modules if m in ("simx_client.modern.client", "numpy", "zenoh")])
    """
    program = "\n".join(line.strip() for line in program.splitlines())
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, cwd=ROOT, check=True
    )
    assert done.stdout.splitlines() == ["[]", "['simx_client.modern.client']"]
    with pytest.raises(AttributeError, match="no attribute 'Clint'"):
        v.Clint  # type: ignore[attr-defined]  # noqa: B018


def test_programs_of_users_type_check(tmp_path: Path) -> None:
    pytest.importorskip("pyright")
    program = tmp_path / "program.py"
    program.write_text(
        """
import numpy as np
from numpy.typing import NDArray
from simx_client import Client

with Client("127.0.0.1:19997") as client:
    arm = client.joints("a", "b")
    depth: NDArray[np.float32] = client.camera("c").depth()
    with client.stepping(lambda: (arm.positions, client.signals.ints["s"])) as step:
        arm.target_positions = arm.positions + 0.1
        arm.target_positions = [1, 2]
        client.joint("a").target_position = 0.5
        client.object("b").pose = (0, 0, 1), (0, 0, 0, 1)
        angles, level = step()
        sums: tuple[NDArray[np.float64], int] = angles + 1, level + 1
        wrong: str = level
    client.joint("a").position = "far"
"""
    )
    done = subprocess.run(
        [sys.executable, "-m", "pyright", "--pythonpath", sys.executable, program, "examples/modern_loop.py"],
        capture_output=True,
        text=True,
        cwd=ROOT,
    )
    assert re.findall(r":(\d+):\d+ - error", done.stdout) == ["16", "17"], done.stdout


# --- over Zenoh ----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def tutorial() -> Iterator[ServerProcess]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MUJOCO_GL", "disable")
        with server("ur5_rg2_kinect", "--speed", "max", "--realm", "lab-3", "-q") as process:
            yield process


@pytest.fixture
def redirect(tutorial: ServerProcess, monkeypatch: pytest.MonkeyPatch) -> None:
    """What goes to port 19997 finds this server."""
    monkeypatch.setenv(VARIABLE, format_redirects({19997: ("127.0.0.1", tutorial.port)}))


def test_clients_come_by_port_and_by_name_several_at_a_time_and_beside_legacy_ones(
    tutorial: ServerProcess,
) -> None:
    legacy = v.simxStart("127.0.0.1", tutorial.port, True, True, 5000, 5)
    with (
        Client("127.0.0.1", tutorial.port) as first,
        Client(f"lab-3@127.0.0.1:{tutorial.port}") as second,
    ):
        assert sorted([legacy, first.id, second.id]) == [0, 1, 2]
        first.signals["from"] = "first"
        assert second.signals["from"] == "first"
        code, value = v.simxGetStringSignal(legacy, "from", v.simx_opmode_blocking)
        assert (code, value) == (0, bytearray(b"first"))
    assert (first.id, second.id) == (-1, -1)
    v.simxFinish(legacy)


def test_a_client_that_nobody_holds_any_more_is_closed(tutorial: ServerProcess) -> None:
    client = Client("127.0.0.1", tutorial.port)
    number = client.id
    client.joint("UR5_joint1").position = 0
    del client
    assert CLIENTS.get(number) is None


def test_the_tutorials_ball_is_seen_where_and_as_far_away_as_it_is(tutorial: ServerProcess) -> None:
    with Client("127.0.0.1", tutorial.port) as client:
        arm = client.joints(*[f"UR5_joint{number}" for number in range(1, 7)])
        camera, ball = client.camera("kinect_rgb"), client.object("Target")
        with client.stepping() as step:
            arm.positions = targets = np.radians([90, -45, 90, 0, -100, 0])
            arm.target_positions = targets
            step()
            picture, depth = camera.rgb().astype(int), client.camera("kinect_depth").depth()
            (left, up, ahead), f = (
                ball.relative_to(camera).position,
                320 / np.tan(camera.perspective_angle / 2),
            )
        red, green, blue = picture[:, :, 0], picture[:, :, 1], picture[:, :, 2]
        rows, columns = np.nonzero((blue > 120) & (blue > red + 60) & (green > red + 40))
        column, row = 320 - f * left / ahead, 240 - f * up / ahead
        assert (columns.min() + columns.max()) / 2 == pytest.approx(column, abs=2)
        assert (rows.min() + rows.max()) / 2 == pytest.approx(row, abs=2)
        # Of a sphere of 0.05 m, the ray through the middle of its outline meets the nearest point.
        ray = np.array([left, up, ahead])
        nearest = ahead * (1 - 0.05 / np.linalg.norm(ray))
        assert depth[round(row), round(column)] == pytest.approx(nearest, abs=0.002)


def test_no_server_is_an_exception_with_the_reason(tutorial: ServerProcess) -> None:
    with pytest.raises(errors.ConnectionFailed, match=r"tried .*nobody.*lab-3"):
        Client(f"nobody@127.0.0.1:{tutorial.port}", timeout=1.0)


def test_the_example_turns_the_camera_to_the_ball(
    tutorial: ServerProcess, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(ROOT / "examples")
    import modern_loop  # type: ignore[import-not-found]

    with Client("127.0.0.1", tutorial.port) as client:
        assert modern_loop.follow(client, passes=100) < 0.02


@pytest.mark.usefixtures("redirect")
def test_the_page_about_it_runs_as_it_stands() -> None:
    page = (ROOT / "docs" / "python.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    assert len(blocks) > 6
    program = ModuleType("page")
    for block in blocks:
        exec(compile(block, "docs/python.md", "exec"), vars(program))


def test_the_page_names_only_what_there_is() -> None:
    page = (ROOT / "docs" / "python.md").read_text(encoding="utf-8")
    for name in re.findall(r"\bsimx[A-Z]\w+", page):
        assert hasattr(v, name), name
    for name in re.findall(r"^\| `(\w+)` \|", page, re.MULTILINE):
        assert issubclass(getattr(errors, name), errors.SimxError), name
