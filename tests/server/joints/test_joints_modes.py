"""V-REP's joint modes, each on the smallest scene that shows it."""

from __future__ import annotations

import math

import pytest
from scenes_for_tests import arm, run, slider, world_of

from simx_server.errors import CommandError, UnknownHandle, WrongKind
from simx_server.joints import JointMode
from simx_server.joints.parameters import get_parameter, set_parameter
from simx_server.simulation.simulation import Simulation

VELOCITY = '<velocity joint="rail" kv="200"/>'


def rail(sim: Simulation) -> int:
    return sim.scene.resolve("rail")


def test_position_control_follows_vreps_exponential() -> None:
    """P = 0.1 over 5 ms is 20 / s: after one pass of 50 ms, exp(-1) of the error is left."""
    world = slider(actuator=VELOCITY, note="control=position P=0.1 upper_velocity=1", gravity="0 0 0")
    sim = world.simulation
    sim.joints.set_target_position(rail(sim), 0.01)
    run(world, 1)
    assert sim.joints.position(rail(sim)) == pytest.approx(0.01 * (1 - math.exp(-1)), rel=0.05)
    run(world, 9)
    assert sim.joints.position(rail(sim)) == pytest.approx(0.01, rel=1e-3)


def test_position_control_keeps_to_the_upper_velocity() -> None:
    world = slider(actuator=VELOCITY, note="control=position upper_velocity=0.2", gravity="0 0 0")
    sim = world.simulation
    sim.joints.set_target_position(rail(sim), 5)
    run(world, 10)
    assert sim.joints.velocity(rail(sim)) == pytest.approx(0.2, rel=1e-3)
    assert sim.joints.position(rail(sim)) == pytest.approx(0.1, rel=0.05)


def test_integral_part_removes_the_lag_and_derivative_part_damps() -> None:
    """A target that moves by 10 mm per simulation step is followed with a lag, whose mean an integral removes.

    Within a step the error falls from 1 / (1 - 0.9^10) to 0.5354 times 10 mm, by its mean of 0.9694.
    """
    lags = []
    for i in (0, 0.1):
        world = slider(actuator=VELOCITY, note=f"control=position P=0.1 I={i} D=0.0001 upper_velocity=5")
        sim = world.simulation
        sim.start()
        for number in range(120):
            sim.joints.set_target_position(rail(sim), 0.01 * number)
            world.step()
        lags.append(0.01 * 119 - sim.joints.position(rail(sim)))
    assert lags[0] == pytest.approx(0.01 * 0.5354, rel=0.02)
    assert lags[1] == pytest.approx(0.01 * (0.5354 - 0.9694), rel=0.03)


def test_a_motor_carries_its_load_without_giving_way_and_reports_it() -> None:
    world = slider(actuator=VELOCITY, note="control=position")
    sim = world.simulation
    run(world, 60)
    assert sim.joints.position(rail(sim)) == pytest.approx(0, abs=1e-6)
    assert sim.joints.force(rail(sim)) == pytest.approx(-10, rel=1e-3)


def test_a_servo_of_the_file_stays_as_soft_as_the_file_says() -> None:
    """Weight over kv, as the velocity at which it yields: without annotation, and with rigid=no."""
    for note in (None, "control=velocity motor=on rigid=no"):
        world = slider(actuator=VELOCITY, note=note)
        sim = world.simulation
        run(world, 20)
        assert sim.joints.position(rail(sim)) == pytest.approx(-10 / 200, rel=0.1)


def test_friction_of_the_joint_acts_against_its_motor() -> None:
    world = slider(
        actuator='<motor joint="rail"/>',
        note="control=velocity motor=on",
        gravity="0 0 0",
        joint='frictionloss="3"',
    )
    sim = world.simulation
    for velocity in (0.2, -0.2):
        sim.joints.set_target_velocity(rail(sim), velocity)
        run(world, 5)
        assert sim.joints.velocity(rail(sim)) == pytest.approx(velocity, rel=1e-3)
        assert sim.joints.force(rail(sim)) == pytest.approx(math.copysign(3, -velocity), rel=1e-3)
    sim.joints.set_max_force(rail(sim), 2)
    run(world, 20)
    assert sim.joints.velocity(rail(sim)) == pytest.approx(0, abs=1e-3)


def test_velocity_control_moves_at_the_target_velocity() -> None:
    world = slider(actuator=VELOCITY, note="control=velocity", gravity="0 0 0")
    sim = world.simulation
    sim.joints.set_target_velocity(rail(sim), 0.3)
    run(world, 20)
    assert sim.joints.position(rail(sim)) == pytest.approx(0.3, rel=0.01)


def test_target_position_is_stored_but_does_not_move_a_velocity_controlled_joint() -> None:
    world = slider(actuator=VELOCITY, note="control=velocity", gravity="0 0 0")
    sim = world.simulation
    sim.joints.set_target_position(rail(sim), 1)
    run(world, 10)
    assert sim.joints.position(rail(sim)) == 0
    assert sim.joints.target_position(rail(sim)) == 1


def test_a_target_position_is_stored_and_does_not_move_a_joint_that_holds_its_place() -> None:
    world = slider(actuator=VELOCITY, note="control=velocity lock=on")
    sim = world.simulation
    run(world, 1)
    before = sim.joints.position(rail(sim))
    sim.joints.set_target_position(rail(sim), 0.3)
    run(world, 10)
    assert sim.joints.target_position(rail(sim)) == 0.3
    assert sim.joints.position(rail(sim)) == pytest.approx(before, abs=1e-3)


def test_lock_holds_the_place_where_the_velocity_became_zero() -> None:
    positions = {}
    for lock in ("on", "off"):
        world = slider(actuator=VELOCITY, note=f"control=velocity lock={lock}")
        sim = world.simulation
        sim.joints.set_target_velocity(rail(sim), 0.5)
        run(world, 20)
        sim.joints.set_target_velocity(rail(sim), 0)
        stopped = sim.joints.position(rail(sim))
        sim.joints.set_max_force(rail(sim), 5.0)  # too weak for the weight of 10 N
        run(world, 6)
        sim.joints.set_max_force(rail(sim), 100.0)
        run(world, 100)
        positions[lock] = sim.joints.position(rail(sim)) - stopped
    assert positions["on"] == pytest.approx(0, abs=1e-4)
    assert positions["off"] < -0.02


def test_motor_off_lets_the_joint_fall_and_on_again_compensates_gravity_again() -> None:
    world = slider(actuator=VELOCITY, note="control=velocity motor=on", gravcomp=1)
    sim = world.simulation
    sim.start()
    world.step()
    assert sim.joints.position(rail(sim)) == pytest.approx(0, abs=1e-9)
    set_parameter(sim.joints, rail(sim), 2000, 0)
    for _ in range(4):
        world.step()
    assert sim.joints.position(rail(sim)) == pytest.approx(-0.5 * 10 * 0.2**2, rel=0.02)
    assert sim.joints.force(rail(sim)) == 0
    set_parameter(sim.joints, rail(sim), 2000, 1)
    world.step()
    assert sim.data.qvel[0] == pytest.approx(0, abs=1e-3)


def test_huge_velocity_with_a_force_limit_is_a_force() -> None:
    """How scripts control torque: a velocity that is never reached, and the limit as the torque, new every pass."""
    world = slider(actuator=VELOCITY, note="control=velocity", gravity="0 0 0")
    sim = world.simulation
    sim.start()
    expected = 0.0
    for force in (2.0, -5.0, 1.0):
        sim.joints.set_max_force(rail(sim), force)
        sim.joints.set_target_velocity(rail(sim), math.copysign(1e4, force))
        world.step()
        expected += force * 0.05
        assert sim.data.qvel[0] == pytest.approx(expected, rel=1e-6)
        assert sim.joints.force(rail(sim)) == pytest.approx(-force)


def test_force_is_the_motors_mean_over_the_step() -> None:
    world = slider(actuator=VELOCITY, note="control=position upper_velocity=5")
    sim = world.simulation
    assert sim.joints.force(rail(sim)) == 0
    run(world, 40)
    assert sim.joints.force(rail(sim)) == pytest.approx(-10, rel=1e-3)
    sim.stop()
    assert sim.joints.force(rail(sim)) == 0


def test_passive_joint_stays_where_it_is_set_under_load() -> None:
    world = slider(actuator=VELOCITY, note="mode=passive")
    sim = world.simulation
    run(world, 5)
    assert sim.joints.position(rail(sim)) == 0
    sim.joints.set_position(rail(sim), 0.25)
    run(world, 5)
    assert sim.joints.position(rail(sim)) == 0.25
    with pytest.raises(CommandError, match="passive mode"):
        sim.joints.set_target_position(rail(sim), 1)


def test_leaving_and_entering_force_mode_while_running() -> None:
    world = slider(note="mode=force motor=off")
    sim = world.simulation
    run(world, 4)
    fallen = sim.joints.position(rail(sim))
    assert fallen < -0.1
    sim.joints.set_mode(rail(sim), JointMode.PASSIVE)
    run(world, 4)
    assert sim.joints.position(rail(sim)) == pytest.approx(fallen, abs=1e-12)
    sim.joints.set_mode(rail(sim), JointMode.FORCE)
    run(world, 4)
    assert sim.joints.position(rail(sim)) < fallen - 0.1


def test_joint_without_actuator_and_annotation_is_free_until_a_target_drives_it() -> None:
    world = slider()
    sim = world.simulation
    run(world, 2)
    assert sim.joints.position(rail(sim)) < -0.01
    sim.stop()
    sim.joints.set_target_position(rail(sim), 0.2)
    run(world, 40)
    assert sim.joints.position(rail(sim)) == pytest.approx(0.2, abs=0.01)
    sim.joints.set_target_velocity(rail(sim), 0.1)
    before = sim.joints.position(rail(sim))
    run(world, 20)
    assert sim.joints.position(rail(sim)) - before == pytest.approx(0.1, rel=1e-3)


@pytest.mark.parametrize(
    "actuator",
    [
        '<velocity joint="rail" kv="300"/>',
        '<motor joint="rail" gear="50" ctrlrange="-1 1" ctrllimited="true"/>',
        '<position joint="rail" kp="2000" kv="200"/>',
        '<velocity joint="rail" kv="3" gear="-10"/>',
        '<general joint="rail" dyntype="filter" dynprm="0.1" gainprm="5"/>',
    ],
)
def test_every_native_actuator_obeys_both_kinds_of_target(actuator: str) -> None:
    world = slider(actuator=actuator, gravity="0 0 0")
    sim = world.simulation
    sim.joints.set_target_position(rail(sim), 0.1)
    run(world, 30)
    assert sim.joints.position(rail(sim)) == pytest.approx(0.1, abs=0.002)
    sim.joints.set_target_velocity(rail(sim), -0.2)
    run(world, 20)
    assert sim.joints.position(rail(sim)) == pytest.approx(-0.1, abs=0.02)


def test_native_position_actuator_holds_its_place_from_the_start() -> None:
    world = slider(actuator='<position joint="rail" kp="5000" kv="300"/>', joint='ref="0.3"')
    sim = world.simulation
    assert sim.joints.target_position(rail(sim)) == pytest.approx(0.3)
    run(world, 20)
    assert sim.joints.position(rail(sim)) == pytest.approx(0.3 - 10 / 5000, rel=1e-3)


def test_motors_limit_in_the_file_is_the_first_maximum_force() -> None:
    world = slider(actuator='<motor joint="rail" gear="50" ctrlrange="-1 1" ctrllimited="true"/>')
    sim = world.simulation
    assert sim.joints.max_force(rail(sim)) == 50
    assert (
        slider(actuator='<velocity joint="rail" kv="1" forcerange="-7 7"/>').simulation.joints.max_force(1)
        == 7
    )


def test_untouched_torque_motor_exerts_nothing() -> None:
    world = slider(actuator='<motor joint="rail"/>')
    sim = world.simulation
    run(world, 4)
    assert sim.joints.position(rail(sim)) == pytest.approx(-0.5 * 10 * 0.2**2, rel=0.02)


def test_cyclic_joint_is_reported_within_half_a_turn_and_takes_the_short_way() -> None:
    world = slider(
        actuator=VELOCITY, note="control=position cyclic=yes upper_velocity=50", kind="hinge", gravity="0 0 0"
    )
    sim = world.simulation
    sim.joints.set_position(rail(sim), 3.0)
    sim.joints.set_target_position(rail(sim), -3.0)
    sim.start()
    world.step()
    assert abs(sim.joints.position(rail(sim))) > 3.0
    run(world, 20)
    assert sim.joints.position(rail(sim)) == pytest.approx(-3.0, abs=1e-3)
    assert sim.data.qpos[0] > math.pi
    assert sim.joints.interval(rail(sim)) == (True, -math.pi, 2 * math.pi)
    sim.joints.set_position(rail(sim), 4.0)
    assert sim.joints.position(rail(sim)) == pytest.approx(4.0 - 2 * math.pi)


def test_position_is_clamped_to_the_interval() -> None:
    world = arm()
    sim = world.simulation
    elbow = sim.scene.resolve("elbow")
    assert sim.joints.interval(elbow) == (False, -2.0, 4.0)
    sim.joints.set_position(elbow, 7)
    assert sim.joints.position(elbow) == 2.0
    sim.joints.set_interval(elbow, False, -1, 2)
    sim.joints.set_position(elbow, 7)
    assert sim.joints.position(elbow) == 1.0


def test_parameters_are_read_and_written_by_number() -> None:
    world = slider(actuator=VELOCITY, note="control=velocity")
    sim = world.simulation
    for number, value in (
        (2001, 1),
        (2002, 0.2),
        (2003, 0.01),
        (2004, 0.001),
        (2017, 2.5),
        (2030, 1),
        (2000, 0),
    ):
        set_parameter(sim.joints, rail(sim), number, value)
        assert get_parameter(sim.joints, rail(sim), number) == value
    with pytest.raises(CommandError, match="2002 pid_p"):
        set_parameter(sim.joints, rail(sim), 2012, 1)
    with pytest.raises(CommandError, match="2012 velocity"):
        get_parameter(sim.joints, rail(sim), 99)
    with pytest.raises(CommandError, match="below 0"):
        set_parameter(sim.joints, rail(sim), 2002, -1)


def test_tendon_with_a_servo_is_a_prismatic_joint() -> None:
    world = world_of("""
    <mujoco><option gravity="0 0 0"/><worldbody>
      <body name="left" pos="-0.1 0 0"><joint name="l" type="slide" axis="1 0 0"/><geom size="0.02" mass="0.1"/>
        <site name="sl"/></body>
      <body name="right" pos="0.1 0 0"><joint name="r" type="slide" axis="-1 0 0"/><geom size="0.02" mass="0.1"/>
        <site name="sr"/></body>
      </worldbody>
      <tendon><spatial name="grip"><site site="sl"/><site site="sr"/></spatial></tendon>
      <equality><joint joint1="l" joint2="r"/></equality>
      <actuator><velocity tendon="grip" kv="50" forcerange="-20 20"/></actuator>
      <custom><text name="simx:joint:grip" data="control=velocity lock=on upper_velocity=0.1 offset=-0.2 parent=left"/>
      </custom></mujoco>""")
    sim = world.simulation
    grip = sim.scene.resolve("grip")
    assert sim.joints.joint_type(grip) == 11
    assert sim.scene.get(grip).parent == sim.scene.resolve("left")
    assert sim.joints.position(grip) == pytest.approx(0, abs=1e-12)
    sim.joints.set_target_velocity(grip, -5)  # limited to the upper velocity
    run(world, 10)
    assert sim.joints.position(grip) == pytest.approx(-0.05, rel=0.1)
    sim.joints.set_target_velocity(grip, 0)
    here = sim.joints.position(grip)
    run(world, 20)
    assert sim.joints.position(grip) == pytest.approx(here, abs=2e-3)
    with pytest.raises(CommandError, match="tendon"):
        sim.joints.set_position(grip, 0)


def test_ball_joint_has_a_matrix_but_no_single_value() -> None:
    world = world_of("""<mujoco><worldbody><body name="b"><joint name="socket" type="ball"/><geom size="0.1"/></body>
      </worldbody></mujoco>""")
    sim = world.simulation
    socket = sim.scene.resolve("socket")
    assert sim.joints.joint_type(socket) == 12
    quarter = [0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0]
    sim.joints.set_spherical_matrix(socket, quarter)
    assert sim.joints.matrix(socket) == pytest.approx(quarter)
    for read in (sim.joints.position, sim.joints.force, sim.joints.max_force):
        with pytest.raises(CommandError, match="spherical"):
            read(socket)
    with pytest.raises(CommandError, match="12 finite numbers"):
        sim.joints.set_spherical_matrix(socket, [1, 2])


def test_joint_matrix_turns_about_or_shifts_along_z() -> None:
    world = slider()
    sim = world.simulation
    sim.joints.set_position(1, 0.25)
    assert sim.joints.matrix(1) == pytest.approx([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0.25])
    world = slider(kind="hinge")
    sim = world.simulation
    sim.joints.set_position(1, 0.25)
    c, s = math.cos(0.25), math.sin(0.25)
    assert sim.joints.matrix(1) == pytest.approx([c, -s, 0, 0, s, c, 0, 0, 0, 0, 1, 0])
    with pytest.raises(CommandError, match="not spherical"):
        sim.joints.set_spherical_matrix(1, [0.0] * 12)


def test_wrong_handles_and_numbers_are_refused() -> None:
    world = arm()
    sim = world.simulation
    with pytest.raises(UnknownHandle, match=r"no object with handle 999; handles of this scene are 1\.\."):
        sim.joints.position(999)
    with pytest.raises(WrongKind, match="'cube' is a shape, but this command needs a joint"):
        sim.joints.position(sim.scene.resolve("cube"))
    for call in (sim.joints.set_target_position, sim.joints.set_target_velocity, sim.joints.set_max_force):
        with pytest.raises(CommandError, match="finite"):
            call(sim.scene.resolve("elbow"), math.nan)


def test_force_control_always_acts_with_the_maximum_force() -> None:
    world = slider(actuator=VELOCITY, note="control=force max_force=-3", gravity="0 0 0")
    sim = world.simulation
    mass = float(sim.model.body_subtreemass[sim.model.jnt_bodyid[0]])
    run(world, 10)
    assert sim.joints.velocity(rail(sim)) == pytest.approx(-3 / mass * 0.475, rel=0.02)
    assert sim.joints.force(rail(sim)) == pytest.approx(3)
    set_parameter(sim.joints, rail(sim), 2039, 4)
    run(world, 20)
    assert sim.joints.velocity(rail(sim)) == pytest.approx(0.0, abs=1e-3)
    set_parameter(sim.joints, rail(sim), 2039, 1)
    run(world, 2)
    assert get_parameter(sim.joints, rail(sim), 2039) == 1
    assert sim.joints.velocity(rail(sim)) < -0.01, "its force keeps its direction"
