"""Loading models: what becomes of a file's objects, stopped and running, and after the stop."""

from __future__ import annotations

import logging
import struct
from pathlib import Path

import numpy as np
import pytest
from handler_calls import World
from scenes_for_tests import ARM, run, world_of

from simx_server.editing import models
from simx_server.errors import CommandError
from simx_server.scene.naming.names import copy_names
from simx_server.scene.objects import ObjectKind
from simx_server.scene.poses import frames
from simx_server.simulation.simulation import Simulation

pytestmark = pytest.mark.slow

GRIPPER = """
<mujoco model="gripper">
  <compiler angle="degree" eulerseq="XYZ"/>
  <option gravity="0 0 -1"/>
  <worldbody>
    <light name="lamp" pos="0 0 1"/>
    <body name="gripper" pos="0 0 0.5" euler="0 0 90">
      <geom type="box" size="0.02 0.02 0.02" mass="0.2"/>
      <body name="left" pos="0 0.02 0">
        <joint name="finger" type="slide" axis="0 1 0" range="0 0.05" damping="1"/>
        <geom type="box" size="0.01 0.01 0.03" mass="0.05" contype="0" conaffinity="0"/>
      </body>
      <body name="right" pos="0 -0.02 0">
        <joint name="knuckle" axis="0 0 1" range="-30 30" armature="0.01"/>
        <geom type="box" size="0.01 0.01 0.03" mass="0.05" contype="0" conaffinity="0"/>
        <site name="pad" euler="90 0 0"/>
      </body>
    </body>
  </worldbody>
  <actuator><position name="close" joint="finger" kp="100" kv="5"/></actuator>
  <sensor><rangefinder site="pad" cutoff="2"/></sensor>
  <custom>
    <text name="simx:joint:knuckle" data="control=velocity motor=on max_force=3"/>
    <text name="simx:script:gripper" data="file=gripper.lua"/>
    <numeric name="simx:time_step" data="0.01"/>
  </custom>
  <keyframe><key name="open" qpos="0.01 0"/></keyframe>
</mujoco>
"""

BALL_URDF = """
<robot name="ball"><link name="ball">
  <inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
  <collision><geometry><sphere radius="0.1"/></geometry></collision>
</link></robot>
"""

WEDGE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


@pytest.fixture
def world(tmp_path: Path) -> World:
    (tmp_path / "gripper.xml").write_text(GRIPPER)
    (tmp_path / "gripper.lua").write_text(
        "function sysCall_init() sim.setIntegerSignal('inited', 1) end\n"
        "function twice(ints) return {2 * ints[1]}, {}, {}, '' end\n"
    )
    (tmp_path / "ball.urdf").write_text(BALL_URDF)
    (tmp_path / "wedge.obj").write_text(WEDGE)
    return World(ARM, workspace=tmp_path)


def names_below(sim: Simulation, handle: int) -> list[str]:
    return [sim.scene.objects[h].name for h in sim.scene.descendants(handle)]


@pytest.mark.parametrize("is_running", [False, True])
def test_model_gets_the_highest_handles_and_becomes_the_selection(world: World, is_running: bool) -> None:
    sim = world.sim
    if is_running:
        world.run(2)
    world.call("simxSetObjectSelection", [1, 2])
    highest = max(sim.scene.objects)
    base = world.call("simxLoadModel", "gripper.xml", 0)
    assert base > highest
    assert min(set(sim.scene.descendants(base))) > highest
    assert sim.scene.objects[base].name == "gripper"
    assert sim.scene.objects[base].parent == -1
    assert world.call("simxGetObjectSelection") == [base]
    assert sorted(names_below(sim, base)) == ["finger", "knuckle", "lamp", "left", "pad", "right"]
    assert world.call("simxGetModelProperty", base) == 0
    assert frames.get_position(sim, base, -1) == pytest.approx([0, 0, 0.5])
    assert sim.scene.get(world.handle("pad")).kind == ObjectKind.PROXIMITY_SENSOR
    assert sim.model.opt.gravity[2] == pytest.approx(-9.81)
    assert sim.time_step == 0.05


def test_state_of_a_running_scene_is_as_if_nothing_was_loaded(world: World, tmp_path: Path) -> None:
    sim, other = world.sim, world_of(ARM)
    twin = other.simulation
    for each in (world.parts, other):
        joints, scene = each.simulation.joints, each.simulation.scene
        joints.set_target_position(scene.resolve("shoulder"), 1.0)
        run(each, 4)
    models.load_model(world.parts, tmp_path / "gripper.xml")
    elbow, velocity = twin.scene.resolve("elbow"), other.velocities.measure(twin.scene.resolve("hand"))
    assert world.parts.velocities.measure(sim.scene.resolve("hand")) == velocity
    for each in (world.parts, other):
        run(each, 4)
    assert sim.joints.position(sim.scene.resolve("shoulder")) == pytest.approx(
        twin.joints.position(twin.scene.resolve("shoulder")), abs=1e-9
    )
    assert sim.joints.position(elbow) == pytest.approx(twin.joints.position(elbow), abs=1e-9)
    assert sim.time == twin.time


def test_equal_names_get_copy_numbers_and_their_joints_work_apart(world: World) -> None:
    sim = world.sim
    bases = [world.call("simxLoadModel", "gripper.xml", 0) for _ in range(3)]
    assert [sim.scene.get(base).name for base in bases] == ["gripper", "gripper#0", "gripper#1"]
    assert world.handle("finger#1") in sim.scene.descendants(bases[2])
    assert world.handle("gripper#") == bases[0]
    assert world.handle("/gripper[1]/finger") in sim.scene.descendants(bases[1])
    world.call("simxSetJointTargetPosition", world.handle("finger#0"), 0.04)
    world.call("simxSetJointTargetVelocity", world.handle("knuckle#1"), 1.0)
    assert world.call("simxGetJointMaxForce", world.handle("knuckle#1")) == pytest.approx(3.0)
    world.run(4)
    positions = [sim.joints.position(world.handle(f"finger{n}")) for n in ("", "#0")]
    assert positions[1] > positions[0] + 0.01
    assert sim.joints.position(world.handle("knuckle#1")) == pytest.approx(0.2, abs=0.02)
    assert abs(sim.joints.position(world.handle("knuckle"))) < 0.01


@pytest.mark.parametrize(
    ("names", "taken", "expected"),
    [
        ({"a", "b"}, set(), {"a": "a", "b": "b"}),
        ({"a", "b"}, {"b"}, {"a": "a#0", "b": "b#0"}),
        ({"a"}, {"a", "a#0", "a#2"}, {"a": "a#1"}),
        ({"a", "a#0"}, {"a", "a#0"}, {"a": "a#1", "a#0": "a#2"}),
        ({"a#3"}, {"a#3"}, {"a#3": "a#4"}),
    ],
)
def test_copy_numbers_of_things_added_together_rise_alike(names, taken, expected) -> None:
    assert copy_names(names, taken) == expected


def test_stop_takes_the_model_away_and_its_handles_are_not_given_again(world: World) -> None:
    sim = world.sim
    before = dict(sim.scene.objects)
    world.run(1)
    loaded = world.call("simxLoadModel", "gripper.xml", 0)
    world.parts.step()
    sim.stop()
    assert set(sim.scene.objects) == set(before)
    assert world.call("simxGetObjectSelection") == []
    assert world.call("simxLoadModel", "gripper.xml", 0) > loaded
    assert world.handle("gripper") > loaded
    sim.start()
    world.parts.step()
    sim.stop()
    assert world.handle("gripper") > loaded


def test_loaded_model_can_be_taken_by_a_gripper_and_removed(world: World) -> None:
    sim = world.sim
    world.run(1)
    ball = world.call("simxLoadModel", "gripper.xml", 0)
    world.call("simxSetObjectParent", ball, world.handle("hand"), True)
    local = frames.get_position(sim, ball, world.handle("hand"))
    world.call("simxSetJointTargetPosition", world.handle("elbow"), 0.3)
    for _ in range(5):
        world.parts.step()
    assert frames.get_position(sim, ball, world.handle("hand")) == pytest.approx(local, abs=1e-9)
    world.call("simxRemoveModel", ball)
    with pytest.raises(CommandError, match="no object named 'finger'"):
        world.handle("finger")
    world.parts.step()
    assert world.handle("hand") == 11


def test_script_of_a_loaded_model_is_found_beside_the_model_and_runs_at_once(
    world: World, tmp_path: Path
) -> None:
    (tmp_path / "parts").mkdir()
    for name in ("gripper.xml", "gripper.lua"):
        (tmp_path / name).rename(tmp_path / "parts" / name)
    world.run(1)
    world.call("simxLoadModel", "parts/gripper.xml", 0)
    assert world.call("simxGetInt32Signal", "inited") == 1
    answer = world.call("simxCallScriptFunction", "gripper", 1, "twice", [21], [], [], b"")
    assert answer[0] == [42]
    world.sim.stop()
    with pytest.raises(CommandError):
        world.call("simxCallScriptFunction", "gripper", 1, "twice", [21], [], [], b"")


def test_urdf_and_meshes_are_models(world: World, tmp_path: Path) -> None:
    sim = world.sim
    ball = world.call("simxLoadModel", "ball.urdf", 0)
    assert sim.scene.get(ball).name == "ball"
    wedges = [world.call("simxLoadModel", "wedge.obj", 0) for _ in range(2)]
    assert [sim.scene.get(wedge).name for wedge in wedges] == ["wedge", "wedge#0"]
    assert sim.scene.get(wedges[0]).kind == ObjectKind.SHAPE
    assert frames.get_position(sim, wedges[0], -1) == [0, 0, 0]
    assert sim.model.nmesh == 1
    (tmp_path / "wedge.obj").unlink()  # the points are in the scene now
    world.call("simxSetObjectPosition", wedges[0], -1, [0.0, 0.0, 2.0])
    world.call("simxRemoveObject", wedges[1])
    assert frames.get_position(sim, wedges[0], -1) == [0, 0, 2]
    sim.refresh()
    assert sim.data.geom_xpos[-1] == pytest.approx([0.25, 0.25, 2.25], abs=0.02)


def test_binary_stl_is_a_static_shape(world: World, tmp_path: Path) -> None:
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], "<f4")
    faces = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
    body = b"".join(bytes(12) + corners[list(face)].tobytes() + bytes(2) for face in faces)
    (tmp_path / "part.stl").write_bytes(bytes(80) + struct.pack("<I", len(faces)) + body)
    part = world.call("simxLoadModel", "part.stl", 0)
    world.run(3)
    assert frames.get_position(world.sim, part, -1) == [0, 0, 0]
    world.call("simxSetObjectInt32Param", part, 3003, 0)
    assert world.sim.model.body_mass[world.sim.scene.get(part).body] > 0


def test_world_of_a_model_becomes_a_body_that_can_be_moved(world: World, tmp_path: Path) -> None:
    (tmp_path / "table.xml").write_text(
        "<mujoco><worldbody><geom name='top' type='box' size='1 1 .1' pos='0 0 1'/>"
        "<geom type='box' size='.1 .1 .5' pos='0 0 .5'/><site name='corner' pos='1 1 1.1'/></worldbody></mujoco>"
    )
    sim = world.sim
    table = world.call("simxLoadModel", "table.xml", 0)
    assert sim.scene.get(table).name == "table"
    assert names_below(sim, table) == ["corner"]
    world.call("simxSetObjectPosition", table, -1, [3.0, 0.0, 0.0])
    assert frames.get_position(sim, world.handle("corner"), -1) == pytest.approx([4, 1, 1.1])


def test_vrep_name_finds_the_model_of_the_same_stem(world: World, caplog) -> None:
    with caplog.at_level(logging.INFO):
        world.call("simxLoadModel", "gripper.ttm", 0)
        world.call("simxLoadModel", "wedge.ttm", 0)
    assert "'gripper.ttm' is not there" in caplog.text
    assert world.handle("wedge")


@pytest.mark.parametrize(
    "name", ["nothing.ttm", "nothing.xml", "../nothing.xml", "/etc/passwd", "gripper.lua", "/", "..", "."]
)
def test_what_is_no_model_of_the_workspace_is_refused_and_nothing_changes(world: World, name: str) -> None:
    world.call("simxSetObjectSelection", [1])
    model, scene = world.sim.model, world.sim.scene
    with pytest.raises(CommandError):
        world.call("simxLoadModel", name, 0)
    assert world.sim.model is model
    assert world.sim.scene is scene


def test_model_with_a_wrong_annotation_or_without_objects_is_refused(world: World, tmp_path: Path) -> None:
    (tmp_path / "wrong.xml").write_text(GRIPPER.replace("simx:joint:knuckle", "simx:joint:nose"))
    (tmp_path / "empty.xml").write_text("<mujoco/>")
    with pytest.raises(CommandError, match="nose"):
        world.call("simxLoadModel", "wrong.xml", 0)
    with pytest.raises(CommandError, match="no objects"):
        world.call("simxLoadModel", "empty.xml", 0)


def test_whole_robot_is_loaded_into_an_empty_scene_and_twice() -> None:
    world = World()
    first = world.call("simxLoadModel", "ur5_rg2_kinect.ttm", 0)
    count = len(world.sim.scene.objects)
    second = world.call("simxLoadModel", "ur5_rg2_kinect.ttm", 0)
    assert len(world.sim.scene.objects) == 2 * count
    world.call("simxSetObjectPosition", second, -1, [2.0, 0.0, 0.0])
    world.call("simxSetJointTargetPosition", world.handle("UR5_joint2#0"), 0.2)
    world.run(10)
    assert world.sim.joints.position(world.handle("UR5_joint2#0")) == pytest.approx(0.2, abs=0.02)
    assert abs(world.sim.joints.position(world.handle("UR5_joint2"))) < 0.02
    assert first < second
