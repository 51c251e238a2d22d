"""Scripts group shapes, and take them apart."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from sim_api_calls import ScriptWorld

from simx_server.editing.compounds import decomposing

SCENE = """
<mujoco>
  <compiler angle="radian"/>
  <option gravity="0 0 -10"/>
  <asset>
    <mesh name="tetra" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/>
    <mesh name="two" inertia="shell" vertex="0 0 0 1 0 0 0 1 0 0 0 1  3 0 0 4 0 0 3 1 0 3 0 1"
          face="0 2 1 0 1 3 1 2 3 0 3 2 4 6 5 4 5 7 5 6 7 4 7 6"/>
  </asset>
  <worldbody>
    <body name="host" pos="0 0 9"><geom size="0.01" contype="0" conaffinity="0"/></body>
    <body name="left" pos="0 0 1" euler="0 0 1.5707963267948966"><freejoint/>
      <geom type="box" size="0.1 0.2 0.3" mass="2" rgba="1 0 0 1"/><site name="mark" pos="0.5 0 0"/></body>
    <body name="right" pos="1 0 1"><freejoint/><geom type="box" size="0.1 0.1 0.1" mass="1" rgba="0 0 1 1"/></body>
    <body name="pyramid" pos="5 0 1" euler="0 0 1"><freejoint/><geom type="mesh" mesh="tetra" mass="3"/></body>
    <body name="pair" pos="9 0 1"><geom type="box" size="0.1 0.1 0.1" mass="1"/>
      <geom type="box" size="0.1 0.1 0.2" pos="0 0 1" mass="4"/></body>
    <body name="islands" pos="0 5 0" euler="0 0 1.5707963267948966"><geom type="mesh" mesh="two" rgba="0 1 0 1"/></body>
    <body name="base" pos="0 -5 0"><geom size="0.1"/>
      <body name="link"><joint name="hinge"/><geom size="0.1" pos="1 0 0"/></body></body>
  </worldbody>
</mujoco>
"""

H = "local h = sim.getObjectHandle\n"


@pytest.fixture
def world(tmp_path: Path) -> ScriptWorld:
    return ScriptWorld(tmp_path, SCENE, owner="host")


def corners(world: ScriptWorld, shape: str) -> np.ndarray:
    """The points of a shape's surface in the world, in a fixed order."""
    (points,) = world.lua(f"return (sim.getShapeMesh({shape}))")
    (matrix,) = world.lua(f"return sim.getObjectMatrix({shape}, -1)")
    frame = np.array(matrix).reshape(3, 4)
    placed = np.array(points).reshape(-1, 3) @ frame[:, :3].T + frame[:, 3]
    return placed[np.lexsort(placed.round(6).T)]


def test_grouped_shapes_stay_where_they_are_and_weigh_together(world: ScriptWorld) -> None:
    world.lua(H + "l, r, p, mark = h'left', h'right', h'pyramid', h'mark'")
    before = [corners(world, shape) for shape in ("l", "p", "r")]
    place = world.lua("return sim.getObjectPosition(mark, -1)")[0]
    assert world.lua("c = sim.groupShapes({l, p, r}) return c == r") == [True]
    all_before = np.vstack(before)
    assert corners(world, "c") == pytest.approx(all_before[np.lexsort(all_before.round(6).T)], abs=1e-5)
    assert world.lua("return sim.getShapeMass(c)") == [pytest.approx(6)]
    assert world.lua("return sim.isHandle(l), sim.isHandle(p)") == [False, False]
    assert world.lua("return sim.getObjectParent(mark) == c, sim.getObjectPosition(mark, -1)") == [
        True,
        pytest.approx(place, abs=1e-6),
    ]
    assert [world.lua(f"return sim.getShapeViz(c, {i}).colors")[0][:3] for i in (0, 1)] == [
        [0, 0, 1],
        [1, 0, 0],
    ]
    world.passes(2)
    assert world.lua("return sim.getObjectPosition(c, -1)")[0][2] < 0.97


def test_the_centre_and_inertia_of_a_group_are_those_of_its_members(world: ScriptWorld) -> None:
    model = world.sim.model
    mass, place = model.body_mass[[2, 3]], world.sim.data.xipos[[2, 3]]
    middle = (mass[:, np.newaxis] * place).sum(axis=0) / mass.sum()
    world.lua(H + "c = sim.groupShapes({h'left', h'right'})")
    world.sim.refresh()
    body = world.sim.model.body("right").id
    assert world.sim.data.xipos[body] == pytest.approx(middle)
    # About y, by Steiner: boxes of 0.4 x 0.6 m and 0.2 x 0.2 m, 1 m apart.
    expected = 2 * (0.16 + 0.36) / 12 + (0.04 + 0.04) / 12 + 2 / 3
    assert sorted(world.sim.model.body_inertia[body])[-1] == pytest.approx(expected)


def test_a_group_is_undone_by_the_stop(world: ScriptWorld) -> None:
    world.lua(H + "sim.groupShapes({h'left', h'right'})")
    world.sim.stop()
    assert world.handle("left") > 0
    assert world.sim.model.body("right").mass == pytest.approx(1)


def test_what_cannot_be_grouped_is_refused(world: ScriptWorld) -> None:
    world.fails(H + "sim.groupShapes({h'link', h'right'})", "'link' is moved by a joint")
    world.fails("sim.groupShapes({})", "no shapes to group")
    world.fails(H + "sim.groupShapes({h'mark', h'left'})", "'mark' is a dummy")
    assert world.lua(H + "return sim.groupShapes({h'left'}) == h'left'") == [True]


def test_a_link_may_get_more_shapes(world: ScriptWorld) -> None:
    world.lua(H + "c = sim.groupShapes({h'right', h'link'})")
    assert world.lua(H + "return c == h'link', sim.isHandle(h'hinge')") == [True, True]
    assert len(world.lua("return sim.getShapeMesh(c)")[0]) > 24


def test_a_group_is_taken_apart_again(world: ScriptWorld) -> None:
    world.lua(H + "l, r = h'left', h'right'")
    before = [corners(world, shape) for shape in ("r", "l")]
    world.lua("parts = sim.ungroupShape(sim.groupShapes({l, r}))")
    assert world.lua("return #parts, parts[1] == r, sim.getObjectName(parts[2])") == [2, True, "right_sub0"]
    assert corners(world, "parts[1]") == pytest.approx(before[0], abs=1e-6)
    assert corners(world, "parts[2]") == pytest.approx(before[1], abs=1e-6)
    # Volumes of 8 and 48 litres share 3 kg.
    assert world.lua("return sim.getShapeMass(parts[1]), sim.getShapeMass(parts[2])") == [
        pytest.approx(3 * 8 / 56),
        pytest.approx(3 * 48 / 56),
    ]
    world.passes(2)
    assert world.lua("return sim.getObjectPosition(parts[2], -1)")[0][2] < 0.97


def test_the_parts_of_a_static_shape_stay_static(world: ScriptWorld) -> None:
    world.lua(H + "parts = sim.ungroupShape(h'pair')")
    world.passes(2)
    assert world.lua("return #parts, sim.getObjectParent(parts[2])") == [2, -1]
    assert corners(world, "parts[2]")[:, 2].min() == pytest.approx(1.8)
    assert world.lua("return #sim.ungroupShapes(parts[2])") == [1]


def test_a_surface_is_divided_into_its_unconnected_parts(world: ScriptWorld) -> None:
    before = corners(world, "sim.getObjectHandle('islands')")
    world.lua("parts = sim.divideShape(sim.getObjectHandle('islands'))")
    assert world.lua("return #parts, sim.getObjectName(parts[1]), sim.getObjectName(parts[2])") == [
        2,
        "islands_sub",
        "islands_sub0",
    ]
    after = np.vstack([corners(world, "parts[1]"), corners(world, "parts[2]")])
    assert after[np.lexsort(after.round(6).T)] == pytest.approx(before, abs=1e-5)
    assert world.lua("return sim.getShapeColor(parts[1], nil, 0)")[1] == [0, 1, 0]
    world.fails("sim.getObjectHandle('islands')", "islands")
    world.fails("sim.divideShape(sim.getObjectHandle('mark'))", "'mark' is a dummy")
    assert world.lua("return #sim.divideShape(sim.getObjectHandle('right'))") == [1]


def test_the_frame_of_a_shape_moves_without_its_surface(world: ScriptWorld) -> None:
    world.lua(H + "p, l, mark = h'pyramid', h'left', h'mark'")
    before, inertia = (
        corners(world, "p"),
        world.sim.model.body_inertia[world.sim.model.body("pyramid").id].copy(),
    )
    assert world.lua(
        "return sim.relocateShapeFrame(p, {5, 1, 1, 0, 0, 0.7071067811865476, 0.7071067811865476})"
    ) == [1]
    assert world.lua("return sim.getObjectPosition(p, -1)")[0] == pytest.approx([5, 1, 1])
    assert world.lua("return sim.getObjectOrientation(p, -1)")[0] == pytest.approx([0, 0, np.pi / 2])
    assert corners(world, "p") == pytest.approx(before, abs=1e-6)
    assert sorted(world.sim.model.body("pyramid").inertia) == pytest.approx(sorted(inertia))
    place = world.lua("return sim.getObjectPosition(mark, -1)")[0]
    before = corners(world, "l")
    assert world.lua("return sim.reorientShapeBoundingBox(l, -1)") == [1]
    assert world.lua("return sim.getObjectOrientation(l, -1)")[0] == pytest.approx([0, 0, 0], abs=1e-9)
    assert world.lua("return (sim.getShapeBB(l))")[0] == pytest.approx([0.4, 0.2, 0.6])
    assert corners(world, "l") == pytest.approx(before, abs=1e-6)
    assert world.lua("return sim.getObjectPosition(mark, -1)")[0] == pytest.approx(place, abs=1e-6)


def test_a_moved_frame_keeps_the_motion_of_the_body(world: ScriptWorld) -> None:
    sim = world.sim
    dof = int(sim.model.body_dofadr[sim.model.body("right").id])
    sim.data.qvel[dof : dof + 6] = [1, 0, 0, 0, 0, 2]
    world.lua(H + "sim.relocateShapeFrame(h'right', {1, 0.5, 1, 0, 0, 1, 0})")
    dof = int(sim.model.body_dofadr[sim.model.body("right").id])
    assert sim.data.qvel[dof : dof + 6] == pytest.approx([0, 0, 0, 0, 0, 2], abs=1e-9)
    sim.refresh()
    assert sim.data.xipos[sim.model.body("right").id] == pytest.approx([1, 0, 1])


def test_seven_zeros_move_a_frame_into_the_middle(world: ScriptWorld) -> None:
    world.lua(H + "p = h'pair' sim.relocateShapeFrame(p, {0, 0, 0, 0, 0, 0, 0})")
    assert world.lua("return sim.getObjectPosition(p, -1)")[0] == pytest.approx([9, 0, 1.55])
    assert world.lua("return select(2, sim.getShapeBB(p))")[0][:3] == pytest.approx([0, 0, 0], abs=1e-9)


def test_the_bounding_box_turns_and_the_frame_stays(world: ScriptWorld) -> None:
    world.lua(H + "p = h'pyramid'")
    before, place = corners(world, "p"), world.lua("return sim.getObjectPose(p)")[0]
    assert world.lua("return sim.alignShapeBB(p, {0, 0, 0, 0, 0, 0, 1})") == [True]
    size, pose = world.lua("return sim.getShapeBB(p)")
    assert size == pytest.approx(np.ptp(before, axis=0), abs=1e-6)
    centre = world.lua(f"return sim.multiplyPoses(sim.getObjectPose(p), {{{', '.join(map(str, pose))}}})")[0]
    assert centre[:3] == pytest.approx((before.min(axis=0) + before.max(axis=0)) / 2, abs=1e-6)
    assert np.abs(centre[3:]) == pytest.approx([0, 0, 0, 1], abs=1e-6)
    assert world.lua("return sim.getProperty(p, 'bbHSize')")[0] == pytest.approx(np.array(size) / 2)
    world.fails(f"sim.setShapeBB(p, {{{size[0] * 2}, {size[1]}, {size[2]}}})", "scaled alike only")
    world.lua(f"sim.setShapeBB(p, {{{size[0] * 2}, {size[1] * 2}, {size[2] * 2}}})")
    assert world.lua("return (sim.getShapeBB(p))")[0] == pytest.approx(np.array(size) * 2)
    assert world.lua("return sim.getObjectPose(p)")[0] == pytest.approx(place)


def test_the_natural_bounding_box_is_the_smallest_and_a_copy_has_it_too(world: ScriptWorld) -> None:
    world.lua(
        H
        + """
        bar = sim.createMeshShape(0, 0, {0,0,0, 4,4,0, -1,1,0, 3,5,0, 0,0,1, 4,4,1, -1,1,1, 3,5,1},
            {0,1,2, 1,3,2, 4,6,5, 5,6,7, 0,4,1, 1,4,5, 2,3,6, 3,7,6, 0,2,4, 2,6,4, 1,5,3, 3,5,7})
        """
    )
    around = world.lua("return (sim.getShapeBB(bar))")[0]
    assert sorted(around) == pytest.approx([1, 5, 5], abs=1e-5)
    assert world.lua("return sim.alignShapeBB(bar, {0, 0, 0, 0, 0, 0, 0})") == [True]
    sides = [1, 2**0.5, 4 * 2**0.5]
    assert world.lua("return (sim.getShapeBB(bar))")[0] == pytest.approx(sides, abs=1e-5)
    world.lua("copy = sim.copyPasteObjects({bar})[1]")
    assert world.lua("return (sim.getShapeBB(copy))")[0] == pytest.approx(sides, abs=1e-5)
    world.lua("sim.relocateShapeFrame(bar, {0, 0, 0, 0, 0, 0, 0})")
    size, pose = world.lua("return sim.getShapeBB(bar)")
    assert size == pytest.approx(sides, abs=1e-5)
    assert pose == pytest.approx([0, 0, 0, 0, 0, 0, 1], abs=1e-5)


def test_the_box_of_a_primitive_cannot_be_turned(world: ScriptWorld) -> None:
    assert world.lua(H + "return sim.alignShapeBB(h'left', {0, 0, 0, 0, 0, 0, 1})") == [False]
    assert world.lua(H + "return sim.alignShapeBB(h'pair', {0, 0, 0, 0, 0, 0, 0})") == [True], "a compound"


@pytest.mark.parametrize(
    ("call", "problem"),
    [
        ("relocateShapeFrame(h'link', {0, 0, 0, 0, 0, 0, 1})", "'link' is moved by a joint"),
        ("relocateShapeFrame(h'pair', {0, 0, 0})", "a pose has 7 numbers, not 3"),
        ("relocateShapeFrame(h'mark', {0, 0, 0, 0, 0, 0, 1})", "'mark' is a dummy"),
        ("alignShapeBB(h'pair', {0, 0, 0})", "a pose has 7 numbers, not 3"),
        ("alignShapeBB(h'mark', {0, 0, 0, 0, 0, 0, 1})", "'mark' is a dummy"),
        ("generateTextShape(' ')", "no character that can be seen"),
        ("generateTextShape('a', {1, 1, 1}, 0)", "height is above 0"),
        ("generateTextShape('a', {1, 1})", "a colour is"),
    ],
)
def test_what_no_frame_can_be_is_refused(world: ScriptWorld, call: str, problem: str) -> None:
    world.fails(H + f"sim.{call}", problem)


def test_convex_parts_fill_a_closed_shape(world: ScriptWorld, monkeypatch: pytest.MonkeyPatch) -> None:
    halves = [
        np.array([[x, y, z] for x in side for y in (0, 1) for z in (0, 1)], np.float32)
        for side in ((0, 0.5), (0.5, 1))
    ]
    monkeypatch.setattr(decomposing, "is_available", lambda: True)
    monkeypatch.setattr(decomposing, "decompose", lambda points, faces, label, may_go_on: halves)
    world.lua(H + "p = h'pyramid' c = sim.convexDecompose(p, 0, {}, {})")
    assert world.lua("return sim.getObjectName(c), #sim.getShapeViz(c, 1).vertices") == ["Convex", 24]
    assert world.lua("return sim.getObjectPosition(c, -1)") == world.lua(
        "return sim.getObjectPosition(p, -1)"
    )
    assert world.lua("return sim.convexDecompose(p, 1) == p, sim.getShapeMass(p)") == [True, pytest.approx(3)]
    assert corners(world, "p") == pytest.approx(corners(world, "c"), abs=1e-6)
    monkeypatch.setattr(decomposing, "is_available", lambda: False)
    world.fails("sim.convexDecompose(p)", "library that is not installed")


def test_a_text_becomes_a_shape(world: ScriptWorld) -> None:
    place, color, size, wide, centred = world.lua("""
local text = sim.generateTextShape('Hi', {255, 0.5, 0}, 0.2)
local two = sim.generateTextShape('Hi\\nmm', nil, 0.2, true)
local _, color = sim.getShapeColor(text, nil, sim.colorcomponent_ambient_diffuse)
local low = sim.getObjectFloatParam(two, sim.objfloatparam_objbbox_min_x)
local high = sim.getObjectFloatParam(two, sim.objfloatparam_objbbox_max_x)
local place, size, wide = sim.getObjectPosition(text, -1), sim.getShapeBB(text), sim.getShapeBB(two)
sim.removeObjects({text, two})
return place, color, size, wide, {low, high}
""")
    assert place == pytest.approx([0, 0, 0], abs=1e-6)
    assert color == pytest.approx([1, 0.5, 0], abs=1e-3)
    assert size[1:] == pytest.approx([0.2, 0.02], abs=0.03)
    assert wide[0] > size[0]
    assert wide[1] > 0.3, "two lines"
    assert centred[0] == pytest.approx(-centred[1], abs=0.01)
