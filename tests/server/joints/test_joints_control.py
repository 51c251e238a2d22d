"""Force mode: springs and dampers, the control mode as one number, forces' signs, velocities as V-REP measures them."""

from __future__ import annotations

import math

import pytest
from scenes_for_tests import run, slider, world_of

from simx_server.errors import CommandError
from simx_server.joints.parameters import get_parameter, set_parameter
from simx_server.scene.formats.annotations import SceneError
from simx_server.simulation.simulation import Simulation

VELOCITY = '<velocity joint="rail" kv="200"/>'


def rail(sim: Simulation) -> int:
    return sim.scene.resolve("rail")


@pytest.mark.parametrize("actuator", ["", VELOCITY, '<motor joint="rail" gear="5"/>'])
def test_spring_and_damper_swings_as_the_textbook_says(actuator: str) -> None:
    """1 kg on 40 N/m with damping 2 N s/m: x = exp(-t) cos(w t) + ..., w = sqrt(39) per second."""
    world = slider(
        actuator=actuator, note="control=spring motor=on K=40 C=2 target_position=0", gravity="0 0 0"
    )
    sim = world.simulation
    sim.joints.set_position(rail(sim), 0.1)
    run(world, 12)
    w, t = math.sqrt(39), 0.6
    expected = 0.1 * math.exp(-t) * (math.cos(w * t) + math.sin(w * t) / w)
    assert sim.joints.position(rail(sim)) == pytest.approx(expected, abs=2e-3)


def test_spring_carries_a_weight_where_hooke_says_and_the_force_read_is_the_reverse() -> None:
    world = slider(actuator=VELOCITY, note="control=spring K=100 C=30")
    sim = world.simulation
    run(world, 60)
    assert sim.joints.position(rail(sim)) == pytest.approx(-0.1, rel=1e-3)
    assert sim.joints.force(rail(sim)) == pytest.approx(-10, rel=1e-3)


def test_spring_constants_change_while_it_carries_and_come_back_at_stop() -> None:
    world = slider(actuator=VELOCITY, note="control=spring K=100 C=30")
    sim = world.simulation
    run(world, 1)
    set_parameter(sim.joints, rail(sim), 2018, 200)
    set_parameter(sim.joints, rail(sim), 2019, 40)
    for _ in range(60):
        world.step()
    assert sim.joints.position(rail(sim)) == pytest.approx(-0.05, rel=1e-3)
    sim.stop()
    assert [get_parameter(sim.joints, rail(sim), number) for number in (2018, 2019)] == [100, 30]


def test_spring_does_not_exceed_the_maximum_force() -> None:
    world = slider(actuator=VELOCITY, note="control=spring K=1000 C=0 max_force=3", gravity="0 0 0")
    sim = world.simulation
    sim.joints.set_target_position(rail(sim), 5)
    run(world, 2)
    assert sim.joints.force(rail(sim)) == pytest.approx(-3)
    assert sim.data.qvel[0] == pytest.approx(3 * 0.1)


def test_a_spring_far_too_stiff_for_what_it_moves_goes_to_its_target_at_the_target_velocity_as_in_vrep() -> (
    None
):
    world = slider(
        actuator=VELOCITY,
        note="control=spring rigid=yes K=1e9 C=0 max_force=1e6 target_velocity=-0.5",
        gravity="0 0 0",
    )
    sim = world.simulation
    sim.joints.set_target_position(rail(sim), 0.12)
    run(world, 2)
    assert sim.joints.position(rail(sim)) == pytest.approx(0.05, abs=1e-3)
    assert sim.data.qvel[0] == pytest.approx(0.5, abs=1e-3)
    for _ in range(8):
        world.step()
        assert sim.joints.position(rail(sim)) < 0.12 + 1e-4
    assert sim.joints.position(rail(sim)) == pytest.approx(0.12, abs=1e-5)


def test_a_too_stiff_spring_exceeds_neither_its_own_force_nor_the_maximum() -> None:
    world = slider(
        actuator=VELOCITY,
        note="control=spring rigid=yes K=1e9 C=0 max_force=3 target_velocity=9 target_position=1",
    )
    sim = world.simulation
    run(world, 1)
    assert sim.joints.force(rail(sim)) == pytest.approx(-3)  # upwards, while the weight of 10 N falls
    assert sim.data.qvel[0] == pytest.approx(-7 * 0.05)


def test_spring_of_a_cyclic_joint_pulls_the_short_way_round() -> None:
    world = slider(
        actuator=VELOCITY, note="control=spring cyclic=yes K=2 C=1", kind="hinge", gravity="0 0 0", offset=0.3
    )
    sim = world.simulation
    sim.joints.set_position(rail(sim), 3.0)
    sim.joints.set_target_position(rail(sim), 3.6)
    assert sim.joints.target_position(rail(sim)) == pytest.approx(3.6 - 2 * math.pi)
    run(world, 60)
    assert sim.data.qpos[0] == pytest.approx(3.6, abs=1e-3)
    sim.joints.set_target_position(rail(sim), 3.0)
    for _ in range(60):
        world.step()
    assert sim.data.qpos[0] == pytest.approx(3.0, abs=1e-3)


def test_a_files_position_actuator_is_a_spring_with_its_gains() -> None:
    world = slider(actuator='<position joint="rail" kp="8" kv="3" gear="5"/>', gravity="0 0 0")
    sim = world.simulation
    assert get_parameter(sim.joints, rail(sim), 2039) == 12
    assert get_parameter(sim.joints, rail(sim), 2018) == 8 * 25
    assert get_parameter(sim.joints, rail(sim), 2019) == 3 * 25
    gain, bias = sim.model.actuator_gainprm.copy(), sim.model.actuator_biasprm.copy()
    sim.joints.set_target_velocity(rail(sim), 0.1)
    assert not (sim.model.actuator_biasprm == bias).all()
    sim.joints.set_target_position(rail(sim), 0.1)
    assert (sim.model.actuator_gainprm == gain).all()
    assert (sim.model.actuator_biasprm == bias).all()
    set_parameter(sim.joints, rail(sim), 2018, 100)
    assert sim.model.actuator_gainprm[0, 0] == 4


def test_control_mode_is_one_number_for_motor_loop_and_spring() -> None:
    world = slider(actuator=VELOCITY, note="control=position")
    sim = world.simulation
    for mode, switches in ((0, (0, 1)), (4, (1, 0)), (12, (1, 1)), (8, (1, 1))):
        set_parameter(sim.joints, rail(sim), 2039, mode)
        assert get_parameter(sim.joints, rail(sim), 2039) == mode
        assert [get_parameter(sim.joints, rail(sim), number) for number in (2000, 2001)] == list(switches)
    with pytest.raises(CommandError, match="4 velocity, 8 position, 12 spring"):
        set_parameter(sim.joints, rail(sim), 2039, 5)


@pytest.mark.parametrize(("direction", "expected"), [(1, -7), (-1, 7)])
def test_force_is_the_reverse_of_the_push_on_the_child(direction: int, expected: float) -> None:
    """A motor that pushes its child towards greater positions reads a negative force; also about a hinge."""
    for kind in ("slide", "hinge"):
        world = slider(
            actuator=VELOCITY, note="control=velocity max_force=7", kind=kind, gravity="0 0 0", offset=0.5
        )
        sim = world.simulation
        sim.joints.set_target_velocity(rail(sim), direction * 1e4)
        run(world, 2)
        assert sim.joints.force(rail(sim)) == pytest.approx(expected)
        assert sim.joints.position(rail(sim)) * direction > 0


def test_torque_by_velocity_and_limit_may_change_every_step() -> None:
    """The velocity alone gives the direction: the limit is a magnitude, whatever its sign."""
    world = slider(actuator=VELOCITY, note="control=velocity", gravity="0 0 0")
    sim = world.simulation
    sim.start()
    speed = 0.0
    for force, direction in ((2.0, 1), (2.0, -1), (-4.0, -1), (0.0, 1), (3.0, 1)):
        sim.joints.set_max_force(rail(sim), force)
        sim.joints.set_target_velocity(rail(sim), direction * 9999.0)
        world.step()
        speed += direction * abs(force) * 0.05
        assert sim.data.qvel[0] == pytest.approx(speed, rel=1e-6, abs=1e-9)
        assert sim.joints.force(rail(sim)) == pytest.approx(-direction * abs(force))


def test_joint_velocity_is_the_difference_of_two_steps() -> None:
    world = slider(note="motor=off")
    sim = world.simulation
    sim.start()
    assert sim.joints.velocity(rail(sim)) == 0
    places = [0.0]
    for _ in range(3):
        world.step()
        places.append(sim.joints.position(rail(sim)))
        measured = get_parameter(sim.joints, rail(sim), 2012)
        assert measured == pytest.approx((places[-1] - places[-2]) / 0.05)
        assert abs(measured) < abs(sim.data.qvel[0])
    sim.stop()
    assert sim.joints.velocity(rail(sim)) == 0


def test_what_is_set_between_two_passes_counts_as_velocity_the_short_way_round() -> None:
    world = slider(note="mode=passive cyclic=yes", kind="hinge", gravity="0 0 0")
    sim = world.simulation
    sim.joints.set_position(rail(sim), 3.1)
    run(world, 1)
    sim.joints.set_position(rail(sim), -3.1)
    assert sim.joints.velocity(rail(sim)) == 0
    world.step()
    assert sim.joints.velocity(rail(sim)) == pytest.approx((2 * math.pi - 6.2) / 0.05)


@pytest.mark.parametrize("driven", [(0, 1, 2), (1, 2), (0, 2), (0,)], ids=str)
def test_controllers_drive_their_own_joints_wherever_these_lie_among_the_others(
    driven: tuple[int, ...],
) -> None:
    """Joints whose loop is on go to their targets, the others as fast as they are told."""
    bodies = "".join(
        f'<body pos="0 {n} 0"><joint name="joint{n}" type="slide" axis="1 0 0"/><geom size="0.1" mass="1"/></body>'
        for n in range(3)
    )
    notes = "".join(
        f'<text name="simx:joint:joint{n}" data="control={"position" if n in driven else "velocity"} motor=on"/>'
        for n in range(3)
    )
    actuators = "".join(f'<velocity joint="joint{n}" kv="500"/>' for n in range(3))
    world = world_of(
        f"<mujoco><option gravity='0 0 0'/><worldbody>{bodies}</worldbody>"
        f"<actuator>{actuators}</actuator><custom>{notes}</custom></mujoco>"
    )
    sim = world.simulation
    handles = [sim.scene.resolve(f"joint{n}") for n in range(3)]
    targets = (0.1, -0.2, 0.3)
    for n, handle in enumerate(handles):
        if n in driven:
            sim.joints.set_target_position(handle, targets[n])
        else:
            sim.joints.set_target_velocity(handle, targets[n])
    run(world, 40)
    expected = [targets[n] * (1 if n in driven else sim.time) for n in range(3)]
    assert [sim.joints.position(handle) for handle in handles] == pytest.approx(expected, abs=3e-3)


def test_position_target_outside_force_mode_is_refused_and_velocity_is_accepted() -> None:
    for mode in ("passive", "ik", "motion", "dependent"):
        world = slider(note=f"mode={mode}")
        sim = world.simulation
        with pytest.raises(CommandError, match=f"{mode} mode, which has no target position"):
            sim.joints.set_target_position(rail(sim), 1)
        sim.joints.set_target_velocity(rail(sim), 1)
        assert sim.joints.target_velocity(rail(sim)) == 1


def test_annotation_names_what_is_valid() -> None:
    with pytest.raises(SceneError, match="position, velocity, spring"):
        slider(note="control=bounce")
    with pytest.raises(SceneError, match=r"offset=, valid for a tendon, or with master="):
        slider(note="offset=0.1")


def test_tendon_outside_force_mode_is_driven_to_where_it_is_set() -> None:
    world = world_of("""
    <mujoco><option gravity="0 0 0"/><worldbody>
      <body name="a"><joint name="j" type="slide" axis="1 0 0"/><geom size="0.02" mass="0.1"/></body></worldbody>
      <tendon><fixed name="line"><joint joint="j" coef="2"/></fixed></tendon>
      <actuator><velocity tendon="line" kv="50"/></actuator>
      <custom><text name="simx:joint:line" data="mode=passive upper_velocity=5 offset=0.5"/></custom></mujoco>""")
    sim = world.simulation
    line = sim.scene.resolve("line")
    run(world, 2)
    assert sim.joints.position(line) == pytest.approx(0.5)
    sim.joints.set_position(line, 0.7)
    for _ in range(20):
        world.step()
    assert sim.joints.position(line) == pytest.approx(0.7, abs=1e-3)
    assert sim.joints.velocity(line) == pytest.approx(0, abs=1e-2)
    with pytest.raises(CommandError, match="holds no parts together"):
        get_parameter(sim.joints, line, 2022)
