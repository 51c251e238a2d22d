"""Custom data, tubes, forces, inertia and the selection, as scripts use them."""

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


def test_data_with_a_number_in_place_of_a_name(world: ScriptWorld) -> None:
    world.lua("simAddObjectCustomData(cube, 77, 'ab', 2) simAddSceneCustomData(77, 'c', 1)")
    assert world.lua("return simGetObjectCustomData(cube, 77), simGetSceneCustomData(77)") == ["ab", "c"]
    assert world.value("simGetObjectCustomData(cube, 78)") == ""
    assert world.value("sim.readCustomDataBlockTags(cube)") is None


def test_custom_data_outlives_the_run_except_temporary_data(world: ScriptWorld) -> None:
    world.lua("sim.writeCustomDataBlock(cube, 'kept', '1'); sim.writeCustomDataBlock(cube, '@tmpGone', '2')")
    world.call("simxStopSimulation")
    cube = world.handle("cube")
    assert world.parts.custom_data.names(cube) == ["kept"]
    world.call("simxCloseScene")
    world.sim.load(world.scene_file)
    assert world.parts.custom_data.names(world.handle("cube")) == []


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


def test_an_extension_string_belongs_to_an_object_a_part_of_a_shape_or_the_scene(world: ScriptWorld) -> None:
    text = "povray {blur {false} depth {2 {3}}} ignore_collisions"
    assert world.value("sim.getExtensionString(cube, -1, '')") is None
    world.lua(f"sim.setExtensionString(cube, -1, '{text}') tip = sim.getObjectHandle('tip')")
    for no_key in ("", ", nil", ", ''"):
        assert world.value(f"sim.getExtensionString(cube, -1{no_key})") == text
    assert world.value("sim.getExtensionString(cube, -1, 'blur@povray')") == "false"
    assert world.value("sim.getExtensionString(cube, -1, 'depth@povray')") == "2 {3}"
    assert world.value("sim.getExtensionString(cube, -1, 'povray')") == "blur {false} depth {2 {3}}"
    for wrong in ("blur", "lur@povray", "blur@pov", "@", "blur@povray@x"):
        assert world.value(f"sim.getExtensionString(cube, -1, '{wrong}')") is None
    world.lua("sim.setExtensionString(cube, 0, 'a part') sim.setExtensionString(-1, -1, 'the scene')")
    assert world.value("sim.getExtensionString(cube, 0, '')") == "a part"
    assert world.value("sim.getExtensionString(cube, -1, '')") == text
    assert world.value("sim.getExtensionString(-1, -1, '')") == "the scene"
    # Objects other than shapes have no parts: every index means the object.
    world.lua("sim.setExtensionString(tip, -1, 'of a dummy')")
    assert world.value("sim.getExtensionString(tip, 0, '')") == "of a dummy"
    world.fails("sim.getExtensionString(4711, -1, '')", "4711")


def test_referenced_objects_are_remembered(world: ScriptWorld) -> None:
    assert world.value("sim.getReferencedHandles(cube)") == []
    world.lua("sim.setReferencedHandles(cube, {wall, mark})")
    assert world.value("sim.getReferencedHandles(cube)") == [world.handle("wall"), world.handle("mark")]
    world.lua("sim.removeObject(mark)")
    assert world.value("sim.getReferencedHandles(cube)") == [world.handle("wall"), -1]
    world.lua("sim.setReferencedHandles(cube)")
    assert world.value("sim.getReferencedHandles(cube)") == []


def test_configurations_are_taken_and_brought_back(world: ScriptWorld) -> None:
    world.lua("sim.setJointPosition(hinge, 0.5); sim.setJointTargetPosition(hinge, 0.6)")
    world.lua("tree, one = sim.getConfigurationTree(robot), sim.getObjectConfiguration(cube)")
    before = [world.value(f"sim.getObjectPose({name}, -1)") for name in ("robot", "arm", "cube")]
    world.lua("sim.setObjectPosition(robot, -1, {5,5,5}); sim.setJointPosition(hinge, -1)")
    world.lua("sim.setObjectPosition(cube, -1, {9,9,9}); sim.setJointTargetPosition(hinge, 0)")
    world.lua("sim.setConfigurationTree(tree); sim.setObjectConfiguration(one)")
    for name, pose in zip(("robot", "arm", "cube"), before, strict=True):
        assert world.value(f"sim.getObjectPose({name}, -1)") == pytest.approx(pose, abs=1e-9)
    assert world.lua(
        "return sim.getJointPosition(hinge), sim.getJointTargetPosition(hinge)"
    ) == pytest.approx([0.5, 0.6])
    world.fails("sim.setConfigurationTree(sim.packTable({1}))", "these bytes are no configuration")
    world.fails("sim.setConfigurationTree('x')", "this is no packed table")


def test_bits_are_combined(world: ScriptWorld) -> None:
    assert world.lua("return sim.boolAnd32(12, 10), sim.boolOr32(12, 10), sim.boolXor32(12, 10)") == [
        8,
        14,
        6,
    ]
    assert world.lua("return sim.boolAnd16(65551, 3), sim.boolOr16(65536, 1), sim.boolXor16(65537, 3)") == [
        3,
        1,
        2,
    ]


def test_a_force_acts_for_one_step(world: ScriptWorld) -> None:
    world.lua("sim.addForceAndTorque(cube, {0,0,1}); sim.addForceAndTorque(cube, {0,0,1}, nil)")
    world.passes(2)
    speed = world.lua("return sim.getVelocity(cube)")[0][2]
    assert speed == pytest.approx(2 * 0.05 / 0.5, rel=1e-6), "F t / m, and no more in the second pass"
    world.passes()
    assert world.lua("return sim.getVelocity(cube)")[0][2] == pytest.approx(speed, rel=1e-6)


def test_the_velocity_of_physics_is_that_of_the_mass_centre_at_the_end_of_the_step(
    world: ScriptWorld,
) -> None:
    world.lua("sim.setShapeInertia(cube, {0.01,0,0, 0,0.01,0, 0,0,0.01}, {1,0,0,0.1, 0,1,0,0, 0,0,1,0})")
    world.lua("sim.addForceAndTorque(cube, {0,0,1}, {0,0,0.01})")
    world.passes()
    linear, angular = world.lua("return sim.getVelocity(cube)")
    assert linear == pytest.approx([0, 0, 0.05 / 0.5], abs=1e-6), "F t / m, the torque turns about the centre"
    assert angular[2] == pytest.approx(0.05 * 0.01 / 0.01, rel=1e-3)
    measured = world.lua("return sim.getObjectVelocity(cube)")[0]
    assert measured[1] == pytest.approx(-0.1 * angular[2] / 2, rel=0.15), "the mean, of the shape's frame"


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


def test_the_inertia_of_a_shape_is_read_in_its_own_frame_and_in_others(world: ScriptWorld) -> None:
    box = [0.5 * (0.2**2 + 0.2**2) / 12, 0, 0, 0, 0.5 * 0.08 / 12, 0, 0, 0, 0.5 * 0.08 / 12]
    moments, frame = world.lua("return sim.getShapeInertia(cube)")
    assert moments == pytest.approx(box, abs=1e-9)
    assert frame == pytest.approx([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0], abs=1e-9)
    moments, frame = world.lua("return sim.getShapeInertia(arm)")
    assert frame[3] == pytest.approx(0.2), "the arm's geom lies beside its origin"
    mass, moments, centre = world.lua("return sim.getShapeMassAndInertia(cube)")
    assert (mass, centre) == (pytest.approx(0.5), pytest.approx([2, 0, 1], abs=1e-6))
    assert world.lua("return sim.getShapeMassAndInertia(cube, sim.getObjectMatrix(cube, -1))")[
        2
    ] == pytest.approx([0, 0, 0], abs=1e-9)


def test_a_shape_gets_another_inertia_until_the_stop(world: ScriptWorld) -> None:
    wanted = [0.02, 0.001, 0, 0.001, 0.03, 0, 0, 0, 0.04]
    table = "{" + ",".join(map(str, wanted)) + "}"
    world.lua("sim.setObjectOrientation(cube, -1, {0.3, 0.4, 0.5})")
    world.lua(f"sim.setShapeInertia(cube, {table}, {{1,0,0,0.01, 0,1,0,0, 0,0,1,0}})")
    moments, frame = world.lua("return sim.getShapeInertia(cube)")
    assert moments == pytest.approx(wanted, abs=1e-9)
    assert frame == pytest.approx([1, 0, 0, 0.01, 0, 1, 0, 0, 0, 0, 1, 0], abs=1e-9)
    world.lua(f"sim.setShapeMassAndInertia(cube, 2, {table}, {{2, 0.1, 1}})")
    mass, moments, centre = world.lua("return sim.getShapeMassAndInertia(cube)")
    assert (mass, moments) == (pytest.approx(2), pytest.approx(wanted, abs=1e-9))
    assert centre == pytest.approx([2, 0.1, 1], abs=1e-9)
    world.passes(2)
    assert world.value("sim.getObjectPosition(cube, -1)") == pytest.approx([2, 0, 1], abs=1e-6)
    world.fails("sim.setShapeInertia(cube, {1,2}, sim.buildIdentityMatrix())", "9 numbers, not 2")
    world.fails(
        "sim.setShapeInertia(cube, {1,0,0,0,1,0,0,0,9}, sim.buildIdentityMatrix())", "belong to no body"
    )
    world.fails(
        "sim.setShapeInertia(cube, {0,0,0,0,0,0,0,0,0}, sim.buildIdentityMatrix())", "must be above 0"
    )
    world.call("simxStopSimulation")
    assert world.sim.model.body("cube").mass[0] == pytest.approx(0.5)


def test_the_spin_of_a_shape_follows_from_its_new_inertia(world: ScriptWorld) -> None:
    world.lua("sim.setShapeInertia(cube, {0.02,0,0, 0,0.03,0, 0,0,0.04}, sim.buildIdentityMatrix())")
    world.lua("sim.addForceAndTorque(cube, nil, {0, 0, 0.04})")
    world.passes(2)
    assert world.lua("return sim.getVelocity(cube)")[1] == pytest.approx([0, 0, 0.05], abs=1e-6)


def test_a_mass_is_computed_from_a_density(world: ScriptWorld) -> None:
    assert world.value("sim.computeMassAndInertia(cube, 1000)") == 1
    mass, moments, _ = world.lua("return sim.getShapeMassAndInertia(cube)")
    assert mass == pytest.approx(8)
    assert moments[0] == pytest.approx(8 * 0.08 / 12)
    world.fails("sim.computeMassAndInertia(cube, 0)", "a density must be above 0")


def test_a_mass_is_computed_also_where_one_was_set(world: ScriptWorld) -> None:
    away = "{1,0,0,0.05, 0,1,0,0, 0,0,1,0}"
    world.lua(f"sim.setShapeInertia(cube, {{0.02,0,0, 0,0.03,0, 0,0,0.04}}, {away})")
    world.lua("sim.computeMassAndInertia(cube, 1000)")
    assert world.value("sim.getShapeMass(cube)") == pytest.approx(8)
    assert world.sim.model.body("cube").ipos == pytest.approx([0, 0, 0], abs=1e-9)


def test_what_one_end_of_a_tube_writes_the_other_reads(world: ScriptWorld) -> None:
    world.lua("a = sim.tubeOpen(0, 'gyro', 2); sim.tubeWrite(a, '1')")
    assert world.lua("return sim.tubeStatus(a)") == [0, 0, 1]
    world.lua("b = sim.tubeOpen(0, 'gyro', 2, false); other = sim.tubeOpen(1, 'gyro', 1)")
    assert world.lua("return sim.tubeStatus(b)") == [1, 1, 0]
    world.lua("sim.tubeWrite(a, '2'); sim.tubeWrite(a, '3')")
    assert world.lua("return sim.tubeRead(b), sim.tubeRead(b, false)") == ["2", "3"], "the oldest was dropped"
    assert world.value("sim.tubeRead(b)") is None
    world.lua("sim.tubeWrite(b, 'back')")
    assert world.value("sim.tubeRead(a)") == "back"
    world.fails("sim.tubeRead(b, true)", "waits, so it works only in a thread")
    assert world.value("sim.tubeClose(a)") == 1
    assert world.lua("return sim.tubeStatus(b)")[0] == 0
    world.fails("sim.tubeWrite(a, 'x')", "no tube with handle")
    world.fails("sim.tubeOpen(0, 'x', 0)", "a tube keeps 1 to")


def test_a_thread_waits_for_what_comes_through_a_tube(world: ScriptWorld) -> None:
    world.lua(
        "a, b = sim.tubeOpen(0, 't', 1), sim.tubeOpen(0, 't', 1)"
        " thread = coroutine.create(function() got = sim.tubeRead(b, true) end) coroutine.resume(thread)"
    )
    assert world.value("got") is None
    world.lua("sim.tubeWrite(a, 'now'); coroutine.resume(thread)")
    assert world.value("got") == "now"


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
    world.lua("sim.setObjectSel({cube})")
    assert world.lua(
        "return sim.getObjectSel(), sim.isObjectInSelection(cube), sim.isObjectInSelection(wall)"
    ) == [
        [cube],
        True,
        False,
    ]
    world.lua("sim.setObjectSelection(nil); sim.addObjectToSelection(sim.handle_tree, hinge)")
    assert world.value("sim.getObjectSelection()") == [
        world.handle(name) for name in ("hinge", "arm", "tip", "eye")
    ]
    world.lua("sim.addObjectToSelection(sim.handle_all)")
    assert world.value("#sim.getObjectSelection()") == len(world.sim.scene.objects)
    world.lua("sim.removeObjectFromSelection(sim.handle_all)")
    assert world.value("sim.getObjectSelection()") == []
    world.fails("sim.addObjectToSelection(-77)", "-77 says no objects")
