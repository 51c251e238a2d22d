"""Poses in V-REP's frames: references, Euler angles, quaternion order, joints' two frames, setting every object."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scenes_for_tests import ARM, arm, run, world_of

from simx_server.errors import CommandError, UnknownHandle
from simx_server.scene.poses import frames, poses
from simx_server.scene.poses.frames import JOINT_BASE_FLAG
from simx_server.simulation.simulation import Simulation

ANGLE = st.floats(-math.pi, math.pi)
HALF = math.sqrt(0.5)


def at(sim: Simulation, name: str, relative_to: int = -1) -> list[float]:
    return frames.get_position(sim, sim.scene.resolve(name), relative_to)


@given(ANGLE, ANGLE, ANGLE)
def test_euler_angles_are_rx_ry_rz_and_come_back_as_the_same_rotation(a: float, b: float, c: float) -> None:
    def turn(axis: int, angle: float) -> np.ndarray:
        x, y = (axis + 1) % 3, (axis + 2) % 3
        matrix = np.eye(3)
        matrix[x, x] = matrix[y, y] = math.cos(angle)
        matrix[x, y], matrix[y, x] = -math.sin(angle), math.sin(angle)
        return matrix

    expected = turn(0, a) @ turn(1, b) @ turn(2, c)
    quat = frames.quat_from_euler((a, b, c))
    assert np.allclose(poses.matrix(quat), expected, atol=1e-12)
    # Within V-REP's gimbal lock alpha is given up, which costs up to 2 sqrt(2 (1 - 0.999995)) of accuracy.
    again = frames.quat_from_euler(frames.euler_from_quat(quat))
    assert np.allclose(poses.matrix(again), expected, atol=1e-6 if abs(expected[0, 2]) < 0.9999 else 6.4e-3)


@given(*[st.floats(-1, 1)] * 3)
@example(0.0, 2.220446049250313e-16, -0.125)  # close to -z, where all numbers of the result are tiny at first
def test_smallest_turn_takes_z_to_the_axis(x: float, y: float, z: float) -> None:
    length = math.sqrt(x * x + y * y + z * z)
    if length < 1e-3:
        return
    axis = (x / length, y / length, z / length)
    assert np.allclose(poses.rotate(poses.turn_z_to(axis), (0, 0, 1)), axis, atol=1e-12)


def test_gimbal_lock_gives_alpha_zero() -> None:
    euler = frames.euler_from_quat(frames.quat_from_euler((0.3, math.pi / 2, 0.2)))
    assert euler == pytest.approx([0.0, math.pi / 2, 0.5], abs=1e-6)


def test_position_relative_to_world_parent_and_another_object() -> None:
    world = arm()
    sim = world.simulation
    assert at(sim, "lower") == pytest.approx([0.9, 0, 0.2])
    assert at(sim, "lower", -11) == pytest.approx([0, 0, 0])
    assert at(sim, "base", -11) == pytest.approx([0.5, 0, 0.1])
    assert at(sim, "lower", sim.scene.resolve("cube")) == pytest.approx([0.9, -1, 0.15])
    with pytest.raises(UnknownHandle):
        frames.get_position(sim, 1, 999)


def test_joint_as_reference_is_its_moving_frame_and_with_the_flag_its_fixed_one() -> None:
    world = arm()
    sim = world.simulation
    shoulder, lower = sim.scene.resolve("shoulder"), sim.scene.resolve("lower")
    sim.joints.set_position(shoulder, math.pi / 2)
    assert at(sim, "lower") == pytest.approx([0.5, 0.4, 0.2])
    assert at(sim, "lower", shoulder) == pytest.approx([0.4, 0, 0])
    assert frames.get_position(sim, lower + JOINT_BASE_FLAG, shoulder) == pytest.approx([0, 0.4, 0])
    assert frames.get_quaternion(sim, shoulder) == pytest.approx([0, 0, 0, 1])
    assert frames.get_quaternion(sim, lower) == pytest.approx([0, 0, HALF, HALF])
    assert frames.get_quaternion(sim, lower + JOINT_BASE_FLAG) == pytest.approx([HALF, 0, 0, HALF])
    assert frames.get_quaternion(sim, lower, shoulder) == pytest.approx([0, 0, 0, 1])


def test_joint_frame_has_the_axis_as_z_and_the_bodys_frame_where_they_agree() -> None:
    world = arm()
    sim = world.simulation
    rows = np.array(frames.matrix12(frames.get_pose(sim, sim.scene.resolve("elbow")))).reshape(3, 4)
    assert rows[:, 2] == pytest.approx([0, 1, 0])
    assert rows[:, 3] == pytest.approx([0.9, 0, 0.2])


def test_moving_frame_is_the_fixed_one_turned_by_the_joint_value() -> None:
    """Against MuJoCo's own kinematics: several joints of every kind on one body, with `ref`."""
    world = world_of("""<mujoco><compiler angle="radian"/><worldbody>
        <body name="p" pos="1 2 3" quat="0.8 0.6 0 0"><geom size="1"/>
        <body name="b" pos="0.1 0 0" quat="0.6 0 0.8 0">
          <joint name="slide" type="slide" axis="1 1 0" ref="0.2"/>
          <joint name="turn" axis="0 0.6 0.8" pos="0.3 0 0" ref="0.4"/>
          <joint name="last" axis="0 0 1" pos="0 0.5 0"/><geom size="1"/></body></body></worldbody></mujoco>""")
    sim = world.simulation
    for name, value in (("slide", 0.7), ("turn", -1.1), ("last", 2.0)):
        sim.joints.set_position(sim.scene.resolve(name), value)
    sim.refresh()
    for name in ("slide", "turn", "last"):
        item = sim.scene.get(sim.scene.resolve(name))
        fixed = frames.get_pose(sim, item.handle)
        # The fixed frame is that of joint value 0; a slide's anchor is where it starts, at its `ref`.
        shift = 0.2 if name == "slide" else 0.0
        assert np.allclose(np.add(fixed[0], shift * sim.data.xaxis[item.id]), sim.data.xanchor[item.id])
        assert poses.rotate(fixed[1], (0, 0, 1)) == pytest.approx(sim.data.xaxis[item.id])
        moving = frames.moving_pose(sim, item)
        change = np.array(sim.joints.matrix(item.handle)).reshape(3, 4)
        expected = np.array(poses.matrix(fixed[1])) @ change[:, :3]
        assert np.allclose(poses.matrix(moving[1]), expected, atol=1e-9)
    # The last joint's axis is the body's z, so its moving frame is turned as the body.
    assert at(sim, "b", sim.scene.resolve("last")) == pytest.approx([0, -0.5, 0])
    assert frames.get_orientation(sim, sim.scene.resolve("b"), sim.scene.resolve("last")) == pytest.approx(
        [0, 0, 0]
    )


def test_camera_looks_along_plus_z_with_plus_x_to_the_left() -> None:
    world = arm()
    sim = world.simulation
    rows = np.array(frames.matrix12(frames.get_pose(sim, sim.scene.resolve("overview")))).reshape(3, 4)
    camera = sim.data.cam_xmat[sim.model.camera("overview").id].reshape(3, 3)
    assert rows[:, 2] == pytest.approx(-camera[:, 2])
    assert rows[:, 1] == pytest.approx(camera[:, 1])
    assert rows[:, 0] == pytest.approx(-camera[:, 0])
    light = np.array(frames.matrix12(frames.get_pose(sim, sim.scene.resolve("sun")))).reshape(3, 4)
    assert light[:, 2] == pytest.approx([0, 0, -1])


@pytest.mark.parametrize(
    "name",
    [
        "base",
        "cube",
        "wall",
        "upper",
        "lower",
        "hand",
        "tip",
        "eye",
        "mount",
        "overview",
        "sun",
        "floor",
        "shoulder",
        "elbow",
    ],
)
def test_every_sort_of_object_goes_where_it_is_set(name: str) -> None:
    world = arm()
    sim = world.simulation
    handle = sim.scene.resolve(name)
    sim.joints.set_position(sim.scene.resolve("shoulder"), 0.4)
    sim.joints.set_position(sim.scene.resolve("elbow"), -0.7)
    before = sim.version
    children = {c: frames.get_pose(sim, c, handle) for c in sim.scene.children(handle)}
    frames.set_position(sim, handle, -1, [0.3, -0.2, 1.5])
    frames.set_quaternion(sim, handle, -1, [0.5, 0.5, -0.5, 0.5])
    assert sim.version > before
    assert frames.get_position(sim, handle) == pytest.approx([0.3, -0.2, 1.5])
    if name != "sun":  # MuJoCo keeps no roll of a light
        assert frames.get_quaternion(sim, handle) == pytest.approx([0.5, 0.5, -0.5, 0.5])
    for child, pose in children.items():
        for now, then in zip(frames.get_pose(sim, child, handle), pose, strict=True):
            assert now == pytest.approx(then, abs=1e-9)
    sim.start()
    sim.stop()
    assert frames.get_position(sim, handle) == pytest.approx([0.3, -0.2, 1.5])


def test_setting_relative_to_parent_and_by_euler_angles() -> None:
    world = arm()
    sim = world.simulation
    tip = sim.scene.resolve("tip")
    sim.joints.set_position(sim.scene.resolve("shoulder"), math.pi / 2)
    frames.set_position(sim, tip, -11, [0, 0, 0.1])
    assert at(sim, "tip") == pytest.approx([0.5, 0.4, 0.3])
    frames.set_orientation(sim, tip, sim.scene.resolve("base"), [0.1, -0.2, 0.3])
    assert frames.get_orientation(sim, tip) == pytest.approx([0.1, -0.2, 0.3])
    assert at(sim, "tip") == pytest.approx([0.5, 0.4, 0.3])


def test_placing_a_moving_body_takes_its_velocity_and_leaves_other_bodies_alone() -> None:
    world = arm()
    sim = world.simulation
    run(world, 1)
    frames.set_position(sim, sim.scene.resolve("cube"), -1, [0, 1, 2])
    for _ in range(4):
        world.step()
    falling = float(sim.data.qvel[sim.model.joint(sim.model.body("cube").jntadr[0]).dofadr[0] + 2])
    assert falling == pytest.approx(-9.81 * 0.2, rel=1e-3)
    frames.set_position(sim, sim.scene.resolve("wall"), -1, [0, -2, 0.5])
    assert falling == float(sim.data.qvel[sim.model.joint(sim.model.body("cube").jntadr[0]).dofadr[0] + 2])
    frames.set_position(sim, sim.scene.resolve("cube"), -1, [0, 1, 3])
    assert not sim.data.qvel[sim.model.joint(sim.model.body("cube").jntadr[0]).dofadr[0] :][:6].any()


def test_free_bodies_below_free_bodies_are_placed_with_what_is_above_them() -> None:
    world = world_of(
        """<mujoco><worldbody>
             <body name="base" pos="0 0 1"><geom size="0.1"/></body>
             <body name="dirt" pos="0.5 0 1"><freejoint/><geom size="0.1"/></body>
             <body name="crumb" pos="0.5 0.5 1"><freejoint/><geom size="0.1"/></body>
           </worldbody>
           <custom><text name="simx:object:dirt" data="parent=base"/>
                   <text name="simx:object:crumb" data="parent=dirt"/></custom></mujoco>"""
    )
    sim = world.simulation
    frames.set_orientation(sim, sim.scene.resolve("base"), -1, [0, 0, math.pi / 2])
    assert at(sim, "dirt") == pytest.approx([0, 0.5, 1])
    assert at(sim, "crumb") == pytest.approx([-0.5, 0.5, 1])


def test_moved_static_body_collides_at_its_new_place() -> None:
    world = arm()
    sim = world.simulation
    frames.set_position(sim, sim.scene.resolve("wall"), -1, [0, 1, 0.5])
    frames.set_orientation(sim, sim.scene.resolve("wall"), -1, [math.pi / 2, 0, 0])
    frames.set_position(sim, sim.scene.resolve("cube"), -1, [0, 1, 0.7])
    run(world, 40)
    assert at(sim, "cube")[2] == pytest.approx(0.6, abs=2e-3)


def test_mocap_body_is_moved_through_the_state() -> None:
    world = world_of(
        """<mujoco><worldbody><body name="ghost" mocap="true"><geom size="0.1"/></body></worldbody></mujoco>"""
    )
    sim = world.simulation
    frames.set_position(sim, 1, -1, [1, 2, 3])
    run(world, 1)
    assert at(sim, "ghost") == [1, 2, 3]


@pytest.mark.parametrize("value", [[1, 2], [1, 2, math.nan]])
def test_wrong_numbers_are_refused_and_change_nothing(value: list[float]) -> None:
    world = arm()
    sim = world.simulation
    before = at(sim, "cube")
    with pytest.raises(CommandError, match="3 finite numbers"):
        frames.set_position(sim, sim.scene.resolve("cube"), -1, value)
    with pytest.raises(CommandError, match="length 0"):
        frames.set_quaternion(sim, sim.scene.resolve("cube"), -1, [0, 0, 0, 0])
    assert at(sim, "cube") == before


def test_measured_velocity_is_the_difference_of_the_last_two_steps() -> None:
    world = arm()
    sim = world.simulation
    sim.start()
    tip = sim.scene.resolve("tip")
    assert world.velocities.measure(tip) == ([0, 0, 0], [0, 0, 0], [0, 0, 0])
    sim.joints.set_target_position(sim.scene.resolve("shoulder"), 10)
    for _ in range(6):
        world.step()
    linear, _euler, angular = world.velocities.measure(tip)
    assert angular == pytest.approx([0, 0, 3], abs=0.02)
    assert math.hypot(*linear) == pytest.approx(0.7 * 3, rel=0.01)
    # Of a joint, the frame that does not move with its own value; its child does.
    assert world.velocities.measure(sim.scene.resolve("shoulder"))[2] == [0, 0, 0]
    assert world.velocities.measure(sim.scene.resolve("upper"))[2] == pytest.approx([0, 0, 3], abs=0.02)
    assert world.velocities.measure(sim.scene.resolve("wall"))[0] == [0, 0, 0]
    sim.stop()
    assert world.velocities.measure(tip)[0] == [0, 0, 0]


def test_engine_agrees_on_where_things_are() -> None:
    world = arm()
    sim = world.simulation
    sim.joints.set_position(sim.scene.resolve("elbow"), 0.5)
    sim.refresh()
    model = mujoco.MjModel.from_xml_string(ARM)
    data = mujoco.MjData(model)
    data.joint("elbow").qpos[0] = 0.5
    mujoco.mj_forward(model, data)
    assert at(sim, "tip") == pytest.approx(data.site("tip").xpos)
    assert at(sim, "eye") == pytest.approx(data.camera("eye").xpos)


def test_an_infinite_angle_is_told_as_what_it_means() -> None:
    with pytest.raises(CommandError, match="physics has diverged; stop the simulation"):
        poses.about((0, 0, 1), math.inf)
