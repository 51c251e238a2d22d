"""Copies of objects: which come along, where they are, and that everything in them works alone."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from handler_calls import World
from scenes_for_tests import ARM

from simx_server.editing.copying import Kept, copy_objects
from simx_server.scene.objects import ObjectKind
from simx_server.scene.poses import frames

pytestmark = pytest.mark.slow

HAND = """
<mujoco>
  <option timestep="0.002" integrator="implicitfast"/>
  <worldbody>
    <body name="hand" pos="0 0 1">
      <geom name="~palm" type="box" size="0.03 0.03 0.01" mass="0.5"/>
      <site name="far" pos="0 0 0.2"/>
      <body name="thumb" pos="0.02 0 0.02">
        <joint name="thumb_joint" type="slide" axis="1 0 0" range="0 0.05" armature="0.1"/>
        <geom type="box" size="0.005 0.005 0.02" mass="0.02" contype="0" conaffinity="0"/>
        <site name="near"/>
      </body>
      <body name="finger" pos="-0.02 0 0.02">
        <joint name="finger_joint" type="slide" axis="-1 0 0" range="0 0.05" armature="0.1"/>
        <geom type="box" size="0.005 0.005 0.02" mass="0.02" contype="0" conaffinity="0"/>
      </body>
    </body>
    <body name="post"><geom size="0.05"/><site name="hook" pos="0 0 1"/></body>
  </worldbody>
  <tendon>
    <fixed name="grip"><joint joint="thumb_joint" coef="1"/></fixed>
    <spatial name="rope"><site site="far"/><site site="hook"/></spatial>
  </tendon>
  <equality><joint joint1="finger_joint" joint2="thumb_joint" solref="0.004 1"/></equality>
  <contact><exclude body1="thumb" body2="finger"/></contact>
  <actuator><velocity name="drive" tendon="grip" kv="200"/><motor tendon="rope"/></actuator>
  <sensor><rangefinder site="far"/><force site="near"/><torque site="near"/><clock/></sensor>
  <keyframe><key name="home"/></keyframe>
  <custom>
    <text name="simx:model:hand" data="base=yes"/>
    <text name="simx:joint:grip" data="parent=thumb max_force=50"/>
  </custom>
</mujoco>
"""


@pytest.fixture
def arm() -> World:
    return World(ARM)


def names(world: World, handles: list[int]) -> list[str]:
    return [world.sim.scene.get(handle).name for handle in handles]


@pytest.mark.parametrize("is_running", [False, True])
def test_copied_model_returns_its_base_only_and_has_the_state_of_the_original(is_running: bool) -> None:
    world = World(HAND)
    sim = world.sim
    if is_running:
        world.call("simxSetJointTargetVelocity", world.handle("grip"), 0.1)
        world.run(4)
    world.call("simxSetObjectSelection", [world.handle("post")])
    before = set(sim.scene.objects)
    thumb = sim.joints.position(world.handle("thumb_joint"))
    (copy,) = world.call("simxCopyPasteObjects", [world.handle("hand")])
    assert sim.scene.get(copy).name == "hand#0"
    assert copy > max(before)
    assert sorted(names(world, sim.scene.descendants(copy))) == [
        "far#0", "finger#0", "finger_joint#0", "grip#0", "near#0", "thumb#0", "thumb_joint#0",
    ]  # fmt: skip
    assert world.call("simxGetObjectSelection") == [world.handle("post")]
    assert world.call("simxGetModelProperty", copy) == 0
    assert sim.joints.position(world.handle("thumb_joint#0")) == thumb
    assert sim.scene.get(world.handle("grip#0")).parent == world.handle("thumb#0")
    for name in ("hand", "thumb", "near", "finger"):
        original, twin = (frames.get_position(sim, world.handle(name + n), -1) for n in ("", "#0"))
        assert twin == pytest.approx(original, abs=1e-12)
    assert sim.model.nkey == 1
    assert sim.model.nexclude == 2


def test_motors_equalities_tendons_and_sensors_work_in_the_copy_alone() -> None:
    world = World(HAND)
    sim = world.sim
    (copy,) = world.call("simxCopyPasteObjects", [world.handle("hand")])
    world.call("simxSetObjectPosition", copy, -1, [1.0, 0.0, 1.0])
    world.call("simxSetJointTargetVelocity", world.handle("grip#0"), 0.1)
    assert world.call("simxGetJointMaxForce", world.handle("grip#0")) == 50
    world.run(6)
    moved = [sim.joints.position(world.handle(n)) for n in ("thumb_joint#0", "finger_joint#0")]
    assert moved == pytest.approx([0.03, 0.03], abs=0.003)
    still = [sim.joints.position(world.handle(n)) for n in ("thumb_joint", "finger_joint")]
    assert still == pytest.approx([0, 0], abs=1e-3)
    assert sim.scene.get(world.handle("far#0")).kind == ObjectKind.PROXIMITY_SENSOR
    assert sim.scene.get(world.handle("near#0")).kind == ObjectKind.FORCE_SENSOR
    state, force, _ = world.call("simxReadForceSensor", world.handle("near#0"))
    assert state == 1
    assert math.hypot(*force) > 0.01
    # The rope reaches to the post, which was not copied.
    with pytest.raises(Exception, match="rope#0"):
        world.handle("rope#0")


def test_shapes_of_a_mechanism_are_copied_by_themselves_and_fall(arm: World) -> None:
    sim = arm.sim
    arm.call("simxSetJointPosition", arm.handle("elbow"), -0.5)
    arm.run(2)
    copies = arm.call("simxCopyPasteObjects", [arm.handle("lower"), arm.handle("hand")])
    assert names(arm, copies) == ["lower#0", "hand#0"]
    lower, hand = copies
    assert sim.scene.get(hand).parent == lower
    assert sim.scene.children(hand) == []
    before = frames.get_position(sim, lower, -1)
    assert before == pytest.approx(frames.get_position(sim, arm.handle("lower"), -1), abs=1e-9)
    quaternion = frames.get_quaternion(sim, lower, -1)
    assert quaternion == pytest.approx(frames.get_quaternion(sim, arm.handle("lower"), -1), abs=1e-9)
    arm.parts.step()
    assert frames.get_position(sim, lower, -1)[2] < before[2] - 0.005


def test_copied_joint_without_its_link_is_a_joint_that_can_be_set(arm: World) -> None:
    sim = arm.sim
    arm.call("simxSetJointPosition", arm.handle("shoulder"), 0.5)
    (elbow,) = arm.call("simxCopyPasteObjects", [arm.handle("elbow")])
    assert sim.scene.get(elbow).kind == ObjectKind.JOINT
    assert sim.scene.get(elbow).parent == -1
    assert sim.scene.children(elbow) == []
    fixed = frames.get_position(sim, elbow, -1)
    assert fixed == pytest.approx(frames.get_position(sim, arm.handle("elbow"), -1), abs=1e-9)
    arm.call("simxSetJointPosition", elbow, 1.0)
    assert sim.joints.position(elbow) == 1.0
    assert sim.joints.position(arm.handle("elbow")) == 0.0
    arm.run(2)


def test_joint_with_its_link_keeps_the_joint(arm: World) -> None:
    sim = arm.sim
    arm.call("simxSetJointPosition", arm.handle("shoulder"), 0.5)
    copies = arm.call(
        "simxCopyPasteObjects", [arm.handle(n) for n in ("shoulder", "upper", "elbow", "lower")]
    )
    shoulder, upper, elbow, lower = copies
    assert [sim.scene.get(h).parent for h in copies] == [-1, shoulder, upper, elbow]
    assert sim.joints.position(shoulder) == 0.5
    assert frames.get_position(sim, lower, -1) == pytest.approx(
        frames.get_position(sim, arm.handle("lower"), -1), abs=1e-9
    )
    arm.call("simxSetJointTargetPosition", elbow, 0.3)
    arm.run(20)
    assert sim.joints.position(elbow) == pytest.approx(0.3, abs=0.01)


def test_joint_settings_of_the_moment_are_copied(arm: World) -> None:
    arm.call("simxSetJointMaxForce", arm.handle("elbow"), 7.0)
    arm.call("simxSetObjectInt32Param", arm.handle("elbow"), 2000, 0)
    (base,) = arm.call("simxCopyPasteObjects", [arm.handle("base")])
    assert arm.sim.scene.children(base) == []
    arm.call("simxSetModelProperty", arm.handle("base"), 0)
    arm.call("simxCopyPasteObjects", [arm.handle("base")])
    assert arm.call("simxGetJointMaxForce", arm.handle("elbow#1")) == 7.0
    assert arm.call("simxGetObjectInt32Param", arm.handle("elbow#1"), 2000) == 0


def test_free_and_static_shapes_leaves_and_world_parts_are_copied(arm: World) -> None:
    sim = arm.sim
    arm.run(2)
    wanted = ["cube", "wall", "eye", "mount", "tip", "sun", "floor"]
    copies = arm.call("simxCopyPasteObjects", [arm.handle(n) for n in wanted])
    assert names(arm, copies) == [f"{name}#0" for name in wanted]
    for name, copy in zip(wanted, copies, strict=True):
        item = sim.scene.get(copy)
        assert item.kind == sim.scene.get(arm.handle(name)).kind
        assert item.parent == -1
        assert frames.get_position(sim, copy, -1) == pytest.approx(
            frames.get_position(sim, arm.handle(name), -1), abs=1e-9
        )
    arm.parts.step()
    sim.stop()
    assert len(sim.scene.objects) == 14


def test_vision_sensor_settings_of_the_moment_are_copied(arm: World) -> None:
    eye = arm.handle("eye")
    arm.call("simxSetObjectInt32Param", eye, 1002, 32)
    (copy,) = arm.call("simxCopyPasteObjects", [eye])
    assert arm.call("simxGetObjectInt32Param", copy, 1002) == 32


def test_unknown_handles_are_skipped_and_nothing_gives_an_empty_list(arm: World) -> None:
    assert arm.call("simxCopyPasteObjects", [999, -1, 0]) == []
    assert names(arm, arm.call("simxCopyPasteObjects", [999, arm.handle("wall"), arm.handle("wall")])) == [
        "wall#0"
    ]


def test_copy_of_a_copy_gets_the_next_number_and_a_freed_number_is_used_again(arm: World) -> None:
    (first,) = arm.call("simxCopyPasteObjects", [arm.handle("wall")])
    (second,) = arm.call("simxCopyPasteObjects", [first])
    assert names(arm, [first, second]) == ["wall#0", "wall#1"]
    arm.call("simxRemoveObject", first)
    (third,) = arm.call("simxCopyPasteObjects", [second])
    assert names(arm, [third]) == ["wall#2"]
    (fourth,) = arm.call("simxCopyPasteObjects", [arm.handle("wall")])
    assert names(arm, [fourth]) == ["wall#0"]
    assert fourth > third


def test_copied_body_in_a_gripper_and_what_holds_it_stay_apart(arm: World) -> None:
    sim = arm.sim
    arm.run(1)
    arm.call("simxSetObjectParent", arm.handle("cube"), arm.handle("mount"), True)
    (cube,) = arm.call("simxCopyPasteObjects", [arm.handle("cube")])
    assert sim.scene.get(cube).parent == -1
    assert sim.scene.get(arm.handle("cube")).parent == arm.handle("mount")
    before = frames.get_position(sim, cube, -1)
    arm.call("simxSetObjectPosition", cube, -1, [3.0, 3.0, 1.0])
    arm.parts.step()
    assert frames.get_position(sim, cube, -1)[2] < 1.0
    assert before[2] > 0


def test_everything_can_be_copied_at_once_and_runs_like_the_original(arm: World) -> None:
    sim = arm.sim
    arm.call("simxCopyPasteObjects", list(sim.scene.objects))
    base, cube = arm.handle("base#0"), arm.handle("cube#0")
    for handle, position in ((base, [0.5, 10.0, 0.1]), (cube, [0.0, 11.0, 0.05])):
        arm.call("simxSetObjectPosition", handle, -1, position)
    for number in ("", "#0"):
        arm.call("simxSetJointTargetPosition", arm.handle(f"shoulder{number}"), 0.7)
    arm.run(10)
    angles = [sim.joints.position(arm.handle(f"shoulder{number}")) for number in ("", "#0")]
    assert np.allclose(angles, angles[0], atol=1e-6)


def test_a_copy_of_a_copy_of_a_copy_costs_what_the_first_one_did() -> None:
    """Default classes, frames and attached specs doubled with each: the ninth took nine seconds."""
    world = World(
        '<mujoco><default><default class="red"><geom rgba="1 0 0 1"/></default></default><worldbody>'
        '<frame pos="1 0 0"><body name="box"><frame pos="0 0 1"><geom class="red" size=".1"/></frame></body></frame>'
        "</worldbody></mujoco>"
    )
    sizes, handle = [len(world.sim.scene.spec.to_xml())], world.handle("box")
    for _ in range(12):
        (handle,) = world.call("simxCopyPasteObjects", [handle])
        sizes.append(len(world.sim.scene.spec.to_xml()))
    assert max(after - before for before, after in pairwise(sizes)) < 2 * (sizes[1] - sizes[0])
    assert (world.sim.model.geom_rgba == (1, 0, 0, 1)).all()
    assert np.allclose(world.call("simxGetObjectPosition", handle, -1), (1, 0, 0))


def test_frames_of_a_moved_body_stay_apart() -> None:
    world = World(
        '<mujoco><worldbody><body name="base"/><body name="arm"><frame pos="0 1 0"><site name="left"/></frame>'
        '<frame pos="0 -1 0"><site name="right"/></frame></body></worldbody></mujoco>'
    )
    world.call("simxSetObjectParent", world.handle("arm"), world.handle("base"), True)
    assert np.allclose(world.call("simxGetObjectPosition", world.handle("left"), -1), (0, 1, 0))
    assert np.allclose(world.call("simxGetObjectPosition", world.handle("right"), -1), (0, -1, 0))


def test_a_fixed_body_without_mass_below_another_is_copied() -> None:
    """MuJoCo gives it a centre of mass that the copy, which stands in the world, would not have."""
    world = World(
        """<mujoco><worldbody><body name="floor"><body name="slab" pos="0 0 -0.02"><geom type="plane" size="1 1 1"/>
        <body name="sheet" pos="0 0 0.02"><geom type="plane" size="1 1 1"/></body></body></body></worldbody></mujoco>"""
    )
    copies = world.call("simxCopyPasteObjects", [world.handle("sheet")])
    assert names(world, copies) == ["sheet#0"]


def test_a_copy_may_go_without_textures() -> None:
    world = World("""<mujoco><asset>
      <texture name="tiles" type="2d" builtin="checker" rgb1="1 0 0" rgb2="0 1 0" width="8" height="8"/>
      <material name="floor" texture="tiles" rgba="0.1 0.2 0.3 1"/></asset>
      <worldbody><body name="box"><geom name="~side" type="box" size="0.1 0.1 0.1" material="floor"/></body>
      </worldbody></mujoco>""")
    box = world.handle("box")
    (plain,) = copy_objects(world.parts, [box], Kept(textures=False))
    (textured,) = copy_objects(world.parts, [box])
    geoms = [
        int(world.sim.model.body_geomadr[world.sim.scene.get(handle).id]) for handle in (box, plain, textured)
    ]
    materials = [int(world.sim.model.geom_matid[geom]) for geom in geoms]
    assert materials[1] == -1
    assert materials[0] == materials[2] >= 0
    assert world.sim.model.geom_rgba[geoms[1]].tolist() == pytest.approx([0.1, 0.2, 0.3, 1])


def test_a_copy_of_a_loaded_model_has_its_force_sensors(tmp_path: Path) -> None:
    (tmp_path / "hand.xml").write_text(
        '<mujoco><worldbody><body name="hand"><geom size="0.1"/><body name="held" pos="0 0 -1"><site name="feel"/>'
        '<geom size="0.1" mass="2"/></body></body></worldbody>'
        '<sensor><force site="feel"/><torque site="feel"/></sensor>'
        '<custom><text name="simx:model:hand" data="base=yes"/></custom></mujoco>'
    )
    world = World(workspace=tmp_path)
    base = world.call("simxLoadModel", "hand.xml", 0)
    world.call("simxCopyPasteObjects", [base])
    world.run(2)
    forces = [world.parts.force.read(world.handle(name)) for name in ("feel", "feel#0")]
    assert forces[0] is not None
    assert forces[1] is not None
    assert forces[1].force == pytest.approx(forces[0].force)
    assert abs(forces[0].force[2]) == pytest.approx(2 * 9.81, rel=1e-3)
