"""Inverse kinematics: groups of a scene, what scripts do with them, and simIK's environments."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scenes_for_tests import world_of
from sim_api_calls import ScriptWorld

from simx_server.editing.copying import copy_objects
from simx_server.errors import CommandError
from simx_server.files.library import find_scene
from simx_server.kinematics import Element, Result
from simx_server.kinematics.environment import Environment, EnvironmentGroup
from simx_server.kinematics.search import find_configs
from simx_server.scene.formats.annotations import SceneError
from simx_server.scene.poses.frames import get_pose, get_position, set_pose, set_position
from simx_server.scene.poses.poses import conjugate, multiply, rotation_vector
from simx_server.simulation.simulation import Simulation
from simx_server.world.world import World

pytestmark = pytest.mark.slow

ARM = """
<mujoco model="arm">
  <compiler angle="degree"/>
  <option gravity="0 0 0"/>
  <worldbody>
    <body name="base">
      <geom type="cylinder" size=".05 .05"/>
      <site name="target" pos=".3 .1 .4"/>
      <body name="link1" pos="0 0 .1"><joint name="j1" axis="0 0 1" range="-170 170"/>
        <geom type="capsule" fromto="0 0 0 0 0 .1" size=".04"/>
        <body name="link2" pos="0 0 .1"><joint name="j2" axis="0 1 0" range="-120 120"/>
          <geom type="capsule" fromto="0 0 0 0 0 .3" size=".04"/>
          <body name="link3" pos="0 0 .3"><joint name="j3" axis="0 1 0" range="-150 150"/>
            <geom type="capsule" fromto="0 0 0 0 0 .3" size=".03"/>
            <body name="link4" pos="0 0 .3"><joint name="j4" axis="0 1 0" range="-120 120"/>
              <geom type="capsule" fromto="0 0 0 0 0 .05" size=".03"/>
              <body name="link5" pos="0 0 .08"><joint name="j5" axis="1 0 0" range="-120 120"/>
                <geom type="capsule" fromto="0 0 0 0 0 .05" size=".03"/>
                <body name="link6" pos="0 0 .05"><joint name="j6" axis="0 0 1" range="-170 170"/>
                  <geom type="box" size=".03 .02 .02"/><site name="tip" pos="0 0 .05"/>
    </body></body></body></body></body></body></body>
  </worldbody>
  <custom>
    <text name="simx:joint:j1" data="mode=ik"/><text name="simx:joint:j2" data="mode=ik"/>
    <text name="simx:joint:j3" data="mode=ik"/><text name="simx:joint:j4" data="mode=ik"/>
    <text name="simx:joint:j5" data="mode=ik"/><text name="simx:joint:j6" data="mode=ik"/>
    <text name="simx:model:base" data="base=yes"/>
    <text name="simx:ik:arm_ik" data="tip=tip target=target base=base constraints=position"/>
  </custom>
</mujoco>
"""
"""A target within the reach of 0.78 m about the second joint; it hangs on the base."""

JOINTS = [f"j{number}" for number in range(1, 7)]
LUA_JOINTS = "local js = {}; for i = 1, 6 do js[i] = sim.getObjectHandle('j' .. i) end\n"
TO_GROUP = "local g = sim.getIkGroupHandle('arm_ik')\n"


def world_with(xml: str, folder: Path) -> World:
    file = folder / "arm.xml"
    file.write_text(xml, encoding="utf-8")
    return world_of(file, workspace=folder)


def miss(sim: Simulation, tip: str = "tip", target: str = "target") -> tuple[float, float]:
    """Metres and radians between two objects."""
    a, b = (get_pose(sim, sim.scene.resolve(name)) for name in (tip, target))
    return math.dist(a[0], b[0]), math.hypot(*rotation_vector(multiply(conjugate(a[1]), b[1])))


def bend(sim: Simulation) -> None:
    """Away from the stretched arm, which is singular."""
    for name, value in zip(JOINTS, (0.2, 0.5, 0.9, 0.6, 0.1, 0.0), strict=True):
        sim.joints.set_position(sim.scene.resolve(name), value)


@pytest.fixture
def parts(tmp_path: Path) -> World:
    return world_with(ARM, tmp_path)


@pytest.fixture
def sim(parts: World) -> Simulation:
    return parts.simulation


@pytest.fixture
def world(tmp_path: Path) -> ScriptWorld:
    # A position is solved for by hand here, so that nothing moves before a test says so.
    return ScriptWorld(tmp_path, ARM.replace("constraints=position", "handling=explicit"), owner="base")


def test_the_tip_follows_its_target_in_each_step(parts: World) -> None:
    sim = parts.simulation
    sim.start()
    target = sim.scene.resolve("target")
    for index in range(40):
        set_position(sim, target, -1, [0.3 + 0.1 * math.sin(index / 5), 0.1, 0.4])
        parts.step()
        assert miss(sim)[0] < 1e-3


def test_the_stop_brings_the_joints_back(parts: World) -> None:
    sim = parts.simulation
    before = sim.data.qpos.copy()
    sim.start()
    parts.step()
    assert not np.array_equal(sim.data.qpos, before)
    sim.stop()
    assert np.array_equal(sim.data.qpos, before)


def test_equal_runs_give_equal_numbers(parts: World) -> None:
    sim = parts.simulation
    ends: list[bytes] = []
    for _ in range(2):
        sim.start()
        for _ in range(5):
            parts.step()
        ends.append(sim.data.qpos.tobytes())
        sim.stop()
    assert ends[0] == ends[1]


def test_a_target_out_of_reach_is_approached_and_fails(parts: World) -> None:
    sim = parts.simulation
    sim.start()
    set_position(sim, sim.scene.resolve("target"), -1, [2.0, 0.0, 0.5])
    for _ in range(20):
        parts.step()
    group = parts.ik_groups.find("arm_ik")
    assert parts.ik_groups.get(group).result == Result.FAIL
    shoulder = [0.0, 0.0, 0.2]
    reach = math.dist(get_position(sim, sim.scene.resolve("tip")), shoulder)
    assert reach == pytest.approx(0.78, abs=1e-3)
    assert miss(sim)[0] == pytest.approx(math.dist([2.0, 0.0, 0.5], shoulder) - 0.78, abs=1e-3)


def test_joints_in_another_mode_stay_and_the_log_says_when_none_is_left(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    world = world_with(ARM.replace("mode=ik", "mode=passive"), tmp_path)
    sim = world.simulation
    sim.start()
    before = sim.data.qpos.copy()
    for _ in range(3):
        world.step()
    assert np.array_equal(sim.data.qpos, before)
    assert [record.getMessage() for record in caplog.records if "arm_ik" in record.getMessage()] != []
    assert len([record for record in caplog.records if "arm_ik" in record.getMessage()]) == 1


def test_a_second_copy_of_the_model_has_its_own_group(parts: World) -> None:
    sim = parts.simulation
    (copy,) = _copy(parts, "base")
    assert parts.ik_groups.names() == ["arm_ik", "arm_ik#0"]
    set_position(sim, copy, -1, [1.0, 0.0, 0.0])
    sim.start()
    for _ in range(3):
        parts.step()
    assert miss(sim, "tip#0", "target#0")[0] < 1e-3
    assert get_position(sim, sim.scene.resolve("tip#0"))[0] > 1.2


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ("tip=nobody target=target", "tip=nobody"),
        ("tip=tip", "target="),
        ("tip=tip target=target constraints=all", "constraints"),
        ("tip=tip target=target handling=never", "handling"),
    ],
)
def test_a_bad_annotation_is_refused(tmp_path: Path, words: str, says: str) -> None:
    wrong = ARM.replace("tip=tip target=target base=base constraints=position", words)
    with pytest.raises(SceneError, match=says):
        world_with(wrong, tmp_path)


def test_twenty_reachable_poses_of_the_tutorials_robot_are_found(tmp_path: Path) -> None:
    sim = world_of(find_scene("ur5_rg2_kinect"), workspace=tmp_path).simulation

    base, tip, target = (sim.scene.resolve(name) for name in ("UR5", "UR5_ikTip", "UR5_ikTarget"))
    handles = [sim.scene.resolve(f"UR5_joint{number}") for number in range(1, 7)]
    environment, group = Environment(sim), EnvironmentGroup("arm")
    environment.add(group, Element(tip, target, base))
    random = np.random.default_rng(7)
    for _ in range(20):
        wanted = random.uniform(-math.pi, math.pi, 6)
        for handle, value in zip(handles, wanted.tolist(), strict=True):
            environment.set_joint_position(handle, value)
        environment.set_pose(target, -1, environment.pose(tip))
        goals = environment.goals(group)
        joints, solver = environment.solver(group)
        found = next(find_configs(solver, joints, goals, random, seconds=5.0), None)
        assert found is not None
        for handle, value in zip(joints.handles, found.tolist(), strict=True):
            sim.joints.set_position(handle, value)
        sim.refresh()
        reached, goal = get_pose(sim, tip), goals[0]
        assert math.dist(reached[0], goal[0]) < 1e-3
        assert math.hypot(*rotation_vector(multiply(conjugate(reached[1]), goal[1]))) < math.radians(0.5)


def test_a_script_handles_a_group_and_changes_how(world: ScriptWorld) -> None:
    assert world.lua(
        TO_GROUP + "return sim.getExplicitHandling(g), sim.handleIkGroup(sim.handle_all_except_explicit)"
    ) == [
        1,
        0,
    ]
    set_pose(world.sim, world.sim.scene.resolve("target"), -1, ((0.3, 0.1, 0.4), (0.0, 1.0, 0.0, 0.0)))
    bend(world.sim)
    for _ in range(10):
        result = world.value("sim.handleIkGroup(sim.getIkGroupHandle('arm_ik'))")
    assert result == 1
    assert miss(world.sim) == (pytest.approx(0, abs=5e-4), pytest.approx(0, abs=2e-3))
    world.lua(TO_GROUP + "sim.setIkElementProperties(g, sim.getObjectHandle('tip'), sim.ik_x_constraint)")
    assert world.lua(TO_GROUP + "local m, size = sim.getIkGroupMatrix(g, 0) return #m, size") == [6, [6, 1]]
    world.lua(TO_GROUP + "sim.setIkGroupProperties(g, sim.ik_pseudo_inverse_method, 50, 0)")
    world.lua(TO_GROUP + "sim.setExplicitHandling(g, 0)")
    world.passes(1)
    world.sim.stop()
    world.sim.start()
    assert world.lua(TO_GROUP + "return sim.getExplicitHandling(g)") == [1]
    world.fails("sim.getIkGroupHandle('leg')", "arm_ik")


def test_a_script_finds_values_for_a_tip_pose_without_moving(world: ScriptWorld) -> None:
    set_pose(world.sim, world.sim.scene.resolve("target"), -1, ((0.3, 0.1, 0.4), (0.0, 1.0, 0.0, 0.0)))
    before = world.sim.data.qpos.copy()
    values = world.value(
        "(function() " + LUA_JOINTS + TO_GROUP + "return sim.getConfigForTipPose(g, js, 0.65, 3000) end)()"
    )
    assert np.array_equal(world.sim.data.qpos, before)
    for name, value in zip(JOINTS, values, strict=True):
        world.sim.joints.set_position(world.sim.scene.resolve(name), value)
    assert miss(world.sim) == (pytest.approx(0, abs=1e-3), pytest.approx(0, abs=math.radians(0.5)))
    set_position(world.sim, world.sim.scene.resolve("target"), -1, [3.0, 0.0, 0.0])
    assert world.lua(LUA_JOINTS + TO_GROUP + "return (sim.getConfigForTipPose(g, js, 0.65, 50))") == [None]
    world.fails(TO_GROUP + "sim.getConfigForTipPose(g, {1}, 0.65, 50)", "needs a joint")


def test_the_joints_that_a_script_lists_move_in_any_mode_and_in_its_order(world: ScriptWorld) -> None:
    passive = "for _, j in ipairs(js) do sim.setJointMode(j, sim.jointmode_passive, 0) end\n"
    set_pose(world.sim, world.sim.scene.resolve("target"), -1, ((0.3, 0.1, 0.4), (0.0, 1.0, 0.0, 0.0)))
    turned, one, path = world.lua(
        LUA_JOINTS
        + TO_GROUP
        + passive
        + """
        local back = {}
        for i = #js, 1, -1 do back[#back + 1] = js[i] end
        local turned = sim.getConfigForTipPose(g, back, 0.65, 3000)
        for i, j in ipairs(js) do sim.setJointMode(j, sim.jointmode_ik, 0) end
        local one = sim.getConfigForTipPose(g, {js[2]}, 0.65, 50)
        for i, j in ipairs(back) do sim.setJointPosition(j, turned[i]) end
        return turned, one, sim.generateIkPath(g, {js[2], js[1]}, 3)
        """
    )
    for name, value in zip(reversed(JOINTS), turned, strict=True):
        world.sim.joints.set_position(world.sim.scene.resolve(name), value)
    assert miss(world.sim) == (pytest.approx(0, abs=1e-3), pytest.approx(0, abs=math.radians(0.5)))
    assert one is None, "joints that are not listed are locked, also those in IK mode"
    assert path == pytest.approx([turned[-2], turned[-1]] * 3, abs=1e-2)


def test_a_straight_path_ends_at_the_target(world: ScriptWorld) -> None:
    bend(world.sim)
    tip = get_pose(world.sim, world.sim.scene.resolve("tip"))
    end = ((tip[0][0], tip[0][1] + 0.1, tip[0][2]), tip[1])
    set_pose(world.sim, world.sim.scene.resolve("target"), -1, end)
    path = world.value("(function() " + LUA_JOINTS + TO_GROUP + "return sim.generateIkPath(g, js, 11) end)()")
    states = [path[start : start + 6] for start in range(0, len(path), 6)]
    assert len(states) == 11
    for share, state in enumerate(states):
        for name, value in zip(JOINTS, state, strict=True):
            world.sim.joints.set_position(world.sim.scene.resolve(name), value)
        place = get_position(world.sim, world.sim.scene.resolve("tip"))
        assert place == pytest.approx([tip[0][0], tip[0][1] + 0.01 * share, tip[0][2]], abs=1e-3)


ENVIRONMENT = (
    LUA_JOINTS
    + """
local base, tip, target = sim.getObjectHandle('base'), sim.getObjectHandle('tip'), sim.getObjectHandle('target')
local env = simIK.createEnvironment()
local group = simIK.createGroup(env)
simIK.setGroupCalculation(env, group, simIK.method_damped_least_squares, 0.05, 100)
local element, toIk = simIK.addElementFromScene(env, group, base, tip, target, simIK.constraint_position)
"""
)


def test_an_environment_is_solved_without_moving_the_scene_and_then_moves_it(world: ScriptWorld) -> None:
    before = world.sim.data.qpos.copy()
    result, flags, precision, there, kept = world.lua(
        ENVIRONMENT
        + """
local result, flags, precision = simIK.handleGroup(env, group)
return result, flags, precision, simIK.getObjectPose(env, toIk[tip]), simIK.getJointPosition(env, toIk[js[2]])
"""
    )
    assert (result, flags) == (1, 0)
    assert precision[0] < 5e-4
    assert there[:3] == pytest.approx([0.3, 0.1, 0.4], abs=5e-4)
    assert kept != 0
    assert np.array_equal(world.sim.data.qpos, before)
    assert world.lua(ENVIRONMENT + "return simIK.applyIkEnvironmentToScene(env, group)") == [1]
    assert miss(world.sim)[0] < 5e-4


def test_an_environments_target_is_its_own(world: ScriptWorld) -> None:
    code, place = world.lua(
        ENVIRONMENT
        + """
simIK.setObjectPose(env, target, {0.2, -0.2, 0.5, 0, 0, 0, 1})
simIK.setJointMode(env, js[6], simIK.jointmode_passive)
local result = simIK.handleGroups(env, {group}, {})
simIK.syncToSim(env, {group})
return result, sim.getObjectPosition(tip, -1)
"""
    )
    assert code == 1
    assert place == pytest.approx([0.2, -0.2, 0.5], abs=1e-3)
    assert get_position(world.sim, world.sim.scene.resolve("target")) == pytest.approx([0.3, 0.1, 0.4])


def test_configurations_are_found_that_a_call_back_accepts(world: ScriptWorld) -> None:
    many, one, none, path = world.lua(
        ENVIRONMENT
        + """
local function left(values) return values[1] < 1.5 end
local many = simIK.findConfigs(env, group, js, {maxTime = 0.3, findMultiple = true, cb = left})
local one = simIK.findConfig(env, group, js, 0.1, 1, {1, 1, 1, 0.1}, left)
local none = simIK.getConfigForTipPose(env, group, js, 0.1, 0.05, nil, function() return false end)
local path = simIK.generatePath(env, group, js, tip, 3)
return many, one, none, path and #path
"""
    )
    assert len(many) > 1
    assert all(len(values) == 6 and values[0] < 1.5 for values in [*many, one])
    assert (none, path) == (None, 18)


def test_a_tip_gets_another_target_until_the_stop(world: ScriptWorld) -> None:
    asked = world.lua("""
local tip, target, other = sim.getObjectHandle('tip'), sim.getObjectHandle('target'), sim.getObjectHandle('link1')
local before = {sim.getLinkDummy(tip) == target, sim.getLinkDummy(target) == tip, sim.getLinkDummy(other)}
return before, sim.setLinkDummy(tip, other), sim.getLinkDummy(tip) == other
""")
    assert asked == [[True, True, -1], 1, True]
    backwards = "sim.setLinkDummy(sim.getObjectHandle('target'), sim.getObjectHandle('tip'))"
    assert world.value(backwards) == 1
    assert (
        world.value("sim.getLinkDummy(sim.getObjectHandle('tip')) == sim.getObjectHandle('target')") is True
    )
    world.sim.stop()
    world.sim.start()
    assert (
        world.value("sim.getLinkDummy(sim.getObjectHandle('tip')) == sim.getObjectHandle('target')") is True
    )


def test_the_type_of_a_link_is_asked_and_set(world: ScriptWorld) -> None:
    asked = world.lua("""
local tip = sim.getObjectHandle('tip')
local function asked() local kind, other = sim.getDummyLinkType(tip) return kind, other == sim.getLinkDummy(tip) end
local before = {asked()}
return before, sim.setDummyLinkType(tip, sim.dummy_linktype_ik_tip_target), {asked()}
""")
    assert asked == [[0, True], 1, [5, True]]


def test_a_group_is_checked_and_its_jacobian_computed(world: ScriptWorld) -> None:
    before = world.sim.data.qpos.copy()
    result, values, code = world.lua(
        LUA_JOINTS
        + TO_GROUP
        + """
sim.setIkElementProperties(g, sim.getObjectHandle('tip'), 7)
local result, values = sim.checkIkGroup(g, js)
return result, values, sim.computeJacobian(g, 0)
"""
    )
    assert (result, code) == (1, 0)
    assert np.array_equal(world.sim.data.qpos, before)
    for name, value in zip(JOINTS, values, strict=True):
        world.sim.joints.set_position(world.sim.scene.resolve(name), value)
    assert miss(world.sim)[0] < 1e-3


def test_what_an_environment_holds_is_read_and_set(world: ScriptWorld) -> None:
    asked = world.lua(
        ENVIRONMENT
        + """
simIK.setElementPrecision(env, group, element, {0.001, 0.01})
simIK.setJointInterval(env, js[1], false, {-0.5, 1})
simIK.setJointPosition(env, js[1], 2)
simIK.setJointPosition(env, js[2], 0.4) simIK.setJointPosition(env, js[3], 0.4)
simIK.setJointMode(env, js[6], simIK.jointmode_passive)
simIK.setObjectTransformation(env, target, -1, {0.2, 0.1, 0.5}, {0, 0, 1})
local cyclic, interval = simIK.getJointInterval(env, js[1])
local matrix = simIK.getObjectMatrix(env, target, -1)
local place, quat, euler = simIK.getObjectTransformation(env, target, -1)
local jacobian, size = simIK.getJacobian(env, group)
local same, errors = simIK.computeGroupJacobian(env, group)
local method, damping, iterations = simIK.getGroupCalculation(env, group)
return {simIK.getObjectHandle(env, 'tip') == tip, simIK.doesObjectExist(env, 'nobody')}, {cyclic, interval},
    {simIK.getJointPosition(env, js[1]), simIK.getJointMode(env, js[6])}, {matrix[4], matrix[8], matrix[12]},
    {place, euler, quat[4]}, {#jacobian, size, #same, #errors}, simIK.getManipulability(env, group),
    {method, damping, iterations}, simIK.getGroupHandle(env, 'group1') == group
"""
    )
    assert asked[0] == [True, False]
    assert asked[1] == [False, [-0.5, 1]]
    assert asked[2] == [0.5, 0]
    assert asked[3] == pytest.approx([0.2, 0.1, 0.5])
    assert asked[4] == [
        pytest.approx([0.2, 0.1, 0.5]),
        pytest.approx([0, 0, 1]),
        pytest.approx(math.cos(0.5)),
    ]
    assert asked[5] == [15, [3, 5], 15, 3]
    assert asked[6] > 0
    assert asked[7:] == [[1, 0.05, 100], True]


def test_the_jacobian_of_a_chain_is_that_of_its_group(world: ScriptWorld) -> None:
    same, errors, rows, error, matrices, in_place, of_some, _ = world.lua(
        ENVIRONMENT
        + """
simIK.setElementConstraints(env, group, element, simIK.constraint_pose)
simIK.setJointPosition(env, js[2], 0.4) simIK.setJointPosition(env, js[4], -0.3)
local same, errors = simIK.computeGroupJacobian(env, group)
local tip, base, last, all = sim.getObjectHandle('tip'), sim.getObjectHandle('base'), js[#js], simIK.constraint_pose
local at, goal = simIK.getObjectPose(env, tip), simIK.getObjectPose(env, target)
local rows, error = simIK.computeJacobian(env, base, last, all, at, goal)
local matrices = simIK.computeJacobian(env, -1, last, all, simIK.getObjectMatrix(env, tip), nil,
    simIK.getObjectMatrix(env, base))
local _, inPlace = simIK.computeJacobian(env, base, last, all, at)
simIK.setJointMode(env, js[3], simIK.jointmode_passive)
return same, errors, rows, error, matrices, inPlace, simIK.computeJacobian(env, base, last, 3, at)
"""
    )
    assert len(rows) == 6 * len(JOINTS)
    assert rows == pytest.approx(same, abs=1e-12)
    assert error == pytest.approx(errors, abs=1e-12)
    assert matrices == pytest.approx(same, abs=1e-9)
    assert in_place == pytest.approx([0] * 6)
    assert len(of_some) == 2 * (len(JOINTS) - 1)
    wrong = "local env = simIK.createEnvironment() local tip = sim.getObjectHandle('tip') "
    world.fails(wrong + "simIK.computeJacobian(env, -1, tip, 7, {0, 0, 0, 0, 0, 0, 1})", "not a joint")
    world.fails(wrong + "simIK.computeJacobian(env, tip, -1, 7, {0, 0, 0, 0, 0, 0, 1})", "not above")
    world.fails(wrong + "simIK.computeJacobian(env, -1, tip, 7, {0})", "a matrix of 12 numbers")


def test_the_older_names_do_the_same(world: ScriptWorld) -> None:
    result, place, settings = world.lua(
        LUA_JOINTS
        + """
local env = simIK.createEnvironment()
local group = simIK.createIkGroup(env, 'arm')
simIK.setIkGroupCalculation(env, group, simIK.method_pseudo_inverse, 0, 60)
local base, tip, target = sim.getObjectHandle('base'), sim.getObjectHandle('tip'), sim.getObjectHandle('target')
local element, toIk, toSim = simIK.addIkElementFromScene(env, group, base, tip, target, simIK.constraint_pose)
simIK.setIkElementConstraints(env, group, element, simIK.constraint_position)
simIK.setIkElementPrecision(env, group, element, {0.0002, 0.01})
simIK.setIkElementWeights(env, group, element, {1, 1})
sim.setJointPosition(js[2], 0.5)
simIK.applySceneToIkEnvironment(env, group)
simIK.syncFromSim(env, {group})
local result = simIK.handleIkGroup(env, simIK.getIkGroupHandle(env, 'arm'))
return result, simIK.getObjectPose(env, toIk[tip]), {simIK.getIkGroupCalculation(env, group)}
"""
    )
    assert result == 1
    assert place[:3] == pytest.approx([0.3, 0.1, 0.4], abs=2e-4)
    assert settings == [0, 0, 60]


def test_mistakes_with_environments_say_what_is_there(world: ScriptWorld) -> None:
    world.fails("simIK.createGroup(5)", "no environment 5")
    world.fails(ENVIRONMENT + "simIK.handleGroup(env, 9)", "no group 9")
    world.fails(ENVIRONMENT + "simIK.eraseEnvironment(env) simIK.handleGroup(env, group)", "no environment")
    world.fails("simIK.computeNothing(0, 0)", "not provided")
    world.fails(ENVIRONMENT + "simIK.setGroupCalculation(env, group, 7, 0.1, 10)", "no method")
    world.fails(ENVIRONMENT + "simIK.setObjectPose(env, target, {0, 0, 'up', 0, 0, 0, 1})", "a pose is")
    world.fails(ENVIRONMENT + "simIK.setObjectMatrix(env, target, -1, 5)", "a matrix is")
    world.fails(ENVIRONMENT + "simIK.findConfigs(env, group, js, {maxTime = 'long'})", "maxTime is")
    world.fails(ENVIRONMENT + "simIK.generatePath(env, group, js, tip, 1e9)", "up to 10000 states")
    with pytest.raises(CommandError, match="not above"):
        world.lua(
            ENVIRONMENT
            + "simIK.addElementFromScene(env, group, target, tip, target, 7)".replace(
                "target, tip", "sim.getObjectHandle('link6'), target"
            )
        )


def _copy(world: World, name: str) -> list[int]:
    return copy_objects(world, [world.simulation.scene.resolve(name)])


FOLLOW = (
    LUA_JOINTS
    + """
local base, tip, target = sim.getObjectHandle('base'), sim.getObjectHandle('tip'), sim.getObjectHandle('target')
local function follow(goal, ik)
    ik.tip, ik.target = tip, target
    local data = sim.moveToPose_init({ik = ik, targetPose = goal, maxVel = {1, 1, 1, 3}, maxAccel = {9, 9, 9, 9},
        maxJerk = {99, 99, 99, 99}})
    local code = 0
    for i = 1, 500 do
        code, data = sim.moveToPose_step(data)
        if code ~= 0 then break end
    end
    sim.moveToPose_cleanup(data)
    return code
end
local goal = sim.getObjectPose(tip)
"""
)


def test_a_motion_to_a_pose_moves_the_joints_that_carry_the_tip(world: ScriptWorld) -> None:
    code, wanted, place, mark, last = world.lua(
        FOLLOW
        + """
for i = 1, 6 do sim.setJointPosition(js[i], 0.3) end
goal = sim.getObjectPose(tip)
goal[1], goal[3] = goal[1] - 0.1, goal[3] - 0.05
local last = sim.getJointPosition(js[6])
local code = follow(goal, {base = base, joints = {js[1], js[2], js[3], js[4], js[5]}, constraints = 7})
return code, goal, sim.getObjectPose(tip), sim.getObjectPose(target), sim.getJointPosition(js[6]) - last
"""
    )
    assert code == 1
    assert place[:3] == pytest.approx(wanted[:3], abs=2e-3)
    assert mark[:3] == pytest.approx(wanted[:3], abs=1e-6), "the target went ahead"
    assert last == 0, "a joint that is not named stays"


def test_a_motion_out_of_reach_leaves_the_joints_or_ends_as_asked(world: ScriptWorld) -> None:
    assert world.lua(FOLLOW + "goal[1] = goal[1] + 5 return follow(goal, {constraints = 7})") == [1]
    assert get_position(world.sim, world.sim.scene.resolve("tip"))[0] < 1
    world.fails(
        FOLLOW + "goal[1] = goal[1] + 5 return follow(goal, {constraints = 7, breakFlags = 16})",
        "the inverse kinematics failed; its flags",
    )
