"""Path objects of V-REP 3 in scripts: positions along them, control points, dummies that follow, motions."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from sim_api_calls import ScriptWorld

SCENE = """
<mujoco>
  <compiler angle="radian"/>
  <option timestep="0.005" gravity="0 0 0"/>
  <worldbody>
    <body name="host"><geom size="0.1" contype="0" conaffinity="0"/></body>
    <site name="rail" pos="0 0 1"/>
    <site name="corner" pos="1 0 0"/>
    <site name="wagon" pos="0 0 1"/>
    <body name="load" pos="0 0 1.5"><geom size="0.1" contype="0" conaffinity="0"/></body>
    <site name="mover"/>
  </worldbody>
  <custom>
    <text name="simx:object:rail" data="type=path"/>
    <text name="simx:path:rail" data="points=0,0,0,1,0,0,0;2,0,0,1,0,0,0 length=distance"/>
    <text name="simx:object:corner" data="type=path"/>
    <text name="simx:path:corner" data="points=0,0,0,1,0,0,0;1,0,0,1,0,0,0,1,1,11;1,1,0,0.7071068,0,0,0.7071068"/>
    <text name="simx:object:wagon" data="parent=rail"/>
    <text name="simx:follow:wagon" data="offset=0.5"/>
    <text name="simx:object:load" data="parent=wagon"/>
  </custom>
</mujoco>
"""

H = "local h = sim.getObjectHandle\n"


@pytest.fixture
def world(tmp_path: Path) -> ScriptWorld:
    return ScriptWorld(tmp_path, SCENE, owner="host")


def test_a_path_has_its_own_kind(world: ScriptWorld) -> None:
    assert world.lua(H + "return sim.getObjectType(h'rail'), sim.object_path_type") == [8, 8]
    assert world.call("simxGetObjects", 8) == [world.handle("rail"), world.handle("corner")]


def test_positions_along_a_path_are_shares_of_its_length_in_the_world(world: ScriptWorld) -> None:
    assert world.lua(H + "return sim.getPathLength(h'rail'), sim.getPathPosition(h'rail')") == [2, 0]
    assert world.lua(H + "return sim.getPositionOnPath(h'rail', 0.25)") == [pytest.approx([0.5, 0, 1])]
    assert world.lua(H + "return sim.getPositionOnPath(h'rail', 7)") == [pytest.approx([2, 0, 1])]
    assert world.lua(H + "return sim.getOrientationOnPath(h'corner', 1)") == [
        pytest.approx([0, 0, math.pi / 2], abs=1e-6)
    ]
    assert world.lua(H + "return sim.getClosestPositionOnPath(h'rail', {1.5, 3, 0})") == [0.75]
    world.fails(H + "sim.getPathLength(h'host')", "'host' is a shape.*path")


def test_a_bezier_curve_cuts_the_corner(world: ScriptWorld) -> None:
    (length,) = world.lua(H + "return sim.getPathLength(h'corner')")
    # The parabola from (0.5, 0) over (0.75, 0.25) to (1, 0.5), and two straight halves; ten chords are a bit shorter.
    assert length == pytest.approx(1 + 0.8115, abs=1e-3)
    assert world.lua(H + "return sim.getPositionOnPath(h'corner', 0.5)") == [
        pytest.approx([1.875, 0.125, 0], abs=1e-4)
    ]


def test_what_follows_a_path_moves_with_its_position(world: ScriptWorld) -> None:
    assert world.lua(H + "return sim.setPathPosition(h'rail', 0.25)") == [1]
    assert world.lua(H + "return sim.getObjectPosition(h'wagon', -1)") == [pytest.approx([0.75, 0, 1])]
    assert world.lua(H + "return sim.getObjectPosition(h'load', -1)") == [pytest.approx([0.75, 0, 1.5])]
    world.lua(H + "sim.setObjectFloatParameter(h'wagon', sim.dummyfloatparam_follow_path_offset, 1)")
    assert world.lua(H + "return sim.getObjectPosition(h'wagon', -1)") == [pytest.approx([1.25, 0, 1])]
    world.lua(
        H
        + "sim.setObjectInt32Parameter(h'wagon', sim.dummyintparam_follow_path, 0) sim.setPathPosition(h'rail', 0)"
    )
    assert world.lua(H + "return sim.getObjectPosition(h'wagon', -1)") == [pytest.approx([1.25, 0, 1])]
    world.call("simxStopSimulation")
    assert world.parts.paths.get(world.handle("rail")).position == 0
    assert world.call("simxGetObjectPosition", world.handle("wagon"), -1) == pytest.approx([0, 0, 1])


def test_the_position_moves_by_itself_to_the_end(world: ScriptWorld) -> None:
    world.lua(H + "sim.setPathTargetNominalVelocity(h'rail', 0.4)")
    world.passes(5)
    assert world.lua(H + "return sim.getPathPosition(h'rail')") == [pytest.approx(0.1)]
    assert world.lua(H + "return sim.getObjectPosition(h'wagon', -1)") == [pytest.approx([0.6, 0, 1])]
    world.call("simxSetBooleanParameter", 8, False)
    world.passes()
    assert world.lua(H + "return sim.getPathPosition(h'rail')") == [pytest.approx(0.1)]
    world.call("simxSetBooleanParameter", 8, True)
    world.passes(120)
    assert world.lua(H + "return sim.getPathPosition(h'rail')") == [2]


def test_control_points_come_and_go(world: ScriptWorld) -> None:
    world.lua("p = sim.createPath(-1, {5, sim.distcalcmethod_dl, 0}, {0.2, 0, 0})")
    world.lua(
        "sim.insertPathCtrlPoints(p, 0, 0, 2, {0,0,0, 0,0,0, 1,0,1,0.5,0.5,  0,3,0, 0,0,0, 1,0,1,0.5,0.5})"
    )
    assert world.value("sim.getPathLength(p)") == pytest.approx(3)
    world.lua("sim.insertPathCtrlPoints(p, 3, 2, 1, {4,0,0, 0,0,0, 1,0,1,0.5,0.5, 6, 1,2,3,4})")
    assert world.value("sim.getPathLength(p)") == pytest.approx(3 + 5 + 4)
    assert world.lua("return sim.getDataOnPath(p, 8 / 12)") == [6, pytest.approx([1, 2, 3, 4])]
    assert world.lua("sim.setPathPosition(p, 13) return sim.getPathPosition(p)") == [pytest.approx(1)]
    world.lua("sim.cutPathCtrlPoints(p, 1, 1)")
    assert world.value("sim.getPathLength(p)") == pytest.approx(8)
    world.lua("sim.cutPathCtrlPoints(p, -1, 0)")
    assert world.value("sim.getPathLength(p)") == 0
    world.fails("sim.getPositionOnPath(p, 0)", "the path has no points")
    world.fails("sim.insertPathCtrlPoints(p, 0, 0, 2, {0})", "2 control points are 22 numbers, not 1")
    world.fails("sim.createPath(-1, {5, 9})", "9 is no method of lengths; those are 0 to 6")


def test_beyond_its_length_a_closed_path_goes_round(world: ScriptWorld) -> None:
    world.lua("p = sim.createPath(-1, {5, sim.distcalcmethod_dl, 0}, {0.2, 0, 0})")
    points = "0,0,0, 0,0,0, 1,0,1,0,0,  4,0,0, 0,0,0, 1,0,1,0,0"
    world.lua(f"sim.insertPathCtrlPoints(p, 1, 0, 2, {{{points}}})")
    assert world.value("sim.getPathLength(p)") == pytest.approx(8)
    for share, x in ((0.25, 2), (1, 0), (2.125, 1), (7.75, 2)):
        assert world.value(f"sim.getPositionOnPath(p, {share})") == pytest.approx([x, 0, 0], abs=1e-9)


def test_the_z_axis_of_a_new_path_points_along_it(world: ScriptWorld) -> None:
    world.lua("p = sim.createPath(-1)")
    world.lua("sim.insertPathCtrlPoints(p, 0, 0, 2, {0,0,0, 0,0,0, 1,0,1,0,0,  3,0,0, 0,0,0, 1,0,1,0,0})")
    assert world.value("sim.getOrientationOnPath(p, 0.5)") == pytest.approx([0, math.pi / 2, 0])
    world.lua("q = sim.createPath(0)")
    world.lua("sim.insertPathCtrlPoints(q, 0, 0, 2, {0,0,0, 1,0,0, 1,0,1,0,0,  3,0,0, 1,0,0, 1,0,1,0,0})")
    assert world.value("sim.getOrientationOnPath(q, 0.5)") == pytest.approx([1, 0, 0])


def test_a_virtual_distance_is_length_on_the_spot_where_points_coincide(world: ScriptWorld) -> None:
    """Three points at one place, of which the middle one has a virtual distance of 0.5: a metre of rest."""
    world.lua(
        H
        + "for i = 1, 3 do sim.insertPathCtrlPoints(h'rail', 0, i, 1, {1,0,0, 0,0,0, 1,i == 2 and 0.5 or 0,1,0,0}) end"
    )
    assert world.lua(H + "return sim.getPathLength(h'rail')") == [3.0]
    for position, x in ((0.9, 0.9), (1.0, 1.0), (1.9, 1.0), (2.5, 1.5)):
        found = world.lua(H + f"return sim.getPositionOnPath(h'rail', {position} / 3)")
        assert found == [pytest.approx([x, 0, 1])]


def test_an_object_follows_a_path_in_a_thread(tmp_path: Path) -> None:
    thread = """
function sysCall_threadmain()
  local h = sim.getObjectHandle
  left = sim.followPath(h'mover', h'rail', 1, 0.5, 0.5, 0)
  back = sim.followPath(h'mover', h'rail', 3, 0.5, -1, 0)
  sim.moveToObject(h'mover', h'corner', 1, 1, 4, 0)
  done = true
end
"""
    (tmp_path / "thread.lua").write_text(thread, encoding="utf-8")
    note = '<text name="simx:script:mover" data="file=thread.lua threaded=yes"/></custom>'
    world = ScriptWorld(tmp_path, SCENE.replace("</custom>", note), owner="host")
    mover = world.handle("mover")
    world.passes(20)
    assert world.call("simxGetObjectPosition", mover, -1) == pytest.approx([1.5, 0, 1], abs=0.03)
    world.passes(24)
    assert world.call("simxGetObjectPosition", mover, -1) == pytest.approx([0.85, 0, 1], abs=0.06)
    world.passes(60)
    assert world.call("simxGetObjectPosition", mover, -1) == pytest.approx([2, 1, 0])
