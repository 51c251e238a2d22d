"""Motions of scripts: profiles, and functions that move joints and objects and wait until they are there."""

from __future__ import annotations

import ast
import math
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from handler_calls import World
from scripted_world import said, scripted
from sim_api_calls import ScriptWorld, world

from simx_server.scene.poses import frames

pytestmark = pytest.mark.slow

__all__ = ["world"]

BODY = """
<body name="base"><geom size="0.05"/>
  <body name="one" pos="1 0 0"><joint name="first" axis="0 0 1"/><geom size="0.05" mass="1"/></body>
  <body name="two" pos="2 0 0"><joint name="second" axis="0 0 1"/><geom size="0.05" mass="1"/></body>
  <body name="rail" pos="3 0 0"><joint name="slide" type="slide" axis="1 0 0" range="-1 1"/>
    <geom size="0.05" mass="1"/></body>
  <site name="mark" pos="0 1 0"/><site name="goal" pos="0 0 1"/>
</body>
"""
CUSTOM = """
<text name="simx:joint:first" data="mode=passive"/>
<text name="simx:joint:second" data="mode=passive"/>
<text name="simx:joint:slide" data="mode=passive"/>
"""
PREAMBLE = """
function sysCall_init()
    a, b = sim.getObjectHandle('first'), sim.getObjectHandle('second')
    slide = sim.getObjectHandle('slide')
    mark, goal = sim.getObjectHandle('mark'), sim.getObjectHandle('goal')
end
local function text(value)
    if type(value) ~= 'table' then return type(value) == 'nil' and 'None' or string.format('%.12g', value) end
    local parts = {}
    for i = 1, #value do parts[i] = text(value[i]) end
    return '[' .. table.concat(parts, ',') .. ']'
end
function out(...)
    local parts = {}
    for i = 1, select('#', ...) do parts[i] = text((select(i, ...))) end
    print('[' .. table.concat(parts, ',') .. ']')
end
"""


class Moved:
    """The events while a thread ran."""

    def __init__(self, thread: str, passes: int = 200) -> None:
        world = scripted({"lua:base": f"{PREAMBLE}\nfunction sysCall_thread()\n{thread}\nend"}, BODY, CUSTOM)
        names = {name: world.handle(name) for name in ("first", "second", "slide")}
        mark = world.handle("mark")
        self.joints: dict[str, list[float]] = {name: [] for name in names}
        self.places: list[list[float]] = []
        self.lines: list[str] = []
        world.sim.start()
        for _ in range(passes):
            world.parts.step()
            for name, handle in names.items():
                self.joints[name].append(world.sim.joints.position(handle))
            self.places.append(frames.get_position(world.sim, mark))
            self.lines += said(world)

    @property
    def out(self) -> Any:
        (line,) = self.lines
        return ast.literal_eval(line)


def rates(values: list[float], step: float = 0.05) -> list[float]:
    return [(later - before) / step for before, later in pairwise(values)]


def within(values: list[float], velocity: float, acceleration: float) -> bool:
    speeds = rates(values)
    return max(map(abs, speeds)) <= velocity * 1.001 and max(map(abs, rates(speeds))) <= acceleration * 1.001


def test_a_profile_is_stepped_by_the_script(world: ScriptWorld) -> None:
    steps = world.lua("""
        local h = sim.rmlPos(2, 0.0001, -1, {0, 0, 0, 0, 0, 0}, {1, 1, 2, 2, 4, 4}, {1, 1}, {1, 0.5, 0, 0})
        local found, result, state, left = {}, 0
        while result == 0 do
            result, state, left = sim.rmlStep(h, 0.05)
            found[#found + 1] = {result, state[1], state[2], state[3], left}
        end
        return found, sim.rmlRemove(h), pcall(sim.rmlStep, h, 0.05)
    """)
    found, removed, ok, problem = steps
    assert removed == 1
    assert not ok
    assert "no motion profile 1; those of this script: none" in problem
    assert [each[0] for each in found] == [0] * (len(found) - 1) + [1]
    assert found[-1][1:3] == pytest.approx([1, 0.5])
    assert all(each[1] == pytest.approx(2 * each[2]) for each in found), "in phase: on a line"
    assert max(each[3] for each in found) == pytest.approx(1)
    assert -0.05 < found[-1][4] <= 0 < found[-2][4]


@pytest.mark.parametrize("smallest", [-1, 0.0001])
@pytest.mark.parametrize("names", [("rmlPos", "rmlStep"), ("ruckigPos", "ruckigStep")])
def test_a_run_along_a_path_of_some_hundred_steps_keeps_its_limits_and_ends_at_its_goal(
    world: ScriptWorld, names: tuple[str, str], smallest: float
) -> None:
    make, step = names
    results, places, speeds, growths = world.lua(f"""
        local h = sim.{make}(1, {smallest}, -1, {{0, 0, 0}}, {{0.5, 4, 1000}}, {{1}}, {{9.3, 0}})
        local results, places, speeds, growths, result, state = {{}}, {{}}, {{}}, {{}}, 0
        while result == 0 do
            result, state = sim.{step}(h, 0.05)
            results[#results + 1], places[#places + 1] = result, state[1]
            speeds[#speeds + 1], growths[#growths + 1] = state[2], state[3]
        end
        return results, places, speeds, growths
    """)
    assert len(results) > 300
    assert results == [0] * (len(results) - 1) + [1]
    assert places[-1] == pytest.approx(9.3)
    assert speeds[-1] == pytest.approx(0.0, abs=1e-9)
    assert max(map(abs, speeds)) <= 0.5 + 1e-9
    assert max(map(abs, growths)) <= 4 + 1e-9
    assert places == sorted(places)


def test_the_oldest_form_makes_one_step_of_a_motion(world: ScriptWorld) -> None:
    steps, ended, result, state = world.lua("""
        local now, result, steps = {0, 0, 0}, 0, 0
        repeat
            result, now = sim.rmlPosition(1, 0.05, -1, now, {1, 2, 1e3}, {1}, {1, 0})
            steps = steps + 1
        until result == 1
        assert(simRMLPosition and simRMLVelocity)
        return steps, now[1], sim.rmlVelocity(1, 0.5, -1, {0, 0, 0}, {2, 1e6}, {1}, {5})
    """)[:4]
    assert 28 <= steps <= 32  # a second at 1 m/s, and half a second to gain and lose that
    assert ended == pytest.approx(1, abs=1e-3)
    assert result == 0
    assert state == pytest.approx([0.25, 1, 2], abs=1e-3)


def test_a_velocity_profile_keeps_its_velocity_and_what_is_not_selected_stays(world: ScriptWorld) -> None:
    (results, state) = world.lua("""
        local h = simRMLVel(2, 0.0001, simrml_no_sync, {0, 5, 0, 0, 0, 0}, {2, 2, 0, 0}, {1, 0}, {1, 1})
        local results, state = {}
        for i = 1, 4 do results[i], state = simRMLStep(h, 0.25) end
        simRMLRemove(h)
        sim.rmlRemove(sim.rmlVel(1, 0.0001, -1, {0, 0, 0}, {1, 0}, {1}, {1}))
        return results, state
    """)
    assert results == [0, 1, 1, 1]
    assert state == pytest.approx([0.75, 5, 1, 0, 0, 0])


def test_the_later_names_and_bounds_downwards(world: ScriptWorld) -> None:
    slowest, at_the_end = world.lua("""
        local flags = sim.ruckig_nosync | sim.ruckig_minvel | sim.ruckig_minaccel
        local h = sim.ruckigPos(1, 0.0001, flags, {1, 0, 0}, {9, 9, 90, -0.5, -9}, {1}, {0, 0})
        local slowest, result, state = 0, 0
        while result == 0 do
            result, state = sim.ruckigStep(h, 0.01)
            slowest = math.min(slowest, state[2])
        end
        sim.ruckigRemove(h)
        local v = sim.ruckigVel(1, 0.0001, sim.ruckig_minaccel, {0, 0, 0}, {9, 0, -1}, {1}, {-1})
        local _, velocity = sim.ruckigStep(v, 0.5)
        return slowest, velocity
    """)
    assert slowest == pytest.approx(-0.5)
    assert at_the_end == pytest.approx([-0.125, -0.5, -1])


@pytest.mark.parametrize(
    ("source", "says"),
    [
        (
            "sim.rmlPos(2, 0.1, -1, {0}, {1, 1, 1, 1, 1, 1}, {1, 1}, {0, 0, 0, 0})",
            "of 2 values are 6 numbers, not 1",
        ),
        ("sim.rmlPos(1, 0.1, -1, {0, 0, 0}, {0, 1, 1}, {1}, {1, 0})", "greatest velocity must be above 0"),
        (
            "sim.rmlPos(1, 0.1, -1, {0, 0, 0}, {1, 1, 1}, {1}, {1, 3})",
            "target velocity 3.0* of DoF 0 exceeds",
        ),
        ("sim.rmlPos(1, 0.1, -1, {0, 1e300, 0}, {1, 1, 1}, {1}, {1, 0})", "too far apart|too long"),
        ("sim.rmlPos(0, 0.1, -1, {}, {}, {}, {})", "at least 1 value"),
        ("sim.rmlPos(1, 0.1, -1, {0, 0, 0}, {1, 1, 1}, {}, {1, 0})", "the selection must say"),
        ("sim.rmlStep(9, 0.1)", "no motion profile 9"),
        ("sim.moveToConfig_init({targetPos = {1}})", "needs pos .* or joints"),
        ("sim.moveToConfig_init({pos = {1}})", "the field targetPos: 1 numbers"),
        ("sim.moveToConfig_init({pos = 'x', targetPos = {1}})", "the field pos must be a table"),
        ("sim.moveToPose_init({ik = {tip = 1}})", "ik needs tip and target"),
        ("sim.moveToPose_init({ik = 3})", "ik must be a table"),
        ("sim.moveToConfig_step({})", "this table is of no motion"),
        ("sim.moveToConfig({pos = {1}, targetPos = {1}})", "works only in a thread"),
    ],
)
def test_what_cannot_be_says_why(world: ScriptWorld, source: str, says: str) -> None:
    world.fails(f"return {source}", says)


def test_joints_move_together_within_limits() -> None:
    moved = Moved("""
        local v, w, j = {0.5, 0.5}, {1, 1}, {0, 0}
        out(sim.rmlMoveToJointPositions({a, b}, -1, nil, nil, v, w, j, {1, -0.5}, nil))
    """)
    result, position, velocity, acceleration, unused = moved.out
    assert (result, unused) == (1, pytest.approx(0, abs=1e-6))
    assert [position, velocity, acceleration] == [
        pytest.approx(each, abs=1e-6) for each in ([1, -0.5], [0, 0], [0, 0])
    ]
    first, second = moved.joints["first"], moved.joints["second"]
    assert [first[-1], second[-1]] == pytest.approx([1, -0.5])
    assert within(first, 0.5, 1)
    assert within(second, 0.25, 0.5)
    assert second == pytest.approx([-each / 2 for each in first])
    assert sum(value < 1 - 1e-9 for value in first) == 49, "1 rad at 0.5 rad/s and 1 rad/s^2: 2.5 s"


def test_cyclic_joints_take_the_shorter_way_or_the_one_asked_for() -> None:
    moved = Moved(
        """
        local v, w, j = {6, 6}, {60, 60}, {0, 0}
        simRMLMoveToJointPositions({a, b}, simrml_no_sync, nil, nil, v, w, j, {4, 4}, {0, 0}, {0, 1})
        """
    )
    assert min(moved.joints["first"]) == pytest.approx(4 - 2 * math.pi)
    assert max(moved.joints["first"]) <= 1e-9
    assert max(moved.joints["second"]) > 2.9, "upwards, over half a turn"


def test_an_object_moves_along_and_turns() -> None:
    moved = Moved("""
        local l = {0.4, 0.4, 0.4, 1}
        local q = {0, 0, math.sin(0.4), math.cos(0.4)}
        out(sim.rmlMoveToPosition(mark, -1, -1, nil, nil, l, l, {0, 0, 0, 0}, {0, 0, 1}, q, nil))
        sim.rmlMoveToPosition(mark, -1, -1, nil, nil, l, l, {0, 0, 0, 0}, {0, 1, 1}, nil, nil)
    """)
    result, position, quaternion, velocity, acceleration, unused = moved.out
    assert result == 1
    assert position == pytest.approx([0, 0, 1])
    assert quaternion == pytest.approx([0, 0, math.sin(0.4), math.cos(0.4)])
    assert (len(velocity), len(acceleration)) == (4, 4)
    assert 0 <= unused < 0.05
    assert moved.places[-1] == pytest.approx([0, 1, 1])
    for axis in range(3):
        assert within([place[axis] for place in moved.places], 0.4, 0.8)
    on_the_way = moved.places[30]
    assert on_the_way[2] == pytest.approx(1 - on_the_way[1]), "in phase: straight"


def test_a_call_back_gets_a_configuration_and_may_end_the_motion() -> None:
    moved = Moved("""
        local seen = 0
        local function put(p, v, w, extra)
            seen = seen + 1
            sim.setJointPosition(a, p[1])
            return extra == 'short' and p[1] > 0.51
        end
        local p, v, w, left = sim.moveToConfig(-1, {0}, nil, nil, {1}, {2}, {20}, {1}, nil, put, 'whole')
        local whole = seen
        local q = sim.moveToConfig(sim.ruckig_timesync, {0}, {0}, {0}, {1}, {2}, {20}, {1}, {0}, put, 'short')
        out(p, v, w, left, whole, q)
    """)
    position, velocity, _, left, calls, cut = moved.out
    assert position == pytest.approx([1])
    assert velocity == pytest.approx([0], abs=1e-9)
    assert 0 <= left < 0.05
    assert calls == 32, "1.6 s"
    assert 0.51 < cut[0] < 0.57


def test_a_table_names_joints_and_limits() -> None:
    moved = Moved("""
        local both = {a, slide}
        local data = sim.moveToConfig{
            joints = both, targetPos = {1, 0.5}, maxVel = {0.5, 0.5}, maxAccel = 1, maxJerk = 50}
        out(data.pos, data.vel, data.timeLeft)
        sim.moveToConfig{joints = {a}, targetPos = {0.25}}
    """)
    assert moved.out[0] == pytest.approx([1, 0.5])
    assert within(moved.joints["slide"], 0.5, 1)
    assert within(moved.joints["first"][:50], 0.5, 1)
    assert moved.joints["first"][-1] == pytest.approx(0.25)


def test_poses_move_by_call_back_by_table_and_by_metric() -> None:
    moved = Moved(
        """
        local function put(pose) sim.setObjectPose(mark, -1, pose) end
        local goal = {0.5, 1, 0, 0, 0, 0, 1}
        local l = {1, 1, 1, 1}
        local pose, left = sim.moveToPose(-1, sim.getObjectPose(mark, -1), l, l, {9, 9, 9, 9}, goal, put)
        local from, to = sim.getObjectMatrix(mark, -1), sim.buildMatrix({0, 1, 0}, {0, 0, 1})
        local m = sim.moveToPose(-1, from, {1}, {1}, {9}, to,
            function(m) sim.setObjectMatrix(mark, -1, m) end, nil, {1, 1, 1, 0.1})
        local data = sim.moveToPose{
            object = mark, targetPose = {0, 0, 0.3, 0, 0, 0, 1}, maxVel = l, maxAccel = l, maxJerk = l}
        out(pose, m, data.pose, sim.getObjectPosition(mark, -1))
    """,
        300,
    )
    pose, matrix, last, place = moved.out
    assert pose == pytest.approx([0.5, 1, 0, 0, 0, 0, 1])
    assert [len(matrix), matrix[3], matrix[7], matrix[11]] == pytest.approx([12, 0, 1, 0])
    assert matrix[0] == pytest.approx(math.cos(1))
    assert last[:3] == pytest.approx([0, 0, 0.3])
    assert place == pytest.approx([0, 0, 0.3])


def test_single_steps_need_no_thread(world: ScriptWorld) -> None:
    assert world.lua("""
        local last
        local data = sim.moveToConfig_init{pos = {0}, targetPos = {1}, maxVel = {1}, maxAccel = {1}, maxJerk = {9},
            timeStep = 0.5, callback = function(d) last = d.pos[1] end}
        local count, result = 0, 0
        while result == 0 do count, result = count + 1, sim.moveToConfig_step(data) end
        sim.moveToConfig_cleanup(data)
        local pose = sim.moveToPose_init{pose = {0, 0, 0, 0, 0, 0, 1}, targetPose = {1, 0, 0, 0, 0, 0, 1}}
        local arrived, there = sim.moveToPose_step(pose)
        sim.moveToPose_cleanup(pose)
        return count, result, last, arrived, there.pose[1], pcall(sim.moveToPose_step, pose)
    """)[:6] == [5, 1, pytest.approx(1), 1, pytest.approx(1), False]


def test_the_oldest_motions() -> None:
    moved = Moved(
        """
        local left = sim.moveToPosition(mark, -1, {0, 0.5, 0}, {0, 0, 1}, 0.5, 1)
        local turn = sim.getObjectOrientation(mark, -1)[3]
        sim.moveToPosition(mark, -1, nil, {0, 0, 0}, 0.5, nil, {sim.distcalcmethod_dac, 0.5})
        local joints = simMoveToJointPositions({a, slide}, {-0.5, 9}, 0.5, 1)
        sim.moveToJointPositions({a, slide}, {0, 0}, {1, 0.5}, {2, 2})
        local follows = sim.moveToObject(mark, goal, 3, nil, 1, 4)
        local goes_on = not sim.getThreadExistRequest()
        out(left, turn, joints, follows, sim.getObjectPosition(mark, goal), goes_on and 1 or 0)
    """,
        400,
    )
    left, turn, joints, follows, apart, is_to_go_on = moved.out
    assert turn == pytest.approx(1)
    assert all(0 <= each < 0.05 for each in (left, joints, follows))
    assert apart == pytest.approx([0, 0, 0], abs=1e-9)
    assert is_to_go_on == 1
    assert within([place[1] for place in moved.places[:30]], 0.5, 1)
    assert max(moved.joints["slide"]) == pytest.approx(1), "a goal outside the interval is its end"
    assert min(moved.joints["first"]) == pytest.approx(-0.5)
    assert moved.joints["slide"][-1] == moved.joints["first"][-1] == pytest.approx(0)


UR5 = """
function sysCall_init()
    joints = {}
    for i = 1, 6 do joints[i] = sim.getObjectHandle('UR5_joint' .. i) end
end
function sysCall_thread()
    local deg = math.pi / 180
    local v, w, j = {}, {}, {}
    for i = 1, 6 do v[i], w[i], j[i] = 60 * deg, 40 * deg, 80 * deg end
    local goal = {90 * deg, 45 * deg, -45 * deg, 45 * deg, 90 * deg, 0}
    sim.rmlMoveToJointPositions(joints, -1, nil, nil, v, w, j, goal, nil)
    print('first')
    goal = {-90 * deg, 30 * deg, 60 * deg, 0, -45 * deg, 90 * deg}
    sim.rmlMoveToJointPositions(joints, -1, nil, nil, v, w, j, goal, nil)
    print('second')
end
"""


def test_a_threaded_script_moves_an_arm_through_two_configurations(tmp_path: Path) -> None:
    scene = Path(__file__).parents[3] / "scenes" / "ur5.xml"
    text = scene.read_text().replace('file="', f'file="{scene.parent}/')
    text = text.replace(f'data="file={scene.parent}/', 'data="file=')
    (tmp_path / "arm.lua").write_text(UR5)
    text = text.replace("file=arm_follows_target.lua", "file=arm.lua")
    (tmp_path / "scene.xml").write_text(text)
    world = World(file=tmp_path / "scene.xml", workspace=tmp_path)
    arm = [world.handle(f"UR5_joint{index}") for index in range(1, 7)]
    joints = world.sim.joints
    targets: list[list[float]] = []
    errors: list[float] = []
    reached: dict[str, list[float]] = {}
    world.sim.start()
    for _ in range(400):
        world.parts.step()
        targets.append([joints.target_position(each) for each in arm])
        errors.append(max(abs(joints.position(each) - joints.target_position(each)) for each in arm))
        for line in said(world):
            reached[line] = [joints.position(each) for each in arm]
        if "second" in reached:
            break
    degrees = math.pi / 180
    assert reached["first"] == pytest.approx([d * degrees for d in (90, 45, -45, 45, 90, 0)], abs=0.02)
    assert reached["second"] == pytest.approx([d * degrees for d in (-90, 30, 60, 0, -45, 90)], abs=0.02)
    for each in zip(*targets, strict=True):
        assert within(list(each), 60 * degrees, 40 * degrees)
    assert max(errors) < 0.1, "the arm itself follows"
