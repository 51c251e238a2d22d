"""Custom data, forces and the selection, as scripts use them."""

from __future__ import annotations

import pytest
from sim_api_calls import ScriptWorld, world

__all__ = ["world"]


@pytest.fixture(autouse=True)
def _handles(world: ScriptWorld) -> None:
    world.lua(
        "for _, name in ipairs{'robot','mark','hinge','arm','cube','wall'} do _G[name] = sim.getObject(name) end"
    )


def test_custom_data_of_an_object_the_scene_and_the_server(world: ScriptWorld) -> None:
    for where in ("cube", "sim.handle_self", "sim.handle_scene", "sim.handle_app"):
        assert world.value(f"sim.readCustomDataBlock({where}, 'tag')") is None
        assert world.value(f"sim.readCustomDataBlockTags({where})") is None
        world.lua(
            f"sim.writeCustomDataBlock({where}, 'tag', 'a\\0b'); sim.writeCustomDataBlock({where}, 'b', 'x')"
        )
        assert world.value(f"sim.readCustomDataBlock({where}, 'tag')") == "a\0b"
        assert world.value(f"sim.readCustomDataBlockTags({where})") == ["tag", "b"]
        world.lua(f"sim.writeCustomDataBlock({where}, 'tag', '')")
        assert world.value(f"sim.readCustomDataTags({where})") == ["b"]
        world.lua(f"sim.writeCustomDataBlock({where}, '', nil)")
        assert world.value(f"sim.readCustomDataBlockTags({where})") is None
    world.fails("sim.writeCustomDataBlock(999, 'a', 'b')", "no object with handle 999")


def test_later_names_of_custom_data(world: ScriptWorld) -> None:
    world.lua("sim.writeCustomStringData(cube, 's', 'text'); sim.writeCustomBufferData(cube, 'b', '\\1\\2')")
    assert world.value("sim.readCustomStringData(cube, 's')") == "text"
    assert world.value("sim.readCustomBufferData(cube, 'b')") == "\1\2"
    world.lua("sim.writeCustomTableData(cube, 't', {1, 2.5, {3}})")
    assert world.value("sim.readCustomTableData(cube, 't')") == [1, 2.5, [3]]
    assert world.value("sim.readCustomTableData(cube, 'none')") == []


def test_custom_data_outlives_the_run_except_temporary_data(world: ScriptWorld) -> None:
    world.lua("sim.writeCustomDataBlock(cube, 'kept', '1'); sim.writeCustomDataBlock(cube, '@tmpGone', '2')")
    world.call("simxStopSimulation")
    cube = world.handle("cube")
    assert world.sim.custom_data.names(cube) == ["kept"]
    world.call("simxCloseScene")
    world.sim.load(world.scene_file)
    assert world.sim.custom_data.names(world.handle("cube")) == []


def test_a_copy_begins_with_the_originals_data(world: ScriptWorld) -> None:
    world.lua("sim.writeCustomDataBlock(cube, 'tag', '1'); copy = sim.copyPasteObjects({cube}, 0)[1]")
    assert world.value("sim.readCustomDataBlock(copy, 'tag')") == "1"
    world.lua("sim.writeCustomDataBlock(copy, 'tag', '2')")
    assert world.value("sim.readCustomDataBlock(cube, 'tag')") == "1"


def test_persistent_data_and_extension_strings(world: ScriptWorld) -> None:
    world.lua("sim.persistentDataWrite('a', 'one'); sim.persistentDataWrite('b', 'two', 1)")
    assert world.value("sim.persistentDataRead('a')") == "one"
    assert world.value("sim.persistentDataRead('c')") is None
    assert world.value("sim.getPersistentDataTags()") == ["a", "b"]
    assert world.value("sim.readCustomDataBlockTags(sim.handle_app)") is None
    world.lua("sim.setExtensionString(cube, 0, 'mass@mine {1 {2}} size@mine {3}')")
    assert world.value("sim.getExtensionString(cube, 0)") == "mass@mine {1 {2}} size@mine {3}"
    assert world.value("sim.getExtensionString(cube, 0, 'size@mine')") == "3"
    assert world.value("sim.getExtensionString(cube, 0, 'mass@mine')") == "1 {2}"
    assert world.value("sim.getExtensionString(cube, 0, 'other')") is None
    assert world.value("sim.getExtensionString(cube, 1)") is None


def test_a_force_acts_for_one_pass(world: ScriptWorld) -> None:
    world.lua("sim.addForceAndTorque(cube, {0,0,1}); sim.addForceAndTorque(cube, {0,0,1}, nil)")
    world.passes(2)
    speed = world.lua("return sim.getVelocity(cube)")[0][2]
    assert speed == pytest.approx(2 * 0.05 / 0.5, rel=1e-6), "F t / m, and no more in the second pass"
    world.passes()
    assert world.lua("return sim.getVelocity(cube)")[0][2] == pytest.approx(speed, rel=1e-6)


def test_a_force_beside_the_centre_turns(world: ScriptWorld) -> None:
    world.lua("sim.setObjectOrientation(cube, -1, {0, 0, math.pi / 2})")
    world.lua("sim.addForce(cube, {0.1, 0, 0}, {0, 0.01, 0})")  # in the world: at +y, towards -x
    world.passes(2)
    linear, angular = world.lua("return sim.getVelocity(cube)")
    assert linear == pytest.approx([-0.01 * 0.05 / 0.5, 0, 0], abs=1e-5)
    inertia = 0.5 * (0.2**2 + 0.2**2) / 12
    assert angular == pytest.approx([0, 0, 0.1 * 0.01 * 0.05 / inertia], abs=1e-5)


def test_what_was_added_can_be_taken_back(world: ScriptWorld) -> None:
    world.lua("sim.addForceAndTorque(cube, {1,0,0}, {0,0,0.001})")
    world.lua("sim.addForceAndTorque(cube + sim.handleflag_resetforce, {0,1,0})")
    world.passes(2)
    linear, angular = world.lua("return sim.getVelocity(cube)")
    assert linear == pytest.approx([0, 0.1, 0], abs=1e-6)
    assert angular[2] > 0.01
    world.lua("sim.addForceAndTorque(wall, {0,0,1000})")
    world.fails("sim.addForceAndTorque(mark, {0,0,1})", "'mark' is a dummy, but this command needs a shape")
    world.fails("sim.addForce(cube, {0,0}, {0,0,1})", "a position is 3 numbers")


def test_what_the_physics_moves(world: ScriptWorld) -> None:
    found = world.lua(
        "local t = {} for i, h in ipairs{cube, wall, hinge, mark} do t[i] = sim.isDynamicallyEnabled(h) end return t"
    )
    assert found == [[True, False, True, False]]


def test_the_selection_is_that_of_the_clients(world: ScriptWorld) -> None:
    assert world.value("sim.getObjectSelection()") == []
    assert world.value("sim.getObjectLastSelection()") == -1
    world.lua("sim.setObjectSelection({cube, 999, sim.handle_self})")
    cube, robot = world.handle("cube"), world.handle("robot")
    assert world.call("simxGetObjectSelection") == [cube, robot]
    assert world.lua("return sim.getObjectLastSelection(), sim.getObjectSelectionSize()") == [robot, 2]
    world.lua("sim.removeObjectFromSelection({robot}); sim.addObjectToSelection({wall})")
    assert world.value("sim.getObjectSelection()") == [cube, world.handle("wall")]
    world.lua("sim.setObjectSelection({}); sim.addObjectToSelection(sim.handle_chain, arm)")
    assert world.value("sim.getObjectSelection()") == [
        world.handle(name) for name in ("arm", "hinge", "robot")
    ]
    world.lua("sim.removeObjectFromSelection(sim.handle_single, hinge)")
    assert world.handle("hinge") not in world.value("sim.getObjectSelection()")
    world.lua("sim.setObjectSelection(nil); sim.addObjectToSelection(sim.handle_tree, hinge)")
    assert world.value("sim.getObjectSelection()") == [
        world.handle(name) for name in ("hinge", "arm", "tip", "eye")
    ]
    world.lua("sim.addObjectToSelection(sim.handle_all)")
    assert world.value("#sim.getObjectSelection()") == len(world.sim.scene.objects)
    world.lua("sim.removeObjectFromSelection(sim.handle_all)")
    assert world.value("sim.getObjectSelection()") == []
    world.fails("sim.addObjectToSelection(-77)", "-77 says no objects")
