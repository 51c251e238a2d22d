"""Colours of shapes by component, by name, of several parts, and what the pictures show of them."""

from __future__ import annotations

from pathlib import Path

import pytest
from sim_api_calls import ScriptWorld

from simx_server.scene.geometry.highlights import highlights_of

SCENE = """
<mujoco>
  <asset>
    <material name="paint" rgba="0 0 1 0.5"/>
    <material name="BLUE_PART" rgba="0 0 1 1"/>
    <material name="BLUE_PART_1" rgba="0 0 0.5 1"/>
    <material name="LED" rgba="0.2 0 0 1"/>
  </asset>
  <worldbody>
    <body name="floor"><geom type="box" size="9 9 0.1" pos="0 0 -0.1" rgba="1 0 0 1"/></body>
    <body name="painted" pos="0 5 1"><geom size="0.1" material="paint"/></body>
    <body name="robot" pos="0 6 1">
      <geom size="0.1" group="3" rgba="0.1 0.1 0.1 1"/>
      <geom size="0.1" material="BLUE_PART"/><geom size="0.1" material="BLUE_PART_1"/>
      <geom size="0.1" material="LED"/><geom size="0.1"/>
    </body>
    <body name="other" pos="0 7 1"><geom size="0.1" material="LED"/></body>
  </worldbody>
  <custom><text name="simx:collection:both" data="objects=other,painted"/></custom>
</mujoco>
"""

H = "local h = sim.getObjectHandle\n"


@pytest.fixture
def world(tmp_path: Path) -> ScriptWorld:
    return ScriptWorld(tmp_path, SCENE, owner="floor")


def color(world: ScriptWorld, shape: str, name: str = "nil", component: int = 0) -> list[float] | None:
    done, *found = world.lua(f"return sim.getShapeColor(sim.getObjectHandle('{shape}'), {name}, {component})")
    return found[0] if done else None


def paint(world: ScriptWorld, shape: str, values: str, name: str = "nil", component: int = 0) -> int:
    return world.value(
        f"sim.setShapeColor(sim.getObjectHandle('{shape}'), {name}, {component}, {{{values}}})"
    )


def test_the_colour_of_a_shape_is_read_and_set(world: ScriptWorld) -> None:
    assert color(world, "floor") == [1, 0, 0]
    assert color(world, "painted") == [0, 0, 1]
    assert color(world, "painted", "''", 4) == [0.5] * 3
    assert paint(world, "painted", "0, 1, 0.5") == 1
    assert color(world, "painted") == [0, 1, 0.5]
    assert color(world, "painted", component=4) == [0.5] * 3
    assert paint(world, "painted", "0.25", component=4) == 1
    assert color(world, "painted", component=4) == [0.25] * 3
    world.call("simxStopSimulation")
    assert world.sim.model.geom_rgba[0].tolist() == [1, 0, 0, 1]


def test_the_later_form_of_the_functions(world: ScriptWorld) -> None:
    assert world.lua(H + "return sim.getObjectColor(h'floor', 0, 0)") == [[1, 0, 0]]
    assert world.lua(H + "return sim.setObjectColor(h'floor', 0, 0, {0, 0, 1})") == [True]
    assert color(world, "floor") == [0, 0, 1]


def test_colours_of_objects_without_a_surface_are_kept(world: ScriptWorld) -> None:
    joint = "local j = sim.createJoint(sim.joint_revolute_subtype, sim.jointmode_passive, 0) "
    found = world.lua(
        joint
        + """
    local before = sim.getObjectColor(j, 0, sim.colorcomponent_diffuse)
    sim.setObjectColor(j, 0, sim.colorcomponent_diffuse, {1, 0.25, 3})
    sim.setObjectColor(j, 1, sim.colorcomponent_emission, {0, 1, 0})
    local copy = sim.copyPasteObjects({j}, 0)[1]
    return before, sim.getObjectColor(copy, 0, sim.colorcomponent_diffuse),
        sim.getObjectColor(copy, 1, sim.colorcomponent_emission), sim.getObjectColor(copy, 1, 0)
    """
    )
    assert found == [[0.5] * 3, [1, 0.25, 1], [0, 1, 0], [0.5] * 3]
    world.fails(joint + "sim.setObjectColor(j, 0, 0, {1})", "a colour is")
    world.fails(joint + "sim.setObjectColor(j, 0, 9, {1, 1, 1})", "component is 0 to 4")


def test_a_colour_name_selects_the_parts_that_have_it(world: ScriptWorld) -> None:
    assert color(world, "robot", "'BLUE PART'") == [0, 0, 1]
    assert paint(world, "robot", "0, 1, 0", "'BLUE PART'") == 1
    assert world.sim.model.geom_rgba[3:7, :3].tolist() == [
        [0, 1, 0],
        [0, 1, 0],
        [0.5, 0.5, 0.5],
        [0.5, 0.5, 0.5],
    ]
    assert color(world, "robot", "'LED'") == pytest.approx([0.2, 0, 0])
    assert color(world, "other", "'LED'") == pytest.approx([0.2, 0, 0])


def test_a_colour_name_that_no_part_has_changes_nothing(world: ScriptWorld) -> None:
    before = world.sim.model.geom_rgba.copy()
    assert paint(world, "robot", "0, 1, 0", "'BLUE'") == 0
    assert color(world, "robot", "'BLUE'") is None
    assert paint(world, "floor", "0, 1, 0", "'LED'") == 0
    assert (world.sim.model.geom_rgba == before).all()


@pytest.mark.parametrize("name", ["nil", "''", "'@compound'"])
def test_without_a_name_all_drawn_parts_change(world: ScriptWorld, name: str) -> None:
    assert paint(world, "robot", "0, 1, 0", name) == 1
    assert (world.sim.model.geom_rgba[3:7, :3] == [0, 1, 0]).all()
    assert world.sim.model.geom_rgba[2, :3].tolist() == pytest.approx([0.1, 0.1, 0.1])


def test_a_part_that_glows_gets_a_material_of_its_own(world: ScriptWorld) -> None:
    assert paint(world, "robot", "0.1, 0, 0", "'LED'", component=3) == 1
    model = world.sim.model
    geom = int(model.body("robot").geomadr[0]) + 3
    material = int(model.geom_matid[geom])
    assert model.mat_emission[material] == pytest.approx(0.5)
    assert model.mat_emission[model.mat("LED").id] == 0
    assert color(world, "robot", "'LED'", 3) == pytest.approx([0.1, 0, 0])
    assert color(world, "other", "'LED'", 3) == [0, 0, 0]
    assert paint(world, "robot", "0, 1, 0", "'LED'", component=3) == 1
    assert world.sim.model.geom_rgba[geom, :3].tolist() == [0, 1, 0], "it shines brighter than it reflects"
    assert paint(world, "robot", "0, 0, 0", "'LED'", component=3) == 1
    assert world.sim.model.geom_rgba[geom, :3].tolist() == pytest.approx([0.2, 0, 0]), "it is off again"


def test_a_highlight_and_an_auxiliary_colour_are_kept(world: ScriptWorld) -> None:
    assert paint(world, "painted", "0.3, 0.6, 0.9", component=2) == 1
    assert color(world, "painted", component=2) == [0.3, 0.6, 0.9]
    model = world.sim.model
    geom = int(model.body("painted").geomadr[0])
    material = int(model.geom_matid[geom])
    assert model.mat_specular[material] == pytest.approx(0.6)
    assert highlights_of(model)[material] == pytest.approx([0.3, 0.6, 0.9]), "cameras show it"
    assert paint(world, "painted", "1, 0, 1", component=5) == 1
    assert color(world, "painted", component=5) == [1, 0, 1]
    assert color(world, "painted") == [0, 0, 1]


def test_a_glow_outlives_an_edit_and_ends_with_the_run(world: ScriptWorld) -> None:
    paint(world, "other", "0.1, 0, 0", component=3)
    world.lua("sim.createDummy(0.1)")
    assert color(world, "other", component=3) == pytest.approx([0.1, 0, 0])
    world.sim.stop()
    world.run(0)
    assert color(world, "other", component=3) == [0, 0, 0]


def test_a_colour_that_mujoco_takes_for_none_is_shown(world: ScriptWorld) -> None:
    paint(world, "painted", "0", component=4)
    paint(world, "painted", "0.5, 0.5, 0.5")
    assert color(world, "painted") == pytest.approx([0.5, 0.5, 0.5], abs=1e-3)


def test_an_entity_changes_its_colour_and_gets_it_back(world: ScriptWorld) -> None:
    world.lua(H + "before = sim.changeEntityColor(h'robot', {1, 1, 0})")
    assert color(world, "robot") == [1, 1, 0]
    world.lua("sim.restoreEntityColor(before)")
    assert color(world, "robot", "'BLUE PART'") == [0, 0, 1]
    assert color(world, "robot", "'LED'") == pytest.approx([0.2, 0, 0])
    world.lua("before = sim.changeEntityColor(sim.getCollectionHandle('both'), {1, 1, 0})")
    assert (color(world, "other"), color(world, "painted")) == ([1, 1, 0], [1, 1, 0])
    world.lua("sim.restoreEntityColor(before)")
    assert color(world, "painted") == [0, 0, 1]
    world.fails("sim.restoreEntityColor({{}})", "not the colours that sim.changeEntityColor returned")


def test_bad_colours_are_refused(world: ScriptWorld) -> None:
    world.fails(H + "sim.getShapeColor(h'floor', nil, 9)", "9 is no component")
    world.fails(H + "sim.setShapeColor(h'floor', nil, 0, {1})", "a colour is {red, green, blue}")


def test_a_scene_saved_before_highlights_had_colours_gets_them(tmp_path: Path) -> None:
    scene = SCENE.replace('"paint"', '"paint~own0"')  # the name of a material that a script had made
    world = ScriptWorld(tmp_path, scene, owner="floor")
    assert paint(world, "painted", "0.5, 0.25, 0", component=2) == 1
    assert color(world, "painted", component=2) == pytest.approx([0.5, 0.25, 0])
    shown = world.sim.model.body("painted").geomadr[0]
    assert highlights_of(world.sim.model)[world.sim.model.geom_matid[shown]] == pytest.approx([0.5, 0.25, 0])
