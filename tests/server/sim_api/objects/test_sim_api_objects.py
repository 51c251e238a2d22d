"""Objects as scripts find, name, make, copy, remove and describe them."""

from __future__ import annotations

import pytest
from sim_api_calls import ScriptWorld, world

from simx_server.scene.editing import recompile
from simx_server.scene.geometry.highlights import highlights_of

__all__ = ["world"]

NAMES = ("robot", "mark", "hinge", "arm", "tip", "eye", "cube", "wall", "ray")


@pytest.fixture(autouse=True)
def _handles(world: ScriptWorld) -> None:
    names = ", ".join(map(repr, NAMES))
    world.lua(f"for _, name in ipairs{{{names}}} do _G[name] = sim.getObject(name) end")


def handles(world: ScriptWorld, *names: str) -> list[int]:
    return [world.handle(name) for name in names]


def test_objects_are_found_by_name_path_and_special_handles(world: ScriptWorld) -> None:
    robot, arm = handles(world, "robot", "arm")
    for text in ("robot", "robot#", "/robot", ".", "./"):
        assert world.value(f"sim.getObjectHandle('{text}')") == robot, text
    assert world.value("sim.getObject('./hinge/arm')") == arm
    assert world.value("sim.getObject('./arm')") == arm
    assert world.value("sim.getObjectHandle(sim.handle_self)") == robot
    assert world.value("sim.getObjectAssociatedWithScript(sim.handle_self)") == robot
    assert world.value("sim.getObjectHandle('nothing@silentError')") == -1
    world.fails("sim.getObject('cubes')", r"no object named 'cubes'; did you mean 'cube'")
    world.fails("sim.getObjectAssociatedWithScript(7)", "no script with handle 7")


def test_options_say_which_object_and_whether_a_miss_is_an_error(world: ScriptWorld) -> None:
    cube, copy, tip = handles(world, "cube", "cube#0", "tip")
    assert world.value("sim.getObject('/cube', {index = 1})") == copy
    assert world.value("sim.getObject('/cube', {index = 0})") == cube
    assert world.value("sim.getObject('./tip', {proxy = arm})") == tip
    assert world.value("sim.getObject('./tip', {proxy = cube, noError = true})") == -1
    assert world.value("sim.getObject('nothing', {noError = true})") == -1
    assert world.value("sim.getObjectHandle('/nothing', {noError = true})") == -1
    assert world.value("sim.getObjectFromUid(7, {noError = true})") == -1
    world.fails("sim.getObject('/cube', {index = 'x'})", "the option 'index' must be a number, got 'x'")


def test_copies_are_told_apart_by_their_numbers(world: ScriptWorld) -> None:
    assert world.lua("return sim.getNameSuffix('cube#0')") == [0, "cube"]
    assert world.lua("return sim.getNameSuffix('cube')") == [-1, "cube"]
    assert world.lua("return sim.getNameSuffix('cube#')") == [-1, "cube"]
    assert world.lua("return sim.getNameSuffix(nil)") == [-1]
    copy = world.handle("cube#0")
    world.lua("sim.setNameSuffix(0)")
    assert world.value("sim.getObjectHandle('cube')") == copy
    assert world.lua("return sim.getNameSuffix(nil)") == [0]
    assert world.value("sim.getObjectHandle('cube#')") == world.handle("cube")
    world.lua("sim.setNameSuffix(-1)")
    assert world.value("sim.getObjectHandle('cube')") == world.handle("cube")


def test_names_and_aliases_are_read(world: ScriptWorld) -> None:
    assert world.value("sim.getObjectName(cube)") == "cube"
    copy = world.handle("cube#0")
    assert world.value(f"sim.getObjectName({copy})") == "cube#0"
    assert [world.value(f"sim.getObjectAlias({copy}, {form})") for form in range(-1, 6)] == [
        "cube",
        "cube[1]",
        "/cube[1]",
        "/cube[1]",
        f"cube__{copy}__",
        f"cube__{copy}__",
        "/cube[1]",
    ]
    assert world.value("sim.getObjectAlias(tip)") == "tip"
    assert world.value("sim.getObjectAlias(tip, 1)") == "/tip"
    assert world.value("sim.getObjectAlias(tip, 2)") == "/robot/hinge/arm/tip"
    assert world.value("sim.getObjectAlias(tip, 3)") == "tip"
    assert world.value("sim.getObjectAlias(tip, 5)") == "/robot/ ... /tip"
    world.fails("sim.getObjectAlias(tip, 10)", "form of an alias is -1 to 9")


def test_an_alias_with_its_number_in_braces_finds_the_object(world: ScriptWorld) -> None:
    copy = world.handle("cube#0")
    assert [world.value(f"sim.getObjectAlias({copy}, {form})") for form in range(6, 10)] == ["/cube{1}"] * 4
    assert [world.value(f"sim.getObjectAlias(tip, {form})") for form in range(6, 10)] == [
        "/tip{0}",
        "/robot{0}/tip{0}",
        "/robot{0}/tip{0}",
        "/robot{0}/tip{0}",
    ]
    assert world.value("sim.getObject('/cube{1}')") == copy
    assert world.value("sim.getObject('/robot{0}/tip{0}')") == world.handle("tip")


def test_a_tree_is_visited_from_the_top_or_from_the_leaves(world: ScriptWorld) -> None:
    world.lua(
        "function seen(options, last) local names = {} sim.visitTree(robot, function(h) "
        "names[#names + 1] = sim.getObjectAlias(h) return sim.getObjectAlias(h) ~= last end, options) "
        "return table.concat(names, ' ') end"
    )
    assert world.value("seen()") == "robot mark hinge arm tip eye"
    assert world.value("seen({}, 'hinge')") == "robot mark hinge"
    assert world.value("seen({post = true})") == "mark tip eye arm hinge robot"
    assert world.value("seen({pre = true, post = true}, 'hinge')") == "robot mark mark hinge robot"
    count = "local count = 0 sim.visitTree(sim.handle_scene, function() count = count + 1 end) return count"
    assert world.lua(count) == [len(world.sim.scene.objects)]
    world.fails("sim.visitTree(robot, 'nowhere')", "has no function 'nowhere'")


def test_a_renamed_object_is_found_by_its_new_name_until_the_stop(world: ScriptWorld) -> None:
    cube, hinge = handles(world, "cube", "hinge")
    world.lua("sim.setObjectName(cube, 'Block#3'); sim.setObjectName(hinge, 'Elbow')")
    assert world.value("sim.getObjectName(cube)") == "Block#3"
    assert world.value("sim.getObjectAlias(cube)") == "Block"
    assert world.handle("Block#3") == cube
    world.lua("sim.createDummy(0.1)")  # an edit reads everything anew
    assert handles(world, "Block#3", "Elbow") == [cube, hinge]
    assert world.call("simxGetObjectIntParameter", hinge, 2000 + 1) is not None, "it is still a motor"
    world.lua("sim.setObjectAlias(cube, 'Stone')")
    assert world.value("sim.getObject('/Stone')") == cube
    world.fails("sim.setObjectName(cube, 'wall')", "another object, with handle")
    world.fails("sim.setObjectName(cube, 'a/b')", "no name for an object")
    assert world.lua("sim.setObjectAlias(cube, 'a#0') return sim.getObjectAlias(cube)") == ["a_0"]
    world.call("simxStopSimulation")
    assert handles(world, "cube", "hinge") == [cube, hinge]


def test_kinds_and_handles_are_told(world: ScriptWorld) -> None:
    kinds = [world.value(f"sim.getObjectType({name})") for name in NAMES]
    assert kinds == [0, 4, 1, 0, 4, 9, 0, 0, 5]
    assert world.value("sim.getObjectType(hinge) == sim.object_joint_type") is True
    assert world.lua("return sim.isHandle(cube), sim.isHandle(999), sim.isHandle(sim.handle_self)") == [
        True,
        False,
        True,
    ]
    assert world.lua(
        "return sim.isHandleValid(cube), sim.isHandleValid(999), sim.isHandleValid(cube, sim.appobj_object_type),"
        "sim.isHandleValid(cube, sim.appobj_collection_type)"
    ) == [1, 0, 1, 0]
    world.fails("sim.isHandleValid(cube, 5)", "a kind of handle is -1 or one of")


def test_identifiers_lead_back_to_objects(world: ScriptWorld) -> None:
    uid = world.value("sim.getObjectUid(cube)")
    assert world.value(f"sim.getObjectFromUid({uid})") == world.handle("cube")
    assert world.value("sim.getObjectUniqueIdentifier(cube)") == uid
    every = world.value("sim.getObjectUniqueIdentifier(sim.handle_all)")
    assert len(set(every)) == len(world.sim.scene.objects)
    world.fails("sim.getObjectFromUid(5)", "no object of this scene has the identifier 5")


def test_the_tree_is_walked(world: ScriptWorld) -> None:
    robot, mark, hinge, arm, tip, eye = handles(world, "robot", "mark", "hinge", "arm", "tip", "eye")
    assert world.lua(
        "return sim.getObjectChild(robot, 0), sim.getObjectChild(robot, 1), sim.getObjectChild(robot, 2),"
        "sim.getObjectParent(arm), sim.getObjectParent(robot)"
    ) == [mark, hinge, -1, hinge, -1]
    assert world.value("sim.getObjectsInTree(sim.handle_self)") == [robot, mark, hinge, arm, tip, eye]
    assert world.value("sim.getObjectsInTree(robot, sim.handle_all, 1)") == [mark, hinge, arm, tip, eye]
    assert world.value("sim.getObjectsInTree(robot, sim.handle_all, 3)") == [mark, hinge]
    assert world.value("sim.getObjectsInTree(robot, sim.object_dummy_type, 0)") == [mark, tip]
    assert world.value("#sim.getObjectsInTree(sim.handle_scene)") == len(world.sim.scene.objects)
    assert world.lua(
        "return sim.getObjects(0, sim.object_joint_type), sim.getObjects(1, sim.object_joint_type)"
    ) == [
        hinge,
        -1,
    ]
    count = world.value(
        "(function() local i = 0 while sim.getObjects(i, sim.handle_all) ~= -1 do i = i + 1 end return i end)()"
    )
    assert count == len(world.sim.scene.objects)
    world.lua("sim.setObjectParent(cube, arm, true)")
    assert world.value("sim.getObjectParent(cube)") == arm
    world.fails("sim.getObjectChild(999, 0)", "no object with handle 999")


def test_dummies_are_made_with_short_and_long_colours(world: ScriptWorld) -> None:
    dummy = world.value("sim.createDummy(0.02)")
    assert world.value(f"sim.getObjectType({dummy})") == 4
    assert world.value(f"sim.getObjectFloatParam({dummy}, sim.dummyfloatparam_size)") == pytest.approx(0.02)
    red = world.value("sim.createDummy(0, {1, 0, 0})")
    assert world.value(f"sim.getObjectColor({red}, 0, 0)") == [1, 0, 0]
    long = world.value("sim.createDummy(0, {0,1,0, 0,0,0, 0,0,1, 1,0,0})")
    assert [world.value(f"sim.getObjectColor({long}, 0, {part})") for part in (0, 2, 3)] == [
        [0, 1, 0],
        [0, 0, 1],
        [1, 0, 0],
    ]
    world.fails("sim.createDummy(0.1, {1, 2})", "a colour is 3 or 12 numbers, not 2")


def test_objects_are_copied_and_removed(world: ScriptWorld) -> None:
    count = len(world.sim.scene.objects)
    (copies,) = world.lua("copies = sim.copyPasteObjects({cube, robot}, 1); return copies")
    assert [world.sim.scene.get(handle).name for handle in copies] == ["cube#1", "robot#1"]
    assert len(world.sim.scene.objects) == count + 1 + 6
    assert world.value("sim.removeModel(copies[2])") == 6
    world.lua("sim.removeObject(copies[1])")
    assert len(world.sim.scene.objects) == count
    world.lua("sim.removeObjects({mark, tip})")
    assert world.lua("return sim.isHandle(mark), sim.isHandle(tip), sim.isHandle(arm)") == [
        False,
        False,
        True,
    ]
    world.fails("sim.removeModel(cube)", "'cube' is no model base")
    world.call("simxStopSimulation")
    assert len(world.sim.scene.objects) == count


def test_only_the_first_option_copies_whole_models(world: ScriptWorld) -> None:
    count = len(world.sim.scene.objects)
    (alone,) = world.value("sim.copyPasteObjects({robot}, 0)")
    assert len(world.sim.scene.objects) == count + 1
    assert world.sim.scene.children(alone) == []
    pair = world.value("sim.copyPasteObjects({arm, tip}, 0)")
    assert [world.sim.scene.get(handle).parent for handle in pair] == [-1, pair[0]]
    world.lua("sim.setObjectSel({cube}); sim.copyPasteSelectedObjects()")
    (copy,) = world.value("sim.getObjectSel()")
    assert world.sim.scene.get(copy).name.startswith("cube#")


def test_copies_leave_out_what_the_options_say(world: ScriptWorld) -> None:
    world.lua(
        "sim.setReferencedHandles(robot, {tip, cube}); sim.setReferencedHandles(robot, {cube}, 'other')\n"
        "sim.writeCustomDataBlock(robot, 'tag', '1')"
    )
    assert world.value("sim.getReferencedHandlesTags(robot)") == ["", "other"]
    (whole,) = world.value("sim.copyPasteObjects({robot}, 1)")
    tip = world.value("sim.getObject('/robot[1]/tip')")
    assert world.value(f"sim.getReferencedHandles({whole})") == [tip, world.handle("cube")]
    assert world.value(f"sim.getReferencedHandles({whole}, 'other')") == [world.handle("cube")]
    assert world.value(f"sim.readCustomDataBlock({whole}, 'tag')") == "1"
    (bare,) = world.value("sim.copyPasteObjects({robot}, 1 + 4 + 8)")
    assert world.value(f"sim.getReferencedHandles({bare})") == []
    assert world.value(f"sim.readCustomDataBlock({bare}, 'tag')") is None


def test_a_model_that_is_loaded_keeps_the_colours_of_its_highlights(world: ScriptWorld, tmp_path) -> None:
    (tmp_path / "gold.xml").write_text(
        """<mujoco model="gold"><asset><material name="gold" specular="0.5"/></asset>
        <worldbody><body name="coin"><geom name="coin" size="0.1" material="gold"/></body></worldbody>
        <custom><numeric name="simx:specular:gold" data="0.8 0.6 0.1"/></custom></mujoco>"""
    )
    coin = world.value("sim.loadModel('gold.xml')")
    model = world.sim.model
    geom = next(g for g in range(model.ngeom) if model.geom(g).name.endswith("coin"))
    assert highlights_of(model)[int(model.geom_matid[geom])] == pytest.approx([0.8, 0.6, 0.1])
    assert world.value(f"{{sim.getShapeColor({coin}, nil, 2)}}")[1] == pytest.approx([0.8, 0.6, 0.1])


def test_a_model_is_loaded_and_selected(world: ScriptWorld, tmp_path) -> None:
    (tmp_path / "ball.xml").write_text(
        "<mujoco model='ball'><worldbody><body name='ball'><freejoint/><geom size='0.1'/></body></worldbody></mujoco>"
    )
    ball = world.value("sim.loadModel('ball.xml')")
    assert world.sim.scene.get(ball).name == "ball"
    assert world.value("sim.getObjectSelection()") == [ball]
    assert world.value("sim.loadModel('ball.ttm')") != ball
    world.fails("sim.loadModel('/etc/passwd.xml')", "no scene|no model|outside")


def test_model_properties(world: ScriptWorld) -> None:
    assert world.value("sim.getModelProperty(robot)") == 0
    assert world.value("sim.getModelProperty(cube)") == world.value("sim.modelproperty_not_model")
    world.lua("sim.setModelProperty(cube, sim.modelproperty_not_collidable)")
    assert world.value("sim.getModelProperty(cube)") == 1


def test_numbered_parameters_by_new_and_old_names(world: ScriptWorld) -> None:
    assert world.lua("return sim.getObjectFloatParam(cube, sim.objfloatparam_objbbox_max_x)") == [
        pytest.approx(0.1)
    ]
    assert world.lua("return sim.getObjectFloatParameter(cube, sim.objfloatparam_objbbox_max_x)") == [
        1,
        pytest.approx(0.1),
    ]
    assert world.lua("return sim.getObjectInt32Param(wall, sim.shapeintparam_static)") == [1]
    assert world.lua("return sim.getObjectInt32Parameter(cube, sim.shapeintparam_static)") == [1, 0]
    assert world.lua("return sim.getObjectIntParameter(cube, sim.shapeintparam_static)") == [1, 0]
    assert world.lua("return sim.getObjectBoolParam(cube, sim.shapeintparam_static)") == [False]
    world.lua("sim.setObjectFloatParam(eye, sim.visionfloatparam_far_clipping, 7)")
    assert world.value("sim.getObjectFloatParam(eye, sim.visionfloatparam_far_clipping)") == 7
    assert world.value("sim.setObjectFloatParameter(eye, sim.visionfloatparam_far_clipping, 8)") == 1
    assert world.value("sim.getObjectFloatParam(eye, sim.visionfloatparam_far_clipping)") == 8
    world.lua("sim.setObjectInt32Param(cube, sim.objintparam_visibility_layer, 4)")
    assert world.value("sim.setObjectInt32Parameter(cube, sim.objintparam_visibility_layer, 6)") == 1
    assert world.value("sim.setObjectIntParameter(cube, sim.objintparam_visibility_layer, 5)") == 1
    assert world.value("sim.getObjectInt32Param(cube, sim.objintparam_visibility_layer)") == 5
    world.lua("sim.setObjectBoolParam(cube, sim.shapeintparam_respondable, false)")
    assert world.value("sim.getObjectInt32Param(cube, sim.shapeintparam_respondable)") == 0


def test_a_parameter_that_an_object_does_not_have_is_nil_and_not_set(world: ScriptWorld) -> None:
    assert world.lua("return sim.getObjectInt32Param(mark, sim.shapeintparam_static)") in ([], [None])
    assert world.lua("return sim.getObjectInt32Parameter(mark, sim.shapeintparam_static)")[0] == 0
    assert world.lua("return sim.getObjectFloatParameter(mark, sim.visionfloatparam_far_clipping)")[0] == 0
    assert world.lua("return sim.getObjectInt32Param(mark, 98765)") in ([], [None])
    world.goes_on(
        "sim.setObjectInt32Param(mark, 98765, 1)", "parameter 98765 of 'mark', a dummy, cannot be set", 0
    )
    for name in ("Param", "Parameter"):
        assert world.lua(f"return sim.getObjectString{name}(mark, 1)") in ([], [None])
        world.goes_on(f"sim.setObjectString{name}(mark, 1, 'x')", "have no parameters here that are text", 0)


def test_special_properties_decide_what_collisions_and_sensors_find(world: ScriptWorld) -> None:
    every = world.value(
        "sim.objectspecialproperty_collidable + sim.objectspecialproperty_measurable"
        "+ sim.objectspecialproperty_detectable_all + sim.objectspecialproperty_renderable"
    )
    assert world.value("sim.getObjectSpecialProperty(cube)") == every
    assert world.value("sim.getObjectSpecialProperty(mark)") == 2
    assert world.value("sim.getObjectSpecialProperty(hinge)") == 0
    world.lua("sim.setObjectPosition(cube, ray, {0, 0, 0.5})")
    world.passes()
    assert world.value("sim.readProximitySensor(ray)") == 1
    world.lua(f"sim.setObjectSpecialProperty(cube, {every - 0x1F0}); sim.createDummy(0.1)")
    world.passes()
    assert world.value("sim.getObjectSpecialProperty(cube)") == every - 0x1F0
    detected = world.lua("return sim.readProximitySensor(ray)")
    assert detected[0] == 0 or detected[3] != world.handle("cube")
    world.lua("sim.setObjectSpecialProperty(cube, 0)")
    assert world.value("sim.getObjectSpecialProperty(cube)") == 0
    geom = int(world.sim.model.body("cube").geomadr[0])
    assert world.sim.model.geom_group[geom] == 6, "a group that no sensor's image shows"
    world.lua(f"sim.setObjectSpecialProperty(cube, {every})")
    assert world.value("sim.getObjectSpecialProperty(cube)") == every
    assert world.sim.model.geom_group[geom] == 0
    world.lua("sim.setObjectSpecialProperty(cube, 0)")
    world.call("simxStopSimulation")
    assert not world.sim.scene.get(world.handle("cube")).annotations
    assert world.sim.model.geom_group[geom] == 0


def test_kinds_of_sensors_that_detect_a_shape_are_separate_properties(world: ScriptWorld) -> None:
    laser = "sim.objectspecialproperty_detectable_laser"
    world.lua(f"sim.setObjectSpecialProperty(cube, {laser}); sim.createDummy(0.1)")
    assert world.value(f"sim.getObjectSpecialProperty(cube) == {laser}")
    assert world.sim.scene.get(world.handle("cube")).annotations["shape"]["detectable"] == "laser"
    every = world.value("sim.objectspecialproperty_detectable_all")
    world.lua(f"sim.setObjectSpecialProperty(cube, {every})")
    assert world.value("sim.getObjectSpecialProperty(cube)") == every


def test_properties_for_whoever_shows_the_scene_are_kept(world: ScriptWorld) -> None:
    assert world.value("sim.getObjectProperty(cube) == sim.objectproperty_selectable") is True
    world.lua("sim.setObjectProperty(cube, sim.objectproperty_collapsed)")
    assert world.value("sim.getObjectProperty(cube) == sim.objectproperty_collapsed") is True
    world.fails("sim.setObjectProperty(999, 0)", "no object with handle 999")


def test_the_type_of_a_link_decides_whether_physics_holds_its_dummies(world: ScriptWorld) -> None:
    """On a cube that a force pushes: it drifts away, unless its dummy is held by the wall's."""
    world.lua(
        "one, other = sim.createDummy(0.01), sim.createDummy(0.01)\n"
        "sim.setObjectPosition(one, -1, {2, 0, 1}) sim.setObjectPosition(other, -1, {2, 0, 1})\n"
        "sim.setObjectParent(one, cube, true) sim.setObjectParent(other, wall, true)\n"
        "sim.setLinkDummy(one, other)"
    )
    loop = world.value("sim.dummy_linktype_dynamics_loop_closure")
    free = world.value("sim.dummy_linktype_ik_tip_target")
    drifted: list[float] = []
    for link_type in (loop, free):
        assert world.value(f"sim.setDummyLinkType(one, {link_type})") == 1
        assert world.lua("return sim.getDummyLinkType(one)") == [link_type, world.value("other")]
        for _ in range(5):
            world.lua("sim.addForceAndTorque(cube, {2, 0, 0}, {0, 0, 0})")
            world.passes()
        drifted.append(world.value("sim.getObjectPosition(cube, -1)")[0] - 2)
    assert drifted[0] == pytest.approx(0, abs=0.01)
    assert drifted[1] > 0.05


def test_a_burst_of_a_scripts_edits_is_one_compile(
    world: ScriptWorld, monkeypatch: pytest.MonkeyPatch
) -> None:
    compiled: list[int] = []
    compile_spec = recompile.compile_spec
    monkeypatch.setattr(recompile, "compile_spec", lambda *given: compiled.append(1) or compile_spec(*given))
    made = world.lua("""
        local handles = {}
        for i = 1, 20 do handles[i] = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {0.1, 0.1, 0.1}, 0) end
        return handles
    """)[0]
    assert len(set(made)) == 20
    assert not compiled, "no call compiles what others have made"
    assert world.lua(f"return sim.getObjectPosition({made[7]}, -1)")
    assert len(compiled) == 1
