"""A scene that is saved and loaded again is the same: everything that can be read of it, and how it moves."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from handler_calls import QuickPainter, World
from saved_worlds import close_worlds, opened, reloaded
from seeds import chosen
from sim_api_calls import ScriptWorld
from vrep_samples import each_kind_of_sample
from world_listing import differences, listing

from simx_server.editing.saving.packing import pack_scene
from simx_server.files.library import shipped_scenes
from simx_server.scene.poses.placing import object_pose

_ALIKE = {
    *("ackermann_line", "bubblerob", "jaco", "lbr_iiwa_7_r800", "line_tracer", "nao", "pick_place", "reach"),
    *("ur10", "ur3", "ur5", "ur5_rg2_kinect_ball"),
}
"""Scenes that have nothing which others, and the models of `test_saved_models`, lack: kinds of objects and settings."""

_SHIPPED = sorted(shipped_scenes().glob("*.xml"))
_DIFFERENT = chosen(_SHIPPED, [path for path in _SHIPPED if path.stem not in _ALIKE])

_EVERY_KIND = r"""
local dummy = sim.createDummy(0.02)
sim.setObjectName(dummy, 'Mark')
sim.setObjectPosition(dummy, -1, {1, 2, 3})
local box = sim.createPureShape(0, 9, {0.1, 0.2, 0.3}, 2.5, nil)
sim.setObjectName(box, 'Box')
sim.setObjectPosition(box, -1, {0.5, 0, 2})
sim.setShapeColor(box, nil, 4, {0.6})
sim.setModelProperty(box, 0)
local joint = sim.createJoint(sim.joint_revolute_subtype, sim.jointmode_force, 0)
sim.setObjectName(joint, 'Hinge')
sim.setObjectPosition(joint, -1, {3, 1, 1})
local rod = sim.createPureShape(2, 0, {0.1, 0.1, 0.3}, 1.5, nil)
sim.setObjectName(rod, 'Rod')
sim.setObjectPosition(rod, -1, {2.5, 0, 2})
sim.setObjectParent(rod, joint, true)
sim.setJointInterval(joint, false, {-1, 2})
sim.setJointTargetPosition(joint, 0.3)
sim.setJointPosition(joint, 0.2)
local feel = sim.createForceSensor(0, {0, 1, 0, 0, 0}, {0.01, 5, 6, 0, 0})
sim.setObjectName(feel, 'Feel')
sim.setObjectPosition(feel, -1, {0, 4, 1})
sim.setObjectParent(feel, box, true)
local held = sim.createPureShape(1, 9, {0.2, 0.2, 0.2}, 0.5, nil)
sim.setObjectName(held, 'Held')
sim.setObjectPosition(held, -1, {0, 4, 1.2})
sim.setObjectParent(held, feel, true)
sim.setObjectInt32Param(held, sim.shapeintparam_respondable_mask, 0x0f0f)
local look = sim.createVisionSensor(2, {16, 8, 0, 0}, {0.05, 5, 0.8, 0.1, 0, 0, 0.2, 0.3, 0.4, 0, 0})
sim.setObjectName(look, 'Look')
sim.setObjectPosition(look, -1, {0, 0, 3})
local near = sim.createProximitySensor(sim.proximitysensor_cone_subtype, 16, 1, {0, 0, 0, 0, 0, 0, 0, 0},
    {0.1, 1, 0, 0, 0, 0, 0, 0, 0.02, 0.3, 0.5, 0.1, 0, 0, 0})
sim.setObjectName(near, 'Near')
sim.setObjectParent(near, box, true)
local mesh = sim.createMeshShape(0, 0, {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3})
sim.setObjectName(mesh, 'Tetra')
sim.setObjectPosition(mesh, -1, {-3, 0, 1})
sim.setShapeColor(mesh, nil, 0, {0.1, 0.7, 0.2})
sim.setShapeColor(mesh, nil, 2, {0.4, 0.5, 0.6})
sim.setShapeColor(mesh, nil, 5, {0.9, 0.8, 0.7})
local cloud = sim.createPointCloud(0.02, 20, 0, 4)
sim.setObjectName(cloud, 'Cloud')
sim.insertPointsIntoPointCloud(cloud, 0, {0, 0, 1, 0, 1, 1, 1, 1, 1}, nil)
local tree = sim.createOctree(0.1, 0, 1)
sim.setObjectName(tree, 'Tree')
sim.insertVoxelsIntoOctree(tree, 0, {0, 0, 2, 0.5, 0.5, 2}, nil, {7, 8})
local path = sim.createPath(-1)
sim.setObjectName(path, 'Way')
sim.insertPathCtrlPoints(path, 0, 0, 2, {0, 0, 0, 0, 0, 0, 1, 1, 0.5, 0.5, 0, 1, 1, 0, 0, 0, 0.5, 1, 1, 0.5, 0.5, 0})
sim.setPathPosition(path, 0.5)
sim.writeCustomDataBlock(box, 'mine', 'some bytes\0\1')
sim.writeCustomDataBlock(sim.handle_scene, 'ours', 'of the scene')
sim.addObjectCustomData(box, 4711, 'numbered', 8)
sim.setReferencedHandles(box, {dummy, -1, mesh})
sim.setExtensionString(box, -1, 'an extension %20 string')
sim.setScriptSimulationParameter(sim.handle_self, 'speed', 'two words')
local some = sim.createCollection('some', 0)
sim.addObjectToCollection(some, box, sim.handle_tree, 0)
sim.addObjectToCollection(some, mesh, sim.handle_single, 0)
sim.addObjectToCollection(some, near, sim.handle_single, 1)
sim.setObjectInt32Param(look, sim.visionintparam_entity_to_render, some)
sim.setObjectInt32Param(near, sim.proxintparam_entity_to_detect, mesh)
sim.setObjectInt32Param(box, sim.objintparam_visibility_layer, 3)
sim.setObjectSpecialProperty(rod, sim.objectspecialproperty_measurable)
sim.setObjectProperty(rod, sim.objectproperty_collapsed)
sim.setObjectFloatParam(box, sim.shapefloatparam_init_velocity_x, 0.25)
sim.setArrayParam(sim.arrayparam_fog_color, {0.1, 0.2, 0.3})
sim.setArrayParam(sim.arrayparam_gravity, {0, 0, -3.7})
sim.setBoolParam(sim.boolparam_proximity_sensor_handling_enabled, false)
local tip = sim.createDummy(0.01)
sim.setObjectName(tip, 'Tip')
sim.setObjectParent(tip, rod, true)
local target = sim.createDummy(0.01)
sim.setObjectName(target, 'Goal')
sim.setLinkDummy(tip, target)
sim.setObjectInt32Param(tip, sim.dummyintparam_link_type, sim.dummy_linktype_ik_tip_target)
local group = sim.createIkGroup(2 + 4 + 32, {1, 40}, {0.2, 1, 0.01, 0.02})
sim.createIkElement(group, 0, {tip, box, mesh, 7}, {0.01, 0.02, 0.5, 1})
sim.createIkElement(group, 1, {dummy, -1, -1, 0}, nil)
sim.addGraphStream(dummy, 'height', 'm', 0, {0, 1, 0}, 0)
return 1
"""
"""One object of each kind that scripts can make, and settings of all sorts, beside the objects of `ScriptWorld`."""


@pytest.fixture(autouse=True)
def _scripts_end() -> Iterator[None]:
    yield
    close_worlds()


def workshop(folder: Path) -> ScriptWorld:
    """A stopped world with an object of every kind."""
    world = ScriptWorld(folder, kind="customization")
    opened(world)
    world.sim.stop()
    assert world.lua(_EVERY_KIND) == [1]
    return world


def poses(world: World) -> dict[str, np.ndarray]:
    world.sim.refresh()
    items = world.sim.scene.objects.values()
    return {item.name: np.concatenate(object_pose(world.sim, item)) for item in items}


def changes(before: World, after: World) -> list[str]:
    return differences(listing(before.parts), listing(after.parts))


def test_an_object_of_every_kind_and_all_its_settings_are_the_same(tmp_path: Path) -> None:
    world = workshop(tmp_path)
    again = reloaded(world, tmp_path)
    assert changes(world, again) == []
    assert len(again.sim.scene.objects) == len(world.sim.scene.objects) > 20


def test_the_same_scene_gives_the_same_bytes(tmp_path: Path) -> None:
    world = workshop(tmp_path)
    assert pack_scene(world.parts).data == pack_scene(world.parts).data


def test_saving_changes_nothing(tmp_path: Path) -> None:
    world = workshop(tmp_path)
    pack_scene(world.parts)
    before = listing(world.parts)
    pack_scene(world.parts)
    assert differences(before, listing(world.parts)) == []


def test_objects_that_were_removed_renamed_copied_and_grouped_are_saved_as_they_are(tmp_path: Path) -> None:
    world = workshop(tmp_path)
    world.lua("""
        sim.removeObject(sim.getObjectHandle('arm'))
        sim.setObjectName(sim.getObjectHandle('cube'), 'Würfel')
        sim.copyPasteObjects({sim.getObjectHandle('Box')}, 1)
        sim.setObjectParent(sim.getObjectHandle('wall'), sim.getObjectHandle('cube#0'), true)
        sim.setObjectInt32Param(sim.getObjectHandle('cube#0'), sim.shapeintparam_static, 1)
        sim.groupShapes({sim.getObjectHandle('Würfel'), sim.getObjectHandle('Tetra')})
        return 1
    """)
    again = reloaded(world, tmp_path)
    assert changes(world, again) == []
    assert again.handle("Box#0") > 0
    assert changes(again, reloaded(again, tmp_path, "twice.ttt")) == []


@pytest.mark.parametrize("path", _DIFFERENT, ids=lambda path: path.stem)
def test_a_shipped_scene_is_the_same(path: Path, tmp_path: Path) -> None:
    world = opened(World(file=path, workspace=tmp_path, painter=QuickPainter()))
    again = reloaded(world, tmp_path)
    assert changes(world, again) == []
    world.run(5)
    again.run(5)
    first, second = poses(world), poses(again)
    assert all(np.abs(first[name] - second[name]).max() < 1e-9 for name in first)


@each_kind_of_sample
def test_a_scene_of_vrep_is_the_same(path: Path, tmp_path: Path) -> None:
    world = opened(World(file=path, workspace=tmp_path, painter=QuickPainter()))
    again = reloaded(world, tmp_path)
    assert changes(world, again) == []


def test_saving_a_run_stores_where_everything_is(tmp_path: Path) -> None:
    world = opened(World(file=shipped_scenes() / "ur5_rg2_kinect_ball.xml", painter=QuickPainter()))
    start = poses(world)
    world.run(20)
    again = reloaded(world, tmp_path)
    assert not again.sim.is_running
    now, found = poses(world), poses(again)
    assert all(np.abs(now[name] - found[name]).max() < 1e-9 for name in now)
    assert max(np.abs(now[name] - start[name]).max() for name in now) > 0.01
    again.run(1)
    again.sim.stop()
    assert all(np.abs(found[name] - pose).max() == 0 for name, pose in poses(again).items())


def test_positions_of_dependent_joints_and_of_spherical_ones_are_saved(tmp_path: Path) -> None:
    xml = """<mujoco><option gravity="0 0 0"/><worldbody>
      <body name="a"><joint name="first" axis="0 0 1"/><geom size="0.1"/>
        <body name="b" pos="1 0 0"><joint name="second" axis="0 0 1"/><geom size="0.1"/></body></body>
      <body name="c" pos="3 0 0"><joint name="ball" type="ball"/><geom type="box" size="0.1 0.2 0.3"/></body>
      <body name="m" mocap="true" pos="0 2 0"><geom size="0.1" contype="0" conaffinity="0"/></body>
    </worldbody><custom>
      <text name="simx:joint:first" data="mode=passive"/>
      <text name="simx:joint:second" data="mode=dependent master=first multiplication=2 offset=0.1"/>
    </custom></mujoco>"""
    world = World(xml)
    world.call("simxSetJointPosition", world.handle("first"), 0.25)
    world.call("simxSetSphericalJointMatrix", world.handle("ball"), [0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0])
    world.call("simxSetObjectPosition", world.handle("m"), -1, [0.5, 2.5, 1.0])
    again = reloaded(world, tmp_path)
    assert changes(world, again) == []
    assert again.call("simxGetJointPosition", again.handle("second")) == pytest.approx(0.6)
    again.call("simxSetJointPosition", again.handle("first"), 0.5)
    assert again.call("simxGetJointPosition", again.handle("second")) == pytest.approx(1.1)


def test_scripts_run_in_the_loaded_scene_as_before(tmp_path: Path) -> None:
    pytest.importorskip("lupa")
    (tmp_path / "mover.lua").write_text(
        "function sysCall_init() h = sim.getObjectHandle('box') n = 0 end\n"
        "function sysCall_actuation() n = n + 1 sim.setObjectPosition(h, -1, {n * 0.1, 0, 1}) end\n"
    )
    (tmp_path / "scene.xml").write_text("""<mujoco><option gravity="0 0 0"/><worldbody>
      <body name="box" pos="0 0 1"><geom type="box" size="0.1 0.1 0.1"/></body></worldbody><custom>
      <text name="simx:script:box" data="file=mover.lua"/>
      <text name="simx:lua:main" data="function sysCall_actuation() sim.handleChildScripts(sim.syscb_actuation)
        sim.setIntegerSignal('seen', 1) end"/>
      </custom></mujoco>""")
    world = opened(World(file=tmp_path / "scene.xml", workspace=tmp_path))
    (tmp_path / "elsewhere").mkdir()
    again = reloaded(world, tmp_path / "elsewhere")
    for each in (world, again):
        each.run(3)
    assert poses(again)["box"][0] == pytest.approx(0.3)
    assert poses(world)["box"].tolist() == poses(again)["box"].tolist()
    assert again.parts.signals.integers["seen"] == world.parts.signals.integers["seen"] == 1


def test_a_model_that_is_not_dynamic_is_released_after_loading_as_well(tmp_path: Path) -> None:
    world = World("""<mujoco><worldbody><body name="base" pos="0 0 3"><freejoint/><geom size="0.1"/></body></worldbody>
      <custom><text name="simx:model:base" data="base=yes"/></custom></mujoco>""")
    world.call("simxSetModelProperty", world.handle("base"), 0x20)
    assert world.sim.model.njnt == 0
    again = reloaded(world, tmp_path)
    assert again.sim.model.njnt == 0
    again.call("simxSetModelProperty", again.handle("base"), 0)
    again.run(5)
    assert poses(again)["base"][2] < 2.9
