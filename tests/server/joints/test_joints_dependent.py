"""Joints that follow a master: where they are set, under physics, in chains, and by their numbers."""

from __future__ import annotations

import math
from typing import Any

import pytest
from scenes_for_tests import run, world_of

from simx_server.errors import CommandError
from simx_server.joints.parameters import get_parameter, set_parameter
from simx_server.scene.editing import editing
from simx_server.scene.formats.annotations import SceneError
from simx_server.simulation.simulation import Simulation
from simx_server.world.world import World

SCENE = """
<mujoco>
  <option timestep="0.002" integrator="implicitfast" gravity="0 0 -10"/>
  <worldbody>
    <body name="A"><joint name="a" axis="0 1 0" {master}/>
      <geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.02" mass="1"/></body>
    <body name="B" pos="0 1 0"><joint name="b" axis="0 1 0" ref="{ref}" {slave}/>
      <geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.02" mass="1"/></body>
    <body name="C" pos="0 2 0"><joint name="c" type="slide" axis="0 0 1"/><geom size="0.05" mass="0.1"/></body>
  </worldbody>
  <custom>{notes}</custom>
</mujoco>
"""
FREE = "mode=force motor=off"
B_FOLLOWS = "mode=dependent master=a multiplication=-2 offset=0.1"


def scene(ref: float = 0, master: str = "", slave: str = "", **notes: str) -> World:
    texts = "".join(f'<text name="simx:joint:{name}" data="{note}"/>' for name, note in notes.items())
    return world_of(SCENE.format(notes=texts, ref=ref, master=master, slave=slave))


def at(sim: Simulation, name: str) -> float:
    return sim.joints.position(sim.scene.resolve(name))


def put(sim: Simulation, name: str, value: float) -> None:
    sim.joints.set_position(sim.scene.resolve(name), value)


def test_dependent_joint_follows_at_once_and_cannot_be_set_itself() -> None:
    world = scene(a="mode=passive", b=B_FOLLOWS)
    sim = world.simulation
    assert at(sim, "b") == pytest.approx(0.1)
    put(sim, "a", 0.5)
    assert at(sim, "b") == pytest.approx(-0.9)
    put(sim, "b", 0.3)
    assert at(sim, "b") == pytest.approx(-0.9)
    run(world, 2)
    put(sim, "a", -0.2)
    assert at(sim, "b") == pytest.approx(0.5)
    world.step()
    assert at(sim, "b") == pytest.approx(0.5)


@pytest.mark.parametrize("ref", [0.0, 30.0])
def test_coupled_joints_swing_together_and_the_load_is_felt_by_the_master(ref: float) -> None:
    world = scene(ref=ref, a=FREE, b=B_FOLLOWS)
    sim = world.simulation
    run(world, 1)
    for _ in range(15):
        world.step()
        assert at(sim, "b") == pytest.approx(0.1 - 2 * at(sim, "a"), abs=1e-12)
    alone_world = scene(a=FREE, b="mode=passive")
    alone = alone_world.simulation
    run(alone_world, 16)
    # Alone the master falls; the coupled weight of the other arm, felt twice, lifts it.
    assert at(alone, "a") > 0.1
    assert at(sim, "a") < -0.1


def test_motor_of_the_master_moves_both() -> None:
    world = scene(a="motor=on control=position target_position=0.4", b="mode=dependent master=a offset=1")
    sim = world.simulation
    run(world, 30)
    assert at(sim, "a") == pytest.approx(0.4, abs=0.02)
    assert at(sim, "b") == pytest.approx(1 + at(sim, "a"), abs=1e-12)
    assert sim.joints.force(sim.scene.resolve("b")) == 0


def test_chain_of_masters_and_another_kind_of_joint() -> None:
    world = scene(a="mode=passive", b=B_FOLLOWS, c="mode=dependent master=b multiplication=0.5 offset=-1")
    sim = world.simulation
    put(sim, "a", 0.3)
    assert at(sim, "b") == pytest.approx(-0.5)
    assert at(sim, "c") == pytest.approx(-1.25)
    run(world, 2)
    assert at(sim, "c") == pytest.approx(-1.25)


def test_dependent_joint_stops_at_its_own_limits() -> None:
    world = scene(slave='range="-20 20" limited="true"', a="mode=passive", b="mode=dependent master=a")
    sim = world.simulation
    put(sim, "a", 2.0)
    assert at(sim, "b") == pytest.approx(math.radians(20))


def test_dependency_is_read_and_changed_by_number_and_comes_back_at_stop() -> None:
    world = scene(a="mode=passive", b=B_FOLLOWS, c="mode=passive")
    sim = world.simulation
    a, b, c = (sim.scene.resolve(name) for name in "abc")
    assert [get_parameter(sim.joints, b, n) for n in (2031, 2032, 2033)] == [a, -2, 0.1]
    put(sim, "a", 0.2)
    put(sim, "c", 0.7)
    sim.start()
    set_parameter(sim.joints, b, 2032, 3)
    assert at(sim, "b") == pytest.approx(0.7)
    set_parameter(sim.joints, b, 2033, 0)
    assert at(sim, "b") == pytest.approx(0.6)
    set_parameter(sim.joints, b, 2031, c)
    assert at(sim, "b") == pytest.approx(2.1)
    for _ in range(3):
        world.step()
    assert at(sim, "b") == pytest.approx(2.1)
    set_parameter(sim.joints, b, 2031, -1)
    put(sim, "b", 0.05)
    world.step()
    assert at(sim, "b") == pytest.approx(0.05)
    sim.stop()
    assert at(sim, "b") == pytest.approx(-0.3)
    put(sim, "a", 0)
    assert at(sim, "b") == pytest.approx(0.1)


def test_circles_and_other_modes_are_refused() -> None:
    world = scene(a="mode=dependent", b=B_FOLLOWS, c="mode=passive")
    sim = world.simulation
    a, b, c = (sim.scene.resolve(name) for name in "abc")
    with pytest.raises(CommandError, match="cannot follow a joint that follows 'a' itself"):
        set_parameter(sim.joints, a, 2031, b)
    with pytest.raises(CommandError, match="annotated mode=dependent"):
        set_parameter(sim.joints, c, 2032, 1)
    assert get_parameter(sim.joints, c, 2031) == -1


@pytest.mark.parametrize(
    ("notes", "text"),
    [
        ({"b": "mode=dependent master=A"}, "master=A, which is no hinge or slide joint"),
        ({"b": "master=a"}, "valid for a hinge or slide joint with mode=dependent"),
        ({"b": "mode=dependent multiplication=2"}, "multiplication= without master="),
        ({"a": "mode=dependent master=b", "b": "mode=dependent master=a"}, "follows 'a' itself"),
    ],
)
def test_wrong_dependency_in_a_file_is_named(notes: dict[str, Any], text: str) -> None:
    with pytest.raises(SceneError, match=text):
        scene(**notes)


def test_dependency_survives_an_edit_and_the_loss_of_its_master() -> None:
    world = scene(a="mode=passive", b=B_FOLLOWS)
    sim = world.simulation
    sim.start()
    put(sim, "a", 0.5)
    editing.create_dummy(sim, 0.1)
    world.step()
    assert at(sim, "b") == pytest.approx(-0.9)
    editing.remove_object(sim, sim.scene.resolve("a"))
    put(sim, "b", 0.25)
    world.step()
    assert at(sim, "b") == pytest.approx(0.25)
    sim.stop()
    put(sim, "a", 0.1)
    assert at(sim, "b") == pytest.approx(-0.1)


def test_hybrid_dependent_joint_is_driven_by_its_motor_within_its_force() -> None:
    world = scene(a="mode=passive", b=B_FOLLOWS + " hybrid=on upper_velocity=10 max_force=30")
    sim = world.simulation
    run(world, 1)
    put(sim, "a", 0.3)
    assert at(sim, "b") != pytest.approx(-0.5, abs=0.1)
    for _ in range(20):
        world.step()
    assert at(sim, "b") == pytest.approx(-0.5, abs=0.02)
    assert sim.joints.force(sim.scene.resolve("b")) != 0
