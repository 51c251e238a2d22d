"""Joints outside force mode: held, in motion, hybrid, spherical; what hangs on them; which joints a command takes."""

from __future__ import annotations

import math

import pytest
from handler_calls import World
from scenes_for_tests import run, slider, world_of
from scripted_world import scripted

from simx_server.errors import CommandError, UnknownHandle, WrongKind
from simx_server.joints import JointMode
from simx_server.scene.editing import editing
from simx_server.scene.poses import frames
from simx_server.simulation.simulation import Simulation


def rail(sim: Simulation) -> int:
    return sim.scene.resolve("rail")


def test_motion_mode_moves_at_the_target_velocity_whatever_it_carries() -> None:
    world = slider(note="mode=motion target_velocity=0.4", joint='range="-1 0.1" limited="true"')
    sim = world.simulation
    run(world, 4)
    assert sim.joints.position(rail(sim)) == pytest.approx(0.08)
    assert sim.joints.velocity(rail(sim)) == pytest.approx(0.4)
    world.step()
    assert sim.joints.position(rail(sim)) == pytest.approx(0.1)
    sim.joints.set_target_velocity(rail(sim), -1)
    for _ in range(2):
        world.step()
    assert sim.joints.position(rail(sim)) == pytest.approx(0.0, abs=1e-9)
    sim.joints.set_position(rail(sim), -0.5)
    world.step()
    assert sim.joints.position(rail(sim)) == pytest.approx(-0.55)
    sim.joints.set_target_velocity(rail(sim), 0)
    world.step()
    assert sim.joints.position(rail(sim)) == pytest.approx(-0.55)


def test_motion_pushes_what_is_in_the_way() -> None:
    world = world_of("""<mujoco><option integrator="implicitfast"/><worldbody><geom type="plane" size="5 5 1"/>
      <body pos="0 0 0.1" name="pusher"><joint name="rail" type="slide" axis="1 0 0"/>
        <geom type="box" size="0.05 0.05 0.05" mass="0.1"/></body>
      <body name="box" pos="0.11 0 0.1"><freejoint/><geom type="box" size="0.05 0.05 0.1" mass="5"/></body></worldbody>
      <custom><text name="simx:joint:rail" data="mode=motion target_velocity=0.5"/></custom></mujoco>""")
    sim = world.simulation
    run(world, 10)
    assert sim.joints.position(rail(sim)) == pytest.approx(0.25)
    assert frames.get_position(sim, sim.scene.resolve("box"))[0] > 0.34


@pytest.mark.parametrize("mode", ["passive", "ik", "dependent"])
def test_held_joint_takes_a_position_at_once_also_while_running(mode: str) -> None:
    world = slider(note=f"mode={mode}", joint='range="-0.2 0.2" limited="true"')
    sim = world.simulation
    run(world, 2)
    sim.joints.set_position(rail(sim), 1.0)
    assert sim.joints.position(rail(sim)) == 0.2
    world.step()
    assert sim.joints.position(rail(sim)) == 0.2
    assert sim.joints.force(rail(sim)) == 0


def test_hybrid_joint_is_driven_to_where_it_is_set() -> None:
    world = slider(note="mode=passive hybrid=on P=0.1 upper_velocity=1", gravity="0 0 0")
    sim = world.simulation
    assert sim.joints.is_hybrid(rail(sim))
    sim.joints.set_position(rail(sim), 0.05)
    assert sim.joints.position(rail(sim)) == 0.05
    run(world, 1)
    sim.joints.set_position(rail(sim), 0.08)
    assert sim.joints.position(rail(sim)) == pytest.approx(0.05, abs=1e-6)
    world.step()
    assert sim.joints.position(rail(sim)) == pytest.approx(0.08 - 0.03 * math.exp(-1), abs=0.004)
    for _ in range(10):
        world.step()
    assert sim.joints.position(rail(sim)) == pytest.approx(0.08, abs=1e-3)


def test_hybrid_joint_is_put_in_place_before_the_first_physics_step_of_a_run() -> None:
    world = slider(note="mode=passive hybrid=on P=0.1 upper_velocity=1", gravity="0 0 0")
    sim = world.simulation
    sim.start()
    sim.joints.set_position(rail(sim), 0.08)
    assert sim.joints.position(rail(sim)) == 0.08
    world.step()
    assert sim.joints.position(rail(sim)) == pytest.approx(0.08, abs=1e-9)
    sim.stop()
    assert sim.joints.position(rail(sim)) == 0.0


def test_hybrid_joint_takes_a_target_position_from_clients_and_scripts() -> None:
    joint = """<body name="cart"><joint name="rail" type="slide" axis="1 0 0"/><geom size="0.1" mass="1"/></body>"""
    note = '<text name="simx:joint:rail" data="mode=ik hybrid=on upper_velocity=1"/>'
    source = "function sysCall_init() h = sim.getObjectHandle('rail') sim.setJointTargetPosition(h, 0.04) end"
    world = scripted({"lua:cart": source}, joint, note)
    rail = world.handle("rail")
    world.run(20)
    assert world.call("simxGetJointPosition", rail) == pytest.approx(0.04, abs=1e-3)
    world.call("simxSetJointTargetPosition", rail, -0.02)
    for _ in range(20):
        world.parts.step()
    assert world.call("simxGetJointPosition", rail) == pytest.approx(-0.02, abs=1e-3)


def test_spherical_joint_is_free_in_force_mode_and_stays_in_any_other() -> None:
    pendulum = """<mujoco><option integrator="implicitfast"/><worldbody><body name="b">
      <joint name="socket" type="ball"/><geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.02" mass="1"/></body>
      </worldbody><custom>{}</custom></mujoco>"""
    free_world = world_of(pendulum.format(""))
    free = free_world.simulation
    held_world = world_of(pendulum.format('<text name="simx:joint:socket" data="mode=passive"/>'))
    held = held_world.simulation
    turned = [0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0]
    for world in (free_world, held_world):
        run(world, 3)
    assert free.joints.matrix(1) != pytest.approx([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0], abs=1e-2)
    assert held.joints.matrix(1) == [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]
    held.joints.set_spherical_matrix(1, turned)
    held_world.step()
    assert held.joints.matrix(1) == pytest.approx(turned)
    held.joints.set_mode(1, JointMode.FORCE)
    held_world.step()
    assert held.joints.matrix(1) != pytest.approx(turned, abs=1e-3)


def test_joint_moves_all_below_it_in_the_tree_while_stopped() -> None:
    world = world_of("""<mujoco><worldbody>
      <body name="arm"><joint name="turn" axis="0 0 1"/><geom size="0.1"/></body>
      <body name="cube" pos="1 0 0"><freejoint/><geom size="0.1"/></body></worldbody></mujoco>""")
    sim = world.simulation
    turn, cube = sim.scene.resolve("turn"), sim.scene.resolve("cube")
    editing.set_parent(sim, cube, sim.scene.resolve("arm"), keep_in_place=True)
    sim.joints.set_position(turn, math.pi / 2)
    assert frames.get_position(sim, cube) == pytest.approx([0, 1, 0])
    assert frames.get_position(sim, cube, sim.scene.resolve("arm")) == pytest.approx([1, 0, 0])


@pytest.fixture(scope="module")
def world() -> World:
    return World("""<mujoco><worldbody>
      <body name="wheel"><joint name="axle"/><geom size="0.1"/></body>
      <body name="cart" pos="1 0 0"><joint name="track" type="slide" axis="0 0 1"/><geom size="0.1"/></body>
      <body name="hip" pos="2 0 0"><joint name="socket" type="ball"/><geom size="0.1"/></body>
      </worldbody><custom><text name="simx:joint:track" data="mode=passive hybrid=on"/></custom></mujoco>""")


SINGLE = [
    ("simxGetJointPosition", []),
    ("simxSetJointPosition", [0.1]),
    ("simxSetJointTargetVelocity", [0.1]),
    ("simxSetJointTargetPosition", [0.1]),
    ("simxGetJointForce", []),
    ("simxGetJointMaxForce", []),
    ("simxSetJointForce", [1.0]),
]


@pytest.mark.parametrize(("name", "values"), SINGLE)
def test_commands_of_a_single_value_refuse_spherical_joints_other_objects_and_no_objects(
    world: World, name: str, values: list[float]
) -> None:
    with pytest.raises(CommandError, match="spherical joint, which has no single value"):
        world.call(name, world.handle("socket"), *values)
    with pytest.raises(WrongKind, match="needs a joint"):
        world.call(name, world.handle("wheel"), *values)
    with pytest.raises(UnknownHandle):
        world.call(name, 999, *values)
    world.call(name, world.handle("axle"), *values)


def test_matrix_is_for_all_joints_and_setting_it_for_spherical_ones(world: World) -> None:
    for name in ("axle", "track", "socket"):
        assert len(world.call("simxGetJointMatrix", world.handle(name))) == 12
    quarter = [0.0, -1.0, 0.0, 5.0, 1.0, 0.0, 0.0, 6.0, 0.0, 0.0, 1.0, 7.0]
    world.call("simxSetSphericalJointMatrix", world.handle("socket"), quarter)
    expected = [value if i % 4 < 3 else 0.0 for i, value in enumerate(quarter)]
    assert world.call("simxGetJointMatrix", world.handle("socket")) == pytest.approx(expected)
    with pytest.raises(CommandError, match="not spherical"):
        world.call("simxSetSphericalJointMatrix", world.handle("axle"), quarter)


def test_group_data_says_type_mode_and_hybrid_operation(world: World) -> None:
    handles, ints, floats, _ = world.call("simxGetObjectGroupData", 1, 16)
    rows = {handle: (ints[2 * i : 2 * i + 2], floats[2 * i : 2 * i + 2]) for i, handle in enumerate(handles)}
    assert rows[world.handle("track")] == ([11, 65536], [-1e9, 2e9])
    assert rows[world.handle("axle")] == ([10, 5], [-math.pi, -1.0])
    assert rows[world.handle("socket")] == ([12, 5], [-math.pi, -1.0])


def test_rewound_joint_turns_freely_without_getting_anywhere() -> None:
    world = world_of("""<mujoco><option integrator="implicitfast" gravity="0 0 0"/><worldbody>
      <body name="roller"><joint name="free" axis="0 0 1"/><geom type="sphere" size="0.1"/></body></worldbody>
      <custom><text name="simx:joint:free" data="motor=off rewind=yes"/></custom></mujoco>""")
    sim = world.simulation
    sim.data.qvel[0] = 3.0
    run(world, 5)
    assert sim.joints.position(sim.scene.resolve("free")) == 0.0
    assert sim.data.qvel[0] == pytest.approx(3.0)


PROFILE = "mode=passive upper_velocity=0.4 upper_acceleration=2"


def test_a_target_position_outside_force_mode_starts_a_motion_within_the_limits() -> None:
    """From rest 0.2 s to 0.4 m/s over 0.04 m, then 0.05 s at that velocity, then 0.2 s to rest."""
    world = slider(note=PROFILE, joint='range="-1 1" limited="true"')
    sim = world.simulation
    sim.joints.set_target_position(rail(sim), 0.1)
    assert sim.joints.rule(rail(sim)).name == "PROFILE"
    run(world, 2)
    assert sim.joints.position(rail(sim)) == pytest.approx(0.01, rel=1e-3)
    assert sim.joints.velocity(rail(sim)) == pytest.approx(0.15, rel=1e-3)
    run(world, 3)
    assert sim.joints.position(rail(sim)) == pytest.approx(0.06, rel=1e-3)
    run(world, 6)
    assert sim.joints.position(rail(sim)) == pytest.approx(0.1, abs=1e-9)
    assert sim.joints.velocity(rail(sim)) == pytest.approx(0.0, abs=1e-9)
    sim.joints.set_position(rail(sim), 0.5)
    run(world, 1)
    assert sim.joints.position(rail(sim)) == 0.5


def test_a_target_velocity_outside_force_mode_is_reached_in_time_and_kept_up_to_the_limit() -> None:
    world = slider(note=PROFILE, joint='range="-1 0.2" limited="true"')
    sim = world.simulation
    sim.joints.set_target_velocity(rail(sim), 0.4)
    run(world, 4)
    assert sim.joints.position(rail(sim)) == pytest.approx(0.04, rel=1e-3)
    run(world, 4)
    assert sim.joints.position(rail(sim)) == pytest.approx(0.12, rel=1e-3)
    run(world, 8)
    assert sim.joints.position(rail(sim)) == pytest.approx(0.2)
    sim.joints.set_target_velocity(rail(sim), -0.4)
    run(world, 4)
    assert sim.joints.position(rail(sim)) == pytest.approx(0.16, rel=1e-3)


def test_a_new_target_keeps_the_velocity_of_the_motion() -> None:
    world = slider(note=PROFILE)
    sim = world.simulation
    sim.joints.set_target_velocity(rail(sim), 0.4)
    run(world, 4)
    sim.joints.set_target_position(rail(sim), 1.0)
    run(world, 1)
    assert sim.joints.velocity(rail(sim)) == pytest.approx(0.4, rel=1e-3)


def test_a_stopped_run_forgets_its_motion_and_a_motion_set_before_it_starts_again() -> None:
    world = slider(note=PROFILE)
    sim = world.simulation
    sim.joints.set_target_position(rail(sim), 0.1)
    run(world, 11)
    assert sim.joints.position(rail(sim)) == pytest.approx(0.1)
    sim.stop()
    assert sim.joints.position(rail(sim)) == pytest.approx(0.0)
    run(world, 2)
    assert sim.joints.position(rail(sim)) == pytest.approx(0.01, rel=1e-3)


def test_joints_without_a_greatest_acceleration_say_what_they_lack() -> None:
    sim = slider(note="mode=passive").simulation
    with pytest.raises(CommandError, match="upper_acceleration"):
        sim.joints.set_target_position(rail(sim), 0.1)
    sim.joints.limit_motion(rail(sim), [0.4, 2.0])
    sim.joints.set_target_position(rail(sim), 0.1)
    with pytest.raises(CommandError, match="three finite numbers"):
        sim.joints.limit_motion(rail(sim), [1.0, 1.0, 1.0, 1.0])
