"""Model properties, dummies and removal: what each bit does, and what a stop brings back."""

from __future__ import annotations

from pathlib import Path

import pytest
from handler_calls import World
from scenes_for_tests import ARM

from simx_client.protocol import constants as c
from simx_server.errors import CommandError, UnknownHandle
from simx_server.scene.editing import editing
from simx_server.scene.poses import frames

pytestmark = pytest.mark.slow

DROP = """
<mujoco>
  <option timestep="0.002" integrator="implicitfast"/>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 0.1"/>
    <camera name="eye" pos="0 0 3" resolution="8 8"/>
    <site name="ray" pos="1 0 1" zaxis="-1 0 0"/>
    <body name="box" pos="0 0 1">
      <freejoint/>
      <geom type="box" size="0.1 0.1 0.1" mass="1"/>
      <body name="arm">
        <joint name="hinge" axis="0 1 0" armature="0.01"/>
        <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.02" mass="0.2" contype="0" conaffinity="0"/>
      </body>
    </body>
  </worldbody>
  <sensor><rangefinder site="ray"/></sensor>
  <custom><text name="simx:script:box" data="file=box.lua"/></custom>
</mujoco>
"""


@pytest.fixture
def world(tmp_path: Path) -> World:
    (tmp_path / "drop.xml").write_text(DROP)
    (tmp_path / "box.lua").write_text(
        "function sysCall_actuation() sim.setFloatSignal('seen', sim.getSimulationTime()) end"
    )
    return World(file=tmp_path / "drop.xml", workspace=tmp_path)


def height(world: World) -> float:
    return frames.get_position(world.sim, world.handle("box"), -1)[2]


def test_property_is_what_was_set_and_any_high_bit_means_no_model(world: World) -> None:
    box = world.handle("box")
    assert world.call("simxGetModelProperty", box) == 0xF000
    world.call(
        "simxSetModelProperty", box, c.sim_modelproperty_not_visible | c.sim_modelproperty_not_cuttable
    )
    assert world.call("simxGetModelProperty", box) == 0x110
    world.call("simxSetModelProperty", box, 0x1000)
    assert world.call("simxGetModelProperty", box) == 0xF000
    with pytest.raises(CommandError, match="no model base"):
        world.call("simxRemoveModel", box)
    with pytest.raises(CommandError, match="valid are the bits"):
        world.call("simxSetModelProperty", box, 0x10000)
    for name in ("simxGetModelProperty", "simxSetModelProperty"):
        with pytest.raises(UnknownHandle):
            world.call(name, 999, *[0] * (name == "simxSetModelProperty"))


def test_property_set_while_running_is_taken_back_by_stop(world: World) -> None:
    box = world.handle("box")
    world.call("simxSetModelProperty", box, 0)
    world.run(1)
    world.call("simxSetModelProperty", box, c.sim_modelproperty_not_respondable)
    world.sim.stop()
    assert world.call("simxGetModelProperty", box) == 0
    world.run(15)
    assert height(world) == pytest.approx(0.1, abs=0.02)


def test_not_respondable_falls_through_the_floor_until_it_is_taken_back(world: World) -> None:
    box = world.handle("box")
    world.call("simxSetModelProperty", box, c.sim_modelproperty_not_respondable)
    world.run(15)
    assert height(world) < -0.5
    world.sim.stop()
    world.call("simxSetModelProperty", box, 0)
    world.run(15)
    assert height(world) == pytest.approx(0.1, abs=0.02)


def test_copy_of_a_restricted_model_is_restricted_and_can_be_freed(world: World) -> None:
    world.call("simxSetModelProperty", world.handle("box"), c.sim_modelproperty_not_respondable)
    (copy,) = world.call("simxCopyPasteObjects", [world.handle("box")])
    assert world.call("simxGetModelProperty", copy) == c.sim_modelproperty_not_respondable
    world.call("simxSetModelProperty", copy, 0)
    world.run(15)
    assert height(world) < -0.5
    assert frames.get_position(world.sim, copy, -1)[2] > 0


def test_shape_that_could_not_collide_during_an_edit_collides_when_it_may_again(world: World) -> None:
    box = world.handle("box")
    world.call("simxSetObjectInt32Param", box, 3004, 0)
    world.call("simxCreateDummy", 0.1, None)
    world.call("simxSetObjectInt32Param", box, 3004, 1)
    world.run(15)
    assert height(world) == pytest.approx(0.1, abs=0.02)


def test_not_dynamic_stays_in_the_air_with_its_joints_until_it_is_let_go(world: World) -> None:
    box = world.handle("box")
    world.call("simxSetJointPosition", world.handle("hinge"), 0.3)
    world.call("simxSetModelProperty", box, c.sim_modelproperty_not_dynamic)
    world.run(5)
    assert height(world) == pytest.approx(1.0, abs=1e-9)
    assert world.sim.joints.position(world.handle("hinge")) == pytest.approx(0.3, abs=1e-9)
    world.call("simxSetModelProperty", box, 0)
    for _ in range(15):
        world.parts.step()
    assert height(world) < 0.2
    assert world.sim.joints.position(world.handle("hinge")) != pytest.approx(0.3, abs=1e-3)
    world.sim.stop()
    assert height(world) == pytest.approx(1.0)
    assert world.call("simxGetModelProperty", box) == c.sim_modelproperty_not_dynamic


def test_not_detectable_and_not_renderable_are_independent(world: World) -> None:
    box, ray, sim = world.handle("box"), world.handle("ray"), world.sim
    world.call("simxSetModelProperty", box, c.sim_modelproperty_not_renderable)
    geoms = [g for g in range(sim.model.ngeom) if sim.scene.owner_of_geom(g, sim.model) == box]
    assert [int(sim.model.geom_group[g]) for g in geoms] == [6], "which users see, and vision sensors do not"
    world.run(1)
    assert world.call("simxReadProximitySensor", ray)[0]
    world.call("simxSetModelProperty", box, c.sim_modelproperty_not_detectable)
    assert [int(sim.model.geom_group[g]) for g in geoms] == [0]
    world.parts.step()
    assert not world.call("simxReadProximitySensor", ray)[0]


def test_what_is_not_visible_is_in_no_image_and_still_detected(world: World) -> None:
    box, sim = world.handle("box"), world.sim
    geoms = [g for g in range(sim.model.ngeom) if sim.scene.owner_of_geom(g, sim.model) == box]
    for bits, group, visible in (
        (c.sim_modelproperty_not_visible, 5, 0),
        (c.sim_modelproperty_not_visible | c.sim_modelproperty_not_renderable, 5, 0),
        (c.sim_modelproperty_not_renderable, 6, 1),
        (0, 0, 1),
    ):
        world.call("simxSetModelProperty", box, bits)
        assert [int(sim.model.geom_group[g]) for g in geoms] == [group]
        assert world.call("simxGetObjectIntParameter", box, 36) == visible
        world.run(1)
        assert world.call("simxReadProximitySensor", world.handle("ray"))[0]
        world.call("simxStopSimulation")


def test_not_reset_stays_where_the_run_brought_it(world: World) -> None:
    box, sim = world.handle("box"), world.sim
    world.call("simxSetModelProperty", box, c.sim_modelproperty_not_reset)
    world.run(15)
    angle = sim.joints.position(world.handle("hinge"))
    sim.stop()
    assert height(world) == pytest.approx(0.1, abs=0.02)
    assert sim.joints.position(world.handle("hinge")) == pytest.approx(angle)


def test_inactive_scripts_are_not_called(world: World) -> None:
    world.call("simxSetModelProperty", world.handle("box"), 0x200)
    world.run(2)
    with pytest.raises(CommandError):
        world.call("simxGetFloatSignal", "seen")
    world.call("simxSetModelProperty", world.handle("box"), 0)
    world.parts.step()
    assert world.call("simxGetFloatSignal", "seen") == pytest.approx(0.1)


def test_script_of_a_copy_runs_at_once_for_the_copy(world: World) -> None:
    (world.sim.files.workspace / "box.lua").write_text(
        "function sysCall_init() me = sim.getObjectName(sim.handle_self) end\n"
        "function name() return {}, {}, {me}, '' end"
    )
    world.run(1)
    world.call("simxCopyPasteObjects", [world.handle("box")])
    for name in ("box", "box#0"):
        assert world.call("simxCallScriptFunction", name, 1, "name", [], [], [], b"")[2] == [name]
    world.call("simxRemoveObject", world.handle("box#0"))
    world.parts.step()
    world.sim.stop()
    world.run(1)
    assert world.call("simxCallScriptFunction", "box", 1, "name", [], [], [], b"")[2] == ["box"]


def test_object_put_under_a_restricted_model_is_restricted_too(world: World) -> None:
    sim = world.sim
    dummy = world.call("simxCreateDummy", 0.1, None)
    world.call("simxSetModelProperty", dummy, c.sim_modelproperty_not_respondable)
    world.call("simxSetObjectParent", world.handle("box"), dummy, True)
    world.run(15)
    assert height(world) < -0.5
    sim.stop()


COLOR = [255, 0, 0, 0, 0, 0, 64, 64, 64, 0, 0, 32]


def test_dummy_keeps_its_size_and_colour_and_goes_with_the_stop(world: World) -> None:
    sim = world.sim
    stays = world.call("simxCreateDummy", 0.2, COLOR)
    assert world.call("simxGetObjectFloatParam", stays, 10003) == pytest.approx(0.2)
    world.call("simxSetObjectFloatParam", stays, 10003, 0.3)
    (copy,) = world.call("simxCopyPasteObjects", [stays])
    assert world.call("simxGetObjectFloatParam", copy, 10003) == pytest.approx(0.3)
    for dummy in (stays, copy):
        shown = [editing.dummy_color(sim, dummy, component) for component in (0, 2, 3)]
        assert [round(part * 255) for color in shown for part in color] == [*COLOR[:3], *COLOR[6:]]
    assert sim.model.site_rgba[sim.scene.get(stays).id] == pytest.approx([1, 0, 0, 1])
    ray = world.call("simxCreateDummy", 0.1, None)
    assert editing.dummy_color(sim, ray, 0) == [1, 1, 1]
    world.call("simxRemoveObject", ray)
    assert frames.get_position(sim, stays, -1) == [0, 0, 0]
    world.run(1)
    goes = world.call("simxCreateDummy", 0.1, None)
    assert goes > stays
    assert sim.scene.get(goes).name == "Dummy0"
    assert frames.get_position(sim, goes, -1) == [0, 0, 0]
    sim.stop()
    assert stays in sim.scene.objects
    assert goes not in sim.scene.objects
    assert world.call("simxCreateDummy", 0.1, None) > goes


@pytest.mark.parametrize("size", [0.0, -1.0, 1e6])
def test_dummy_of_any_size_is_made_as_small_or_large_as_can_be(world: World, size: float) -> None:
    dummy = world.call("simxCreateDummy", size, None)
    assert 0 < editing.dummy_size(world.sim, dummy) < 1000


def test_removing_everything_empties_the_scene_in_one_edit_and_stop_brings_it_back() -> None:
    world = World(ARM)
    world.run(1)
    versions = world.sim.model_version
    world.call("simxSetObjectSelection", [1, 4])
    world.call("simxRemoveObject", c.sim_handle_all)
    assert world.sim.model_version == versions + 1
    assert world.sim.scene.objects == {}
    assert world.call("simxGetObjectSelection") == []
    with pytest.raises(UnknownHandle):
        world.call("simxRemoveObject", 4)
    world.sim.stop()
    assert len(world.sim.scene.objects) == 14
    world.call("simxRemoveObject", c.sim_handle_all)
    world.call("simxRemoveObject", c.sim_handle_all)
    assert world.sim.scene.objects == {}


def test_removal_keeps_the_selection_of_the_others() -> None:
    world = World(ARM)
    world.call("simxSetObjectSelection", [world.handle("wall"), world.handle("cube")])
    world.call("simxRemoveObject", world.handle("cube"))
    assert world.call("simxGetObjectSelection") == [world.handle("wall")]
