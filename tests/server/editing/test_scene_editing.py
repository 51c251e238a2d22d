"""Other parents and removal, while the physics runs: what moves, what stays, what comes back at stop."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scenes_for_tests import arm, run, world_of

from simx_server.editing.shape_properties import is_static
from simx_server.errors import CommandError, UnknownHandle, UnknownName
from simx_server.scene.editing import editing
from simx_server.scene.poses import frames
from simx_server.simulation.simulation import Simulation
from simx_server.world.world import World

pytestmark = pytest.mark.slow


def at(sim: Simulation, name: str, relative_to: int = -1) -> list[float]:
    return frames.get_position(sim, sim.scene.resolve(name), relative_to)


def attach(sim: Simulation, child: str, parent: str | None, *, keep: bool = True) -> None:
    handle = sim.scene.resolve(parent) if parent is not None else -1
    editing.set_parent(sim, sim.scene.resolve(child), handle, keep)


def turn(world: World, passes: int = 30) -> None:
    sim = world.simulation
    sim.joints.set_target_position(sim.scene.resolve("shoulder"), math.pi / 2)
    run(world, passes)


@pytest.mark.parametrize("child", ["wall", "overview", "sun"])
def test_static_object_moves_with_its_new_parent(child: str) -> None:
    world = arm()
    sim = world.simulation
    run(world, 2)
    sim.model.opt.gravity[2] = -5
    before = at(sim, child)
    attach(sim, child, "lower")
    assert at(sim, child) == pytest.approx(before, abs=1e-9)
    local = at(sim, child, sim.scene.resolve("lower"))
    turn(world)
    assert at(sim, child, sim.scene.resolve("lower")) == pytest.approx(local, abs=1e-9)
    assert at(sim, child) != pytest.approx(before, abs=0.1)
    assert sim.model.opt.gravity[2] == -5
    assert sim.scene.get(sim.scene.resolve(child)).parent == sim.scene.resolve("lower")


def test_not_keeping_the_place_keeps_the_local_numbers() -> None:
    world = arm()
    sim = world.simulation
    attach(sim, "wall", "lower", keep=False)
    assert at(sim, "wall", -11) == pytest.approx([0, -1, 0.5])
    assert at(sim, "wall") == pytest.approx([0.9, -1, 0.7])


def test_running_state_is_carried_over_an_edit() -> None:
    world, twin = arm(), arm()
    for each in (world, twin):
        turn(each, 4)
    attach(world.simulation, "tip", "upper")
    for each in (world, twin):
        each.simulation.joints.set_target_position(each.simulation.scene.resolve("elbow"), 0.4)
        run(each, 4)
    assert np.array_equal(world.simulation.data.qpos, twin.simulation.data.qpos)
    assert np.array_equal(world.simulation.data.qvel, twin.simulation.data.qvel)
    assert world.velocities.measure(world.simulation.scene.resolve("hand")) == twin.velocities.measure(
        twin.simulation.scene.resolve("hand")
    )


def test_free_body_under_a_shape_stays_free_but_is_moved_along_by_set_position() -> None:
    world = arm()
    sim = world.simulation
    run(world, 1)
    model = sim.model
    attach(sim, "cube", "base")
    assert sim.model is model
    assert sim.scene.children(sim.scene.resolve("base"))[-1] == sim.scene.resolve("cube")
    before = at(sim, "cube")
    frames.set_position(sim, sim.scene.resolve("base"), -11, [0.5, 0, 0.4])
    assert at(sim, "cube") == pytest.approx([before[0], before[1], before[2] + 0.3])
    run(world, 10)
    assert at(sim, "cube")[2] == pytest.approx(0.05, abs=1e-3)
    sim.stop()
    assert sim.scene.get(sim.scene.resolve("cube")).parent == -1


def test_free_body_under_a_force_sensor_is_carried_and_let_go_again() -> None:
    world = arm()
    sim = world.simulation
    frames.set_position(sim, sim.scene.resolve("cube"), -1, [1.3, 0, 0.2])
    sim.start()
    attach(sim, "cube", "mount")
    place = at(sim, "cube", sim.scene.resolve("hand"))
    turn(world, 12)
    assert at(sim, "cube", sim.scene.resolve("hand")) == pytest.approx(place, abs=1e-9)
    speed = world.velocities.measure(sim.scene.resolve("cube"))
    before = at(sim, "cube")
    attach(sim, "cube", None)
    assert at(sim, "cube") == pytest.approx(before, abs=1e-12)
    address = int(sim.model.jnt_dofadr[sim.model.body_jntadr[sim.model.body("cube").id]])
    assert sim.data.qvel[address : address + 3] == pytest.approx(speed[0], abs=0.3)
    assert np.linalg.norm(sim.data.qvel[address : address + 3]) > 0.1
    run(world, 20)
    assert at(sim, "cube")[2] == pytest.approx(0.05, abs=1e-3)
    sim.stop()
    assert at(sim, "cube") == pytest.approx([1.3, 0, 0.2])


def test_child_of_a_dummy_follows_when_the_dummy_is_set() -> None:
    world = arm()
    sim = world.simulation
    attach(sim, "wall", "tip")
    before = at(sim, "wall", sim.scene.resolve("tip"))
    frames.set_position(sim, sim.scene.resolve("tip"), -1, [2, 2, 2])
    assert at(sim, "wall", sim.scene.resolve("tip")) == pytest.approx(before)


def test_whole_arm_gets_another_base_with_joints_and_motors() -> None:
    world = arm()
    sim = world.simulation
    turn(world, 5)
    angle = sim.joints.position(sim.scene.resolve("shoulder"))
    attach(sim, "shoulder", "wall")
    assert sim.joints.position(sim.scene.resolve("shoulder")) == angle
    turn(world)
    assert sim.joints.position(sim.scene.resolve("shoulder")) == pytest.approx(math.pi / 2, abs=1e-3)
    hand = at(sim, "hand")
    frames.set_position(sim, sim.scene.resolve("wall"), -11, [0, -2, 0.5])
    assert at(sim, "hand") == pytest.approx([hand[0], hand[1] - 1, hand[2]])


def test_loops_and_parts_of_the_world_are_refused_and_nothing_changes() -> None:
    world = arm()
    sim = world.simulation
    model = sim.model
    with pytest.raises(CommandError, match="'base' cannot get its own child 'hand' as parent"):
        attach(sim, "base", "hand")
    with pytest.raises(CommandError, match="part of the world"):
        attach(sim, "floor", "hand")
    with pytest.raises(UnknownHandle):
        editing.set_parent(sim, 1, 77, True)
    assert sim.model is model


def test_removed_leaf_is_gone_and_comes_back_at_stop() -> None:
    world = arm()
    sim = world.simulation
    handles = list(sim.scene.objects)
    hand, eye = sim.scene.resolve("hand"), sim.scene.resolve("eye")
    run(world, 1)
    editing.remove_object(sim, eye)
    with pytest.raises(UnknownName):
        sim.scene.resolve("eye")
    assert sim.model.ncam == 1
    run(world, 1)
    assert [h for h in handles if h != eye] == list(sim.scene.objects)
    assert sim.scene.resolve("hand") == hand
    new = editing.create_dummy(sim, 0.1)
    assert new == max(handles) + 1
    sim.stop()
    assert list(sim.scene.objects) == handles
    assert sim.model.ncam == 2


def test_removed_link_hands_its_children_to_its_parent_and_they_stay() -> None:
    world = arm()
    sim = world.simulation
    turn(world, 5)
    place = at(sim, "hand")
    upper, elbow, shoulder = (sim.scene.resolve(name) for name in ("upper", "elbow", "shoulder"))
    editing.remove_object(sim, upper)
    assert sim.scene.get(elbow).parent == shoulder
    assert at(sim, "hand") == pytest.approx(place, abs=1e-12)
    turn(world)
    assert sim.joints.position(shoulder) == pytest.approx(math.pi / 2, abs=1e-3)
    editing.create_dummy(sim, 0.1)
    assert upper not in sim.scene.objects


def test_removed_joint_is_rigid_where_it_was() -> None:
    world = arm()
    sim = world.simulation
    sim.joints.set_position(sim.scene.resolve("elbow"), 0.5)
    place = at(sim, "hand")
    editing.remove_object(sim, sim.scene.resolve("elbow"))
    assert at(sim, "hand") == pytest.approx(place, abs=1e-12)
    assert sim.scene.get(sim.scene.resolve("lower")).parent == sim.scene.resolve("upper")
    run(world, 2)
    assert sim.model.nu == 1


def test_model_is_removed_with_all_it_holds() -> None:
    world = world_of("""<mujoco><worldbody><body name="robot"><geom size="0.1"/><body name="a"><joint name="j"/>
        <geom size="0.1"/><site name="s"/></body></body>
        <body name="other" pos="1 0 0"><joint name="k"/><geom size="0.1"/>
        <site name="t"/></body></worldbody>
        <tendon><spatial name="rope"><site site="s"/><site site="t"/></spatial></tendon>
        <equality><joint joint1="j" joint2="k"/></equality><actuator><velocity tendon="rope" kv="1"/><motor joint="j"/>
        </actuator><sensor><jointpos joint="j"/><jointpos joint="k"/></sensor>
        <custom><text name="simx:model:robot" data="base=yes"/></custom></mujoco>""")
    sim = world.simulation
    with pytest.raises(CommandError, match="'other' is no model base"):
        editing.remove_model(sim, sim.scene.resolve("other"))
    run(world, 1)
    editing.remove_model(sim, sim.scene.resolve("robot"))
    run(world, 1)
    assert sorted(item.name for item in sim.scene.objects.values()) == ["k", "other", "t"]
    assert (sim.model.ntendon, sim.model.neq, sim.model.nsensor) == (0, 0, 1)


def test_removing_all_leaves_an_empty_running_scene() -> None:
    world = arm()
    sim = world.simulation
    run(world, 1)
    editing.remove_all(sim)
    assert sim.scene.objects == {}
    run(world, 2)
    sim.stop()
    assert len(sim.scene.objects) == 14


def test_shape_made_static_rides_on_its_parent_and_falls_again_when_made_dynamic() -> None:
    """How scripts grasp without physics: static on, parent = hand; later parent = none, static off."""
    world = arm()
    sim = world.simulation
    frames.set_position(sim, sim.scene.resolve("cube"), -1, [1.3, 0, 0.5])
    sim.start()
    cube, hand = sim.scene.resolve("cube"), sim.scene.resolve("hand")
    mass = float(sim.model.body("cube").mass[0])
    editing.set_static(sim, cube, True)
    run(world, 2)
    assert at(sim, "cube") == pytest.approx([1.3, 0, 0.5])
    attach(sim, "cube", "hand")
    place = at(sim, "cube", hand)
    turn(world, 12)
    assert at(sim, "cube", hand) == pytest.approx(place, abs=1e-9)
    attach(sim, "cube", None)
    editing.set_static(sim, cube, False)
    assert float(sim.model.body("cube").mass[0]) == mass
    run(world, 20)
    assert at(sim, "cube")[2] == pytest.approx(0.05, abs=2e-3)
    sim.stop()
    assert at(sim, "cube") == pytest.approx([1.3, 0, 0.5])


def test_parent_whose_body_hangs_on_the_object_is_refused() -> None:
    world = arm()
    sim = world.simulation
    attach(sim, "wall", "tip")
    editing.set_parent(sim, sim.scene.resolve("tip"), -1, True)
    with pytest.raises(CommandError, match="cannot get"):
        attach(sim, "lower", "lower")


def test_a_link_that_becomes_static_stays_where_it_is_and_swings_when_it_is_dynamic_again() -> None:
    """Physics leaves the joints of a static link where they are, as in V-REP."""
    world = world_of(
        "<mujoco><worldbody><body name='link'><joint name='axis' axis='0 1 0'/>"
        "<geom type='box' size='.1 .02 .02' pos='.1 0 0'/></body></worldbody></mujoco>"
    )
    sim = world.simulation
    link, axis = sim.scene.resolve("link"), sim.scene.resolve("axis")
    sim.start()
    editing.set_static(sim, link, True)
    run(world, 4)
    assert sim.joints.position(axis) == 0.0
    assert is_static(sim, link)
    editing.set_static(sim, link, False)
    assert not is_static(sim, link)
    run(world, 4)
    assert abs(sim.joints.position(axis)) > 0.1
    editing.set_static(sim, link, True)
    sim.stop()
    assert not is_static(sim, link)
