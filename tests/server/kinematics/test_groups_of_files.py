"""IK groups as V-REP's files have them: several tips, weights, conditions, and when joints stay where they are."""

from __future__ import annotations

import math

import pytest
from handler_calls import World

from simx_server.kinematics import Result
from simx_server.kinematics.group import Group
from simx_server.scene.formats.annotations import SceneError
from simx_server.scene.poses.frames import get_pose, get_position, set_position
from simx_server.scene.poses.poses import conjugate, multiply, rotation_vector

TWO_ARMS = """
<mujoco><option gravity="0 0 0"/><worldbody>
  <body name="base"><geom size="0.05"/>
    <body name="left"><joint name="l1" axis="0 0 1"/><geom type="capsule" fromto="0 0 0 0.5 0 0" size="0.02"/>
      <body pos="0.5 0 0"><joint name="l2" axis="0 0 1"/><geom type="capsule" fromto="0 0 0 0.5 0 0" size="0.02"/>
        <site name="left_tip" pos="0.5 0 0"/></body></body>
    <body name="right" pos="0 -2 0"><joint name="r1" axis="0 0 1"/>
      <geom type="capsule" fromto="0 0 0 0.5 0 0" size="0.02"/>
      <body pos="0.5 0 0"><joint name="r2" axis="0 0 1"/><geom type="capsule" fromto="0 0 0 0.5 0 0" size="0.02"/>
        <site name="right_tip" pos="0.5 0 0"/></body></body>
  </body>
  <body name="goal" pos="0.6 0.4 0" mocap="true"/><body name="other" pos="0.6 -1.6 0" mocap="true"/>
</worldbody><custom>
  <text name="simx:joint:l1" data="mode=ik"/><text name="simx:joint:l2" data="mode=ik"/>
  <text name="simx:joint:r1" data="mode=ik"/><text name="simx:joint:r2" data="mode=ik"/>
  {}
</custom></mujoco>
"""
BENT = {"l1": 0.2, "l2": 0.5, "r1": 0.2, "r2": 0.5}


def world_with(**groups: str) -> World:
    notes = "".join(f'<text name="simx:ik:{name}" data="{data}"/>' for name, data in groups.items())
    world = World(TWO_ARMS.format(notes))
    for joint, value in BENT.items():
        world.sim.joints.set_position(world.sim.scene.resolve(joint), value)
    return world


def handle(world: World, name: str = "both") -> Result:
    return world.parts.ik_groups.handle(world.parts.ik_groups.find(name))


def group(world: World, name: str = "both") -> Group:
    return world.parts.ik_groups.get(world.parts.ik_groups.find(name))


def miss(world: World, tip: str, target: str) -> float:
    scene = world.sim.scene
    world.sim.refresh()
    return math.dist(
        get_position(world.sim, scene.resolve(tip)), get_position(world.sim, scene.resolve(target))
    )


def joints(world: World) -> list[float]:
    return [world.sim.joints.position(world.sim.scene.resolve(name)) for name in BENT]


def put(world: World, name: str, x: float, y: float) -> None:
    set_position(world.sim, world.sim.scene.resolve(name), -1, (x, y, 0.0))


BOTH = "tip=left_tip;right_tip target=goal;other constraints=x,y iterations=100"


def test_a_group_brings_several_tips_to_their_targets() -> None:
    world = world_with(both=BOTH)
    assert handle(world) == Result.SUCCESS
    assert miss(world, "left_tip", "goal") < 1e-3
    assert miss(world, "right_tip", "other") < 1e-3


def test_each_tip_has_its_own_settings() -> None:
    data = "tip=left_tip;right_tip target=goal;other base=left;world constraints=x;pose"
    data += " precision=0.1,0.2;0.3,0.4 weights=1,2;3,4"
    world = world_with(both=data)
    first, second = group(world).elements
    assert (int(first.constraints), int(second.constraints)) == (1, 31)
    assert (first.precision, second.precision) == ((0.1, 0.2), (0.3, 0.4))
    assert (first.weights, second.weights) == ((1.0, 2.0), (3.0, 4.0))
    assert (first.base, second.base) == (world.sim.scene.by_name("left"), -1)


@pytest.mark.parametrize(
    ("data", "problem"),
    [
        ("tip=left_tip;right_tip target=goal", "has 2 in tip= and 1 in target="),
        ("tip=left_tip;right_tip target=goal;other weights=1,1;1,1;1,1", "has 2 in tip= and 3 in weights="),
        ("tip=left_tip;nobody target=goal;other", "tip=nobody"),
        ("tip=left_tip target=goal base=nobody", "base=nobody"),
        ("tip=left_tip target=goal after=nobody", "after=nobody, which is no group"),
        ("tip=left_tip target=goal constraints=x;what", "valid for constraints"),
    ],
)
def test_wrong_groups_are_refused(data: str, problem: str) -> None:
    with pytest.raises(SceneError, match=problem):
        world_with(both=data)


def test_joints_stay_when_a_target_that_must_be_reached_is_too_far() -> None:
    world = world_with(both="tip=left_tip target=goal constraints=x,y restore=position")
    put(world, "goal", 5.0, 0.0)
    assert handle(world) == Result.FAIL
    assert joints(world) == list(BENT.values())


def test_without_that_they_go_as_near_as_they_can() -> None:
    world = world_with(both="tip=left_tip target=goal constraints=x,y iterations=200")
    put(world, "goal", 5.0, 0.0)
    assert handle(world) == Result.FAIL
    assert miss(world, "left_tip", "goal") == pytest.approx(4.0, abs=0.01)


def test_restoring_orientation_does_not_care_for_the_position() -> None:
    world = world_with(both="tip=left_tip target=goal constraints=x,y restore=orientation")
    put(world, "goal", 5.0, 0.0)
    assert handle(world) == Result.FAIL
    assert joints(world) != list(BENT.values())


def test_a_group_waits_for_the_failure_of_another() -> None:
    alone = "tip=left_tip target=goal constraints=x,y iterations=100"
    world = world_with(first=f"{alone} restore=position", second=f"{alone} after=first")
    assert world.parts.ik_groups.handle_automatic() == 2
    assert (group(world, "first").result, group(world, "second").result) == (
        Result.SUCCESS,
        Result.NOT_PERFORMED,
    )
    put(world, "goal", 5.0, 0.0)
    world.parts.ik_groups.handle_automatic()
    assert (group(world, "first").result, group(world, "second").result) == (Result.FAIL, Result.FAIL)
    assert miss(world, "left_tip", "goal") < 4.1


def test_a_group_that_is_off_moves_nothing() -> None:
    world = world_with(both=f"{BOTH} enabled=no")
    assert handle(world) == Result.NOT_PERFORMED
    assert joints(world) == list(BENT.values())


def test_a_weight_of_zero_gives_up_a_tip() -> None:
    world = world_with(both=f"{BOTH} weights=0,0;1,1")
    handle(world)
    assert joints(world)[:2] == pytest.approx([0.2, 0.5])
    assert miss(world, "right_tip", "other") < 1e-3


SPIN = """
<mujoco><option gravity="0 0 0"/><worldbody>
  <body name="a"><joint name="roll" axis="1 0 0"/><geom size="0.05"/>
    <body name="b" pos="0 0 0.2"><joint name="yaw" axis="0 0 1"/><geom size="0.05"/><site name="tip"/></body></body>
  <body name="goal" mocap="true" quat="0.8 0.3 0 0.5"/>
</worldbody><custom>
  <text name="simx:joint:roll" data="mode=ik"/><text name="simx:joint:yaw" data="mode=ik"/>
  <text name="simx:ik:spin" data="tip=tip target=goal constraints={} iterations=200 damping=0.01"/>
</custom></mujoco>
"""


def test_gamma_alone_turns_about_the_tips_own_axis() -> None:
    world = World(SPIN.format("gamma"))
    assert handle(world, "spin") == Result.SUCCESS
    roll, yaw = (world.sim.joints.position(world.sim.scene.resolve(name)) for name in ("roll", "yaw"))
    assert roll == pytest.approx(0.0, abs=1e-6)
    assert yaw == pytest.approx(2 * math.atan2(0.5, 0.8), abs=2e-3)


def test_direction_and_gamma_together_turn_all() -> None:
    world = World(SPIN.format("alpha_beta,gamma"))
    handle(world, "spin")
    world.sim.refresh()
    _, quat = get_pose(world.sim, world.sim.scene.resolve("tip"))
    assert abs(quat[1]) > 0.05


SHOULDER = """
<mujoco><option gravity="0 0 0"/><worldbody>
  <body name="base"><geom size="0.05"/>
    <body name="arm" quat="0.9 0.1 0.2 0.3"><joint name="shoulder" type="ball"/>
      <geom type="capsule" fromto="0 0 0 0.5 0 0" size="0.02"/>
      <body pos="0.5 0 0"><joint name="elbow" axis="0 0 1" range="-150 150"/>
        <geom type="capsule" fromto="0 0 0 0.5 0 0" size="0.02"/><site name="hand" pos="0.5 0 0"/></body></body>
  </body>
  <body name="goal" pos="0.1 0.4 -0.5" quat="0.5 0.1 0.7 0.2" mocap="true"/>
</worldbody><custom>
  <text name="simx:joint:shoulder" data="mode=ik"/><text name="simx:joint:elbow" data="mode=ik"/>
  <text name="simx:ik:reach" data="tip=hand target=goal constraints={} iterations=100"/>
</custom></mujoco>
"""


def test_a_spherical_joint_takes_part() -> None:
    world = World(SHOULDER.format("position"))
    world.sim.joints.set_position(world.sim.scene.resolve("elbow"), 0.7)
    assert handle(world, "reach") == Result.SUCCESS
    assert miss(world, "hand", "goal") < 1e-3


def test_a_spherical_joint_alone_turns_the_tip_as_the_target() -> None:
    fixed = '"simx:joint:elbow" data="mode={}"'
    world = World(SHOULDER.format("orientation").replace(fixed.format("ik"), fixed.format("passive")))
    assert handle(world, "reach") == Result.SUCCESS
    world.sim.refresh()
    tip, target = (get_pose(world.sim, world.sim.scene.resolve(name))[1] for name in ("hand", "goal"))
    assert math.hypot(*rotation_vector(multiply(conjugate(tip), target))) < 2e-3


def test_a_spherical_joint_keeps_its_turn_in_a_run() -> None:
    world = World(SHOULDER.format("position"))
    world.sim.joints.set_position(world.sim.scene.resolve("elbow"), 0.7)
    world.call("simxStartSimulation")
    for _ in range(5):
        world.parts.step()
    assert miss(world, "hand", "goal") < 1e-3


def test_searching_for_configurations_moves_no_spherical_joint() -> None:
    world = World(SHOULDER.format("position"))
    joints, _ = world.parts.ik_groups.solver(group(world, "reach"))
    assert (len(joints.handles), len(joints.dofs), joints.balls) == (1, 1, ())


@pytest.mark.parametrize(("weight", "share"), [(1.0, 0.8), (0.01, 0.2), (0.0, 0.0)])
def test_a_joint_of_little_weight_moves_less(weight: float, share: float) -> None:
    world = world_with(both="tip=left_tip target=goal constraints=y damping=0 iterations=200")
    world.sim.joints.change(world.sim.scene.resolve("l2"), ik_weight=weight)
    assert handle(world) == Result.SUCCESS
    first, second = (now - BENT[name] for name, now in zip(BENT, joints(world)[:2], strict=False))
    assert abs(second) <= share * abs(first) + 1e-6
    assert (abs(second) > 1e-3) == (weight > 0.5)
