"""The form of shapes in scripts: how they are drawn, and convex hulls."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
from sim_api_calls import ScriptWorld

from simx_server.scene.geometry import decimating

SCENE = """
<mujoco>
  <compiler angle="radian"/>
  <asset>
    <texture name="squares" type="2d" builtin="checker" width="4" height="2" rgb1="1 0 0" rgb2="0 0 1"/>
    <material name="paint" rgba="0.2 0.4 0.6 0.75" specular="0.5" emission="0.5"/>
    <material name="pattern" texture="squares"/>
    <mesh name="tile" inertia="shell" vertex="0 0 0 1 0 0 0 1 0 1 1 0.1" face="0 1 2 1 3 2"
          texcoord="0 0 1 0 0 1 1 1"/>
  </asset>
  <worldbody>
    <body name="pair" pos="1 2 3" euler="0 0 1">
      <geom type="box" size="0.1 0.2 0.3" material="paint"/>
      <geom type="box" size="0.1 0.1 0.1" pos="0 0 1" rgba="1 1 1 1"/>
    </body>
    <body name="tile" pos="5 0 0"><geom type="mesh" mesh="tile" material="pattern"/></body>
  </worldbody>
</mujoco>
"""


@pytest.fixture
def world(tmp_path: Path) -> ScriptWorld:
    return ScriptWorld(tmp_path, SCENE, owner="pair")


def test_each_part_of_a_shape_has_its_form_and_colours(world: ScriptWorld) -> None:
    world.lua("pair = sim.getObjectHandle('pair')")
    (first,) = world.lua("return sim.getShapeViz(pair, 0)")
    points = np.array(first["vertices"]).reshape(-1, 3)
    assert points.max(axis=0).tolist() == pytest.approx([0.1, 0.2, 0.3])
    assert (len(first["indices"]), len(first["normals"])) == (36, 108)
    assert first["colors"] == pytest.approx([0.2, 0.4, 0.6, 0.5, 0.5, 0.5, 0.1, 0.2, 0.3])
    assert first["transparency"] == pytest.approx(0.25)
    assert "texture" not in first
    (second,) = world.lua("return sim.getShapeViz(pair, 1)")
    assert np.array(second["vertices"]).reshape(-1, 3)[:, 2].max() == pytest.approx(1.1)
    assert world.lua("return sim.getShapeViz(pair, 2)") in ([], [None])


def test_a_mesh_has_its_texture_and_the_places_of_its_corners_in_it(world: ScriptWorld) -> None:
    (tile,) = world.lua("return sim.getShapeViz(sim.getObjectHandle('tile'), 0)")
    texture = tile["texture"]
    assert texture["resolution"] == [4, 2]
    pixels = np.frombuffer(texture["texture"].encode("latin-1"), np.uint8).reshape(2, 4, 4)
    assert pixels[0, 0].tolist() == [255, 0, 0, 255]
    assert pixels[0, 3].tolist() == [0, 0, 255, 255]
    places = np.array(texture["coordinates"]).reshape(2, 3, 2)
    points = np.array(tile["vertices"]).reshape(-1, 3)[np.array(tile["indices"]).reshape(2, 3)]
    apart = np.linalg.norm(points[0, 1:, :] - points[0, :1, :], axis=1)
    assert np.linalg.norm(places[0, 1:] - places[0, :1], axis=1) == pytest.approx(apart, abs=1e-6)


def test_a_convex_hull_has_the_outer_points_only_and_faces_outwards(world: ScriptWorld) -> None:
    cube = [3.0 + 0.002 * value for point in itertools.product((0, 1), repeat=3) for value in point]
    inside = [3.001, 3.001, 3.0005, 3.0007, 3.001, 3.001]
    given = ", ".join(map(str, cube[:12] + inside + cube[12:]))
    points, indices = world.lua(f"return sim.getQHull({{{given}}})")
    corners = np.array(points).reshape(-1, 3)
    assert sorted(corners.round(6).ravel().tolist()) == sorted(np.round(cube, 6).tolist())
    faces = corners[np.array(indices).reshape(-1, 3)]
    assert len(faces) == 12
    volume = np.einsum("ij,ij->", faces[:, 0] - 3, np.cross(faces[:, 1] - 3, faces[:, 2] - 3)) / 6
    assert volume == pytest.approx(0.002**3, rel=1e-4)


def test_points_without_a_hull_are_refused(world: ScriptWorld) -> None:
    world.fails("sim.getQHull({0,0,0, 1,0,0, 0,1,0, 1,1,0})", "points in a plane or a line")
    world.fails("sim.getQHull({1,1,1, 1,1,1, 1,1,1, 1,1,1})", "in one place")
    world.fails("sim.getQHull({0,0,0, 1,0,0})", "from 4 to")


def _ball(rings: int) -> tuple[list[float], list[int]]:
    """Points and triangles of a unit sphere: no two triangles share a point, as in an STL file."""
    angles = np.linspace(0, 2 * np.pi, 2 * rings + 1)
    heights = np.linspace(0, np.pi, rings + 1)
    grid = np.array(
        [[np.sin(h) * np.cos(a), np.sin(h) * np.sin(a), np.cos(h)] for h in heights for a in angles]
    ).round(6)
    wide = 2 * rings + 1
    faces = [
        each
        for row in range(rings)
        for column in range(2 * rings)
        for at in (row * wide + column,)
        for each in ((at, at + wide, at + 1), (at + 1, at + wide, at + wide + 1))
    ]
    corners = grid[np.array(faces).ravel()]
    return corners.ravel().tolist(), list(range(len(corners)))


needs_decimation = pytest.mark.skipif(
    not decimating.is_available(), reason="the extra decimation is not installed: run make setup"
)


@needs_decimation
@pytest.mark.parametrize("share", [0.2, 0.5])
def test_a_coarser_mesh_has_the_share_of_triangles_and_looks_alike(world: ScriptWorld, share: float) -> None:
    points, indices = _ball(16)
    given = ", ".join(f"{{{', '.join(map(str, numbers))}}}" for numbers in (points, indices))
    found, faces = world.lua(f"return sim.getDecimatedMesh({given}, {share})")
    assert share * 0.8 <= len(faces) / len(indices) <= share + 0.01
    corners = np.array(found).reshape(-1, 3)
    assert max(faces) < len(corners)
    assert np.linalg.norm(corners, axis=1) == pytest.approx(1, abs=0.05)
    assert np.abs(corners).max(axis=0) == pytest.approx([1, 1, 1], abs=0.05)


def test_a_mesh_that_cannot_be_made_coarser_is_refused(
    world: ScriptWorld, monkeypatch: pytest.MonkeyPatch
) -> None:
    call = "sim.getDecimatedMesh({0,0,0, 1,0,0, 0,1,0}, {%s}, %s)"
    world.fails(call % ("0,1,3", "0.5"), "indices from 0 to 2")
    world.fails(call % ("0,1,2", "1.5"), "above 0, up to 1, not 1.5")
    world.fails(call % ("", "0.5"), "1 to 200000 triangles, not 0")
    monkeypatch.setattr(decimating, "is_available", lambda: False)
    world.fails(call % ("0,1,2", "0.5"), "not installed: .*pip.* install .*fast-simplification")


@needs_decimation
def test_a_mesh_of_which_nothing_would_be_left_is_refused(world: ScriptWorld) -> None:
    world.fails("sim.getDecimatedMesh({0,0,0, 1,0,0, 0,1,0}, {0,1,2}, 0.2)", "nothing would be left of 1")
    world.fails("sim.getDecimatedMesh({0,0,0, 0,0,0, 0,1,0}, {0,1,2}, 0.2)", "three different corners")
