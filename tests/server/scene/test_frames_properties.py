"""Frames hold for any numbers: what is set is got in every frame, rotations keep, parents compose, joints have two."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes_for_tests import run, world_of
from seeds import many

from simx_server.errors import CommandError
from simx_server.scene.editing import editing
from simx_server.scene.poses import frames, poses
from simx_server.scene.poses.frames import JOINT_BASE_FLAG, PARENT, WORLD
from simx_server.scene.poses.poses import Pose
from simx_server.world.world import World

pytestmark = pytest.mark.slow

SCENE = """
<mujoco>
  <option integrator="implicitfast" gravity="0 0 0"/>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 0.1"/>
    <light name="sun" pos="0 0 3" dir="0 0.6 -0.8"/>
    <camera name="view" pos="0 -2 1" euler="60 0 0"/>
    <body name="wall" pos="0 -1 0.5" euler="10 20 30"><geom size="0.1"/><site name="spot" pos="0.1 0.2 0.3"/></body>
    <body name="ghost" mocap="true" pos="0 3 0"><geom size="0.1" contype="0" conaffinity="0"/></body>
    <body name="free" pos="2 0 1" euler="0 40 0"><freejoint/><geom size="0.1" mass="1"/>
      <body name="load" pos="0 0 0.2" euler="0 0 50"><geom size="0.05" mass="0.1"/></body></body>
    <body name="base" pos="0.5 0 0.1" euler="0 0 70"><geom size="0.05" contype="0" conaffinity="0"/>
      <body name="upper" pos="0 0 0.1">
        <joint name="turn" axis="0 0 1" pos="0.05 0 0"/><geom size="0.02" mass="1" contype="0" conaffinity="0"/>
        <body name="lower" pos="0.4 0 0" euler="30 0 0">
          <joint name="tilt" axis="0.6 0.8 0"/><joint name="push" type="slide" axis="0 1 1"/>
          <geom size="0.02" mass="1" contype="0" conaffinity="0"/>
          <site name="tip" pos="0.3 0 0"/><camera name="eye" pos="0.3 0 0" euler="0 90 0"/>
          <body name="hand" pos="0.3 0 0">
            <joint name="socket" type="ball" pos="0 0 -0.1"/><geom size="0.02" mass="0.1" contype="0" conaffinity="0"/>
          </body></body></body></body>
  </worldbody>
  <custom>
    <text name="simx:joint:turn" data="mode=passive"/><text name="simx:joint:tilt" data="mode=passive"/>
    <text name="simx:joint:push" data="mode=passive"/><text name="simx:joint:socket" data="mode=passive"/>
    <text name="simx:camera:view" data="view=yes"/>
  </custom>
</mujoco>
"""
PLACED = (
    "floor",
    "view",
    "wall",
    "spot",
    "ghost",
    "free",
    "load",
    "base",
    "lower",
    "hand",
    "tip",
    "eye",
    "turn",
)
ALL = (*PLACED, "upper", "tilt", "push", "socket", "sun")

angles = st.floats(-math.pi, math.pi)
lengths = st.floats(-3, 3)
points = st.tuples(lengths, lengths, lengths)
eulers = st.tuples(angles, angles, angles)
rotations = eulers.map(frames.quat_from_euler)
joint_values = st.tuples(angles, angles, st.floats(-0.3, 0.3), rotations)
quick = settings(max_examples=many(14), deadline=None)


@lru_cache(maxsize=1)
def scene() -> World:
    return world_of(SCENE)


def bent(values: tuple[float, float, float, poses.Quaternion]) -> World:
    """The scene, its joints at these values."""
    world = scene()
    sim = world.simulation
    for name, value in zip(("turn", "tilt", "push"), values[:3], strict=True):
        sim.joints.set_position(sim.scene.resolve(name), value)
    sim.joints.set_spherical_rotation(sim.scene.resolve("socket"), values[3])
    return world


LOST_NEAR_LOCK = 2.02 * math.sqrt(1 - frames.GIMBAL_LOCK**2)
"""Near gimbal lock the Euler angles are those of the lock: at most twice the angle to it is lost."""


def same_turn(a: poses.Quaternion, b: poses.Quaternion, tolerance: float = 1e-7) -> bool:
    return bool(np.allclose(poses.matrix(a), poses.matrix(b), atol=tolerance))


def same_pose(a: Pose, b: Pose) -> bool:
    return bool(np.allclose(a[0], b[0], atol=1e-7)) and same_turn(a[1], b[1])


@quick
@given(st.sampled_from(PLACED), st.sampled_from(("world", "parent", *ALL)), points, rotations, joint_values)
def test_what_is_set_in_any_frame_is_got_in_it(name, reference, point, rotation, values) -> None:
    world = bent(values)
    sim = world.simulation
    handle = sim.scene.resolve(name)
    relative = {"world": WORLD, "parent": PARENT}.get(reference)
    if relative is None:
        relative = sim.scene.resolve(reference)
        if sim.scene.is_below(relative, handle):  # it would move along
            return
    frames.set_position(sim, handle, relative, point)
    assert frames.get_position(sim, handle, relative) == pytest.approx(list(point), abs=1e-7)
    frames.set_quaternion(sim, handle, relative, frames.xyzw_from_wxyz(rotation))
    assert same_turn(frames.get_pose(sim, handle, relative)[1], rotation)
    assert frames.get_position(sim, handle, relative) == pytest.approx(list(point), abs=1e-7)
    euler = frames.get_orientation(sim, handle, relative)
    frames.set_orientation(sim, handle, relative, euler)
    assert same_turn(frames.get_pose(sim, handle, relative)[1], rotation, LOST_NEAR_LOCK)


@quick
@given(
    st.sampled_from(("tip", "hand", "free", "wall")),
    st.sampled_from(("turn", "push")),
    points,
    rotations,
    joint_values,
)
def test_the_flag_means_a_joints_fixed_frame_and_the_scalar_first(
    name, joint, point, rotation, values
) -> None:
    world = bent(values)
    sim = world.simulation
    handle, reference = sim.scene.resolve(name), sim.scene.resolve(joint)
    frames.set_position(sim, handle + JOINT_BASE_FLAG, reference, point)
    frames.set_quaternion(sim, handle + JOINT_BASE_FLAG, reference, rotation)
    assert frames.get_position(sim, handle + JOINT_BASE_FLAG, reference) == pytest.approx(
        list(point), abs=1e-7
    )
    got = frames.get_quaternion(sim, handle + JOINT_BASE_FLAG, reference)
    assert same_turn((got[0], got[1], got[2], got[3]), rotation)
    fixed, seen = frames.get_pose(sim, reference), frames.get_pose(sim, handle)
    assert same_pose(poses.compose(fixed, (point, rotation)), seen)


@quick
@given(joint_values)
def test_poses_compose_through_the_parents_and_between_any_two(values) -> None:
    world = bent(values)
    sim = world.simulation
    for handle, item in sim.scene.objects.items():
        world, local = frames.get_pose(sim, handle), frames.get_pose(sim, handle, PARENT)
        parent = sim.scene.objects.get(item.parent)
        outer = poses.IDENTITY if parent is None else frames.moving_pose(sim, parent)
        assert same_pose(poses.compose(outer, local), world), item.name
    for a in ("tip", "eye", "hand", "free"):
        for b in ("lower", "base", "load"):
            first, second = sim.scene.resolve(a), sim.scene.resolve(b)
            forth, back = frames.get_pose(sim, first, second), frames.get_pose(sim, second, first)
            assert same_pose(poses.inverse(forth), back)


@quick
@given(joint_values, joint_values)
def test_a_joints_own_pose_ignores_its_value_and_its_matrix_is_the_way_to_the_moving_frame(
    before, after
) -> None:
    world = bent(before)
    sim = world.simulation
    turn = sim.scene.resolve("turn")
    own = frames.get_pose(sim, turn)
    bent(after)
    assert same_pose(frames.get_pose(sim, turn), own)
    for name in ("turn", "tilt", "push", "socket"):
        item = sim.scene.get(sim.scene.resolve(name))
        rows = np.array(sim.joints.matrix(item.handle)).reshape(3, 4)
        fixed, moving = frames.get_pose(sim, item.handle), frames.moving_pose(sim, item)
        change = poses.compose(poses.inverse(fixed), moving)
        assert np.allclose(poses.matrix(change[1]), rows[:, :3], atol=1e-7), name
        assert np.allclose(change[0], rows[:, 3], atol=1e-7), name


@quick
@given(st.sampled_from(("upper", "lower", "hand", "push")), points, rotations, joint_values)
def test_a_link_placed_against_its_joint_leaves_the_joint_and_takes_its_children(
    name, point, rotation, values
) -> None:
    world = bent(values)
    sim = world.simulation
    item = sim.scene.get(sim.scene.resolve(name))
    above, below = item.parent, sim.scene.children(item.handle)
    joint = (
        frames.get_pose(sim, above),
        frames.moving_pose(sim, sim.scene.get(above)),
        sim.joints.matrix(above),
    )
    hanging = [frames.get_pose(sim, child, item.handle) for child in below]
    frames.set_position(sim, item.handle, PARENT, point)
    frames.set_quaternion(sim, item.handle, PARENT, frames.xyzw_from_wxyz(rotation))
    assert same_pose(frames.get_pose(sim, item.handle, PARENT), (point, rotation))
    assert same_pose(frames.get_pose(sim, above), joint[0])
    assert same_pose(frames.moving_pose(sim, sim.scene.get(above)), joint[1])
    assert sim.joints.matrix(above) == pytest.approx(joint[2], abs=1e-7)
    for child, pose in zip(below, hanging, strict=True):
        assert same_pose(frames.get_pose(sim, child, item.handle), pose)
    bent(values)
    assert same_pose(frames.get_pose(sim, item.handle, PARENT), (point, rotation))


@pytest.mark.parametrize("kind", ["hinge", "ball", "slide"])
def test_a_link_placed_against_its_joint_weighs_what_it_does_there(kind: str) -> None:
    """Against the same machine written down at once; also after another edit of the scene."""
    machine = """<mujoco><option integrator="implicitfast"/><worldbody><body name="link" {place}>
      <joint name="j" type="{kind}" {joint}/><geom type="box" size="0.1 0.2 0.3" mass="2"/></body></worldbody>
      </mujoco>"""
    axis = "" if kind == "ball" else 'axis="0 0 1"'
    turned = "" if kind == "ball" else 'axis="0 1 0"'
    placed_world = world_of(machine.format(place="", kind=kind, joint=axis))
    placed = placed_world.simulation
    wanted_world = world_of(
        machine.format(place='pos="0.5 0 0" euler="90 0 0"', kind=kind, joint=f'pos="-0.5 0 0" {turned}')
    )
    wanted = wanted_world.simulation
    link = placed.scene.resolve("link")
    frames.set_position(placed, link, WORLD, [0.5, 0, 0])
    frames.set_orientation(placed, link, WORLD, [math.pi / 2, 0, 0])
    placed.model.opt.gravity[:] = wanted.model.opt.gravity[:] = (1, 2, -9)
    assert same_pose(frames.get_pose(placed, link), frames.get_pose(wanted, link))
    for world in (placed_world, wanted_world):
        run(world, 1)
        editing.create_dummy(world.simulation, 0.1)
        for _ in range(3):
            world.step()
    assert same_pose(frames.get_pose(placed, link), frames.get_pose(wanted, link))
    placed.stop()
    assert frames.get_position(placed, placed.scene.resolve("j")) == pytest.approx([0, 0, 0])


@given(eulers)
def test_euler_angles_quaternion_and_matrix_are_one_rotation(euler: tuple[float, float, float]) -> None:
    quat = frames.quat_from_euler(euler)
    rows = np.array(frames.matrix12(((1.0, 2.0, 3.0), quat))).reshape(3, 4)
    assert np.allclose(rows[:, :3] @ rows[:, :3].T, np.eye(3), atol=1e-12)
    assert rows[:, 3].tolist() == [1, 2, 3]
    a, b, c = frames.euler_from_quat(quat)
    assert max(abs(a), 2 * abs(b), abs(c)) <= math.pi
    assert rows[0, 2] == pytest.approx(math.sin(b), abs=1e-9)
    assert same_turn(
        frames.quat_from_euler((a, b, c)), quat, 1e-6 if abs(rows[0, 2]) < 0.9999 else LOST_NEAR_LOCK
    )
    x, y, z, w = frames.xyzw_from_wxyz(quat)
    assert w >= 0
    assert same_turn((w, x, y, z), quat)


@pytest.mark.parametrize("side", [-1, 1])
@given(angles, angles)
def test_gimbal_lock_keeps_the_rotation_and_gives_alpha_zero(side: int, alpha: float, gamma: float) -> None:
    quat = frames.quat_from_euler((alpha, side * math.pi / 2, gamma))
    euler = frames.euler_from_quat(quat)
    assert euler[0] == 0
    assert euler[1] == pytest.approx(side * math.pi / 2, abs=1e-5)
    assert same_turn(frames.quat_from_euler(euler), quat, 1e-5)


@settings(max_examples=many(4), deadline=None)
@given(
    st.sampled_from(("wall", "spot", "tip", "eye", "view", "free", "base")),
    st.sampled_from(("none", "ghost", "hand", "tilt", "load")),
    st.booleans(),
    st.booleans(),
    joint_values,
)
def test_a_new_parent_keeps_the_place_or_the_local_numbers(name, parent, keep, running, values) -> None:
    world = world_of(SCENE)
    sim = world.simulation
    for joint, value in zip(("turn", "tilt", "push"), values[:3], strict=True):
        sim.joints.set_position(sim.scene.resolve(joint), value)
    if running:
        run(world, 1)
    handle = sim.scene.resolve(name)
    target = -1 if parent == "none" else sim.scene.resolve(parent)
    world, local = frames.get_pose(sim, handle), frames.get_pose(sim, handle, PARENT)
    if target != -1 and sim.scene.is_below(target, handle):
        with pytest.raises(CommandError, match="own child"):
            editing.set_parent(sim, handle, target, keep)
        return
    editing.set_parent(sim, handle, target, keep)
    assert sim.scene.get(handle).parent == target
    assert same_pose(
        frames.get_pose(sim, handle) if keep else frames.get_pose(sim, handle, PARENT),
        world if keep else local,
    )
    if running:
        sim.stop()
        assert same_pose(frames.get_pose(sim, handle), world)


@pytest.mark.parametrize(
    "name", ["wall", "ghost", "free", "base", "spot", "tip", "eye", "view", "floor", "turn", "hand"]
)
def test_what_is_set_while_running_stays_set_until_the_stop(name: str) -> None:
    world = world_of(SCENE)
    sim = world.simulation
    handle = sim.scene.resolve(name)
    before = frames.get_pose(sim, handle)
    run(world, 1)
    frames.set_position(sim, handle, WORLD, [0.7, -1.5, 2.0])
    frames.set_orientation(sim, handle, WORLD, [0.3, -0.4, 0.5])
    for _ in range(2):
        world.step()
    assert frames.get_position(sim, handle) == pytest.approx([0.7, -1.5, 2.0], abs=1e-6)
    assert frames.get_orientation(sim, handle) == pytest.approx([0.3, -0.4, 0.5], abs=1e-6)
    sim.stop()
    assert frames.get_pose(sim, handle) == before


@pytest.mark.parametrize("name", ["wall", "spot", "eye", "view", "floor", "ghost", "free"])
def test_what_is_placed_between_two_passes_has_moved(name: str) -> None:
    """A target that a program moves has a velocity, as in V-REP."""
    world = world_of(SCENE)
    sim = world.simulation
    handle = sim.scene.resolve(name)
    run(world, 2)
    x, y, z = frames.get_position(sim, handle)
    alpha, beta, gamma = frames.get_orientation(sim, handle)
    frames.set_position(sim, handle, WORLD, [x + 0.05, y, z - 0.1])
    frames.set_quaternion(
        sim,
        handle,
        WORLD,
        frames.xyzw_from_wxyz(
            poses.multiply(poses.about((0, 0, 1), 0.02), frames.quat_from_euler((alpha, beta, gamma)))
        ),
    )
    world.step()
    linear, euler_rates, angular = world.velocities.measure(handle)
    assert linear == pytest.approx([1, 0, -2], abs=1e-6)
    assert angular == pytest.approx([0, 0, 0.4], abs=1e-6)
    assert euler_rates == pytest.approx([0, 0, 0.4], abs=1e-6)
    world.step()
    assert world.velocities.measure(handle)[0] == pytest.approx([0, 0, 0], abs=1e-6)


@given(points, rotations, points, rotations)
def test_a_composed_pose_has_the_bits_of_its_parts(place, turn, inner_place, inner_turn) -> None:
    composed = poses.compose((place, turn), (inner_place, inner_turn))
    assert composed == (poses.add(place, poses.rotate(turn, inner_place)), poses.multiply(turn, inner_turn))
