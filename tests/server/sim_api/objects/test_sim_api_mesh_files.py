"""Mesh files that scripts import: colours and textures of an OBJ file's library."""

from __future__ import annotations

from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import cv2
import numpy as np
import pytest
from collada_files import PLY, collada
from sim_api_calls import ScriptWorld

from simx_server.simulation.part import Part

SQUARE = """
mtllib square.mtl
v -1 -1 0
v 1 -1 0
v 1 1 0
v -1 1 0
vt 0 0
vt 1 0
vt 1 1
vt 0 1
usemtl pictured
f 1/1 2/2 3/3 4/4
usemtl plain
v -1 -1 -1
v 1 -1 -1
v 1 1 -1
f 5/1 6/2 7/3
"""
LIBRARY = """
newmtl pictured
Kd 1.0 1.0 1.0
map_Kd -s 1 1 1 maps\\corners.png
newmtl plain
Ks 0.5 0.5 0.2
Kd 0.25 0.5 2
d 0.75
"""

LOWER_LEFT, LOWER_RIGHT, UPPER_LEFT, UPPER_RIGHT = (
    (255, 0, 0),
    (0, 255, 0),
    (0, 0, 255),
    (255, 255, 0),
)


@pytest.fixture
def world(tmp_path: Path) -> ScriptWorld:
    (tmp_path / "square.obj").write_text(SQUARE, encoding="utf-8")
    (tmp_path / "square.mtl").write_text(LIBRARY, encoding="utf-8")
    (tmp_path / "maps").mkdir()
    rows = np.array([[UPPER_LEFT, UPPER_RIGHT], [LOWER_LEFT, LOWER_RIGHT]], np.uint8)
    pixels = rows.repeat(8, axis=0).repeat(8, axis=1)
    cv2.imwrite(str(tmp_path / "maps" / "corners.png"), pixels[..., ::-1])
    return ScriptWorld(tmp_path)


def imported(world: ScriptWorld, options: int) -> list[dict[str, Any]]:
    """The parts of the shape, as they are drawn."""
    world.lua(f"s = sim.importShape(0, 'square.obj', {options}, 0, 1)")
    return world.lua("return sim.getShapeViz(s, 0), sim.getShapeViz(s, 1)")


def color_at_corners(part: dict[str, Any]) -> dict[tuple[int, ...], tuple[int, ...]]:
    """The colour of the texture at each corner of the triangles, by the signs of its x and y."""
    points = np.array(part["vertices"]).reshape(-1, 3)[part["indices"]]
    places = np.array(part["texture"]["coordinates"]).reshape(-1, 2)
    width, height = part["texture"]["resolution"]
    pixels = np.frombuffer(part["texture"]["texture"].encode("latin-1"), np.uint8).reshape(height, width, 4)
    columns, rows = (np.clip((places * (width, height)).astype(int), 0, (width - 1, height - 1))).T
    return {
        tuple(np.sign(point[:2]).astype(int).tolist()): tuple(pixels[row, column, :3].tolist())
        for point, row, column in zip(points, rows, columns, strict=True)
    }


def test_an_obj_is_drawn_with_the_colours_and_the_textures_of_its_library(world: ScriptWorld) -> None:
    pictured, plain = imported(world, 16)
    assert pictured["colors"][:3] == [1, 1, 1]
    assert plain["colors"][:3] == pytest.approx([0.25, 0.5, 1])
    assert plain["colors"][3:6] == pytest.approx([0.4] * 3)
    assert plain["transparency"] == pytest.approx(0.25)
    assert "texture" not in plain
    assert pictured["texture"]["resolution"] == [16, 16]
    assert world.value("sim.getShapeTextureId(s)") == pictured["texture"]["id"]
    assert color_at_corners(pictured) == {
        (-1, -1): LOWER_LEFT,
        (1, -1): LOWER_RIGHT,
        (-1, 1): UPPER_LEFT,
        (1, 1): UPPER_RIGHT,
    }


def test_textures_and_colours_are_left_out_by_the_options(world: ScriptWorld) -> None:
    pictured, plain = imported(world, 0)
    assert "texture" not in pictured
    assert plain["colors"][:3] == pytest.approx([0.25, 0.5, 1])
    assert imported(world, 8)[0]["colors"][:3] == pytest.approx([0.9, 0.9, 0.9])
    pictured, plain = imported(world, 8 + 16)
    assert ("texture" in pictured, plain["colors"][0]) == (True, pytest.approx(0.9))


def test_what_a_library_lacks_is_told_and_the_shape_is_made(world: ScriptWorld, tmp_path: Path) -> None:
    (tmp_path / "maps" / "corners.png").unlink()
    assert "texture" not in imported(world, 16)[0]
    assert any("a mesh has no texture" in line for line in world.parts.status_bar.messages)
    (tmp_path / "square.mtl").unlink()
    assert imported(world, 16)[1]["colors"][:3] == pytest.approx([0.9, 0.9, 0.9])
    assert any(
        "the materials of 'square.obj' are not used" in line for line in world.parts.status_bar.messages
    )
    world.lua("sim.importShape(0, 'square.obj', 8, 0, 1)")


def test_files_outside_the_workspace_are_not_read(world: ScriptWorld, tmp_path: Path) -> None:
    outside = tmp_path.parent / f"{tmp_path.name}.png"
    cv2.imwrite(str(outside), np.full((4, 4, 3), 255, np.uint8))
    (tmp_path / "square.mtl").write_text(f"newmtl pictured\nmap_Kd ../{outside.name}\n", encoding="utf-8")
    assert "texture" not in imported(world, 16)[0]


def test_a_stop_takes_an_imported_shape_away(world: ScriptWorld) -> None:
    imported(world, 16)
    count = world.sim.model.ntex
    world.sim.stop()
    assert (count, world.sim.model.ntex) == (1, 0)


def test_a_mesh_keeps_its_shading_angle_and_drawing_options(world: ScriptWorld) -> None:
    world.lua("m = sim.createMeshShape(3, 0.35, {0,0,0, 1,0,0, 0,1,0}, {0,1,2})")
    assert world.lua("local viz = sim.getShapeViz(m, 0) return viz.shadingAngle, viz.options") == [0.35, 1]
    assert world.lua(
        "return sim.getObjectFloatParam(m, sim.shapefloatparam_shading_angle), "
        "sim.getObjectInt32Param(m, sim.shapeintparam_culling), "
        "sim.getObjectInt32Param(m, sim.shapeintparam_edge_visibility)"
    ) == [0.35, 1, 1]


class _Noted(Part):
    """The files that a recording keeps."""

    def __init__(self) -> None:
        self.names: list[str] = []

    def file_read(self, path: Path, sources: object) -> None:
        self.names.append(path.name)


def test_a_recording_gets_the_files_of_textures_too(world: ScriptWorld) -> None:
    noted = _Noted()
    world.sim.parts.attach(noted)
    imported(world, 16)
    assert sorted(set(noted.names)) == ["corners.png", "square.mtl", "square.obj"]
    noted.names.clear()
    world.lua("sim.createTexture('maps/corners.png', 0)")
    assert noted.names == ["corners.png"]


@pytest.mark.parametrize(("form", "ending"), [(0, "obj"), (3, "stl"), (4, "stl"), (6, "ply"), (7, "ply")])
def test_exported_meshes_are_read_by_another_library(
    world: ScriptWorld, tmp_path: Path, form: int, ending: str
) -> None:
    trimesh = pytest.importorskip("trimesh")
    world.lua("one = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1} faces = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3}")
    world.lua("two = {5, 0, 0, 6, 0, 0, 5, 1, 0, 5, 0, 1}")
    world.lua(f"sim.exportMesh({form}, 'out.{ending}', 0, 2, {{one, two}}, {{faces, faces}})")
    found = trimesh.load(tmp_path / f"out.{ending}", force="mesh")
    assert found.is_volume
    assert found.volume == pytest.approx(2 * 8 / 6)
    assert found.bounds.tolist() == [[0, 0, 0], [12, 2, 2]]


def test_exported_meshes_are_collada_too(world: ScriptWorld, tmp_path: Path) -> None:
    world.lua("one = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1} faces = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3}")
    world.lua("sim.exportMesh(5, 'out.dae', 0, 2, {one, one}, {faces, faces})")
    root = ElementTree.parse(tmp_path / "out.dae").getroot()
    space = {"c": "http://www.collada.org/2005/11/COLLADASchema"}
    known = {each.get("id") for each in root.iter() if each.get("id")}
    targets = {
        each.get("url") or each.get("source") for each in root.iter() if each.get("url") or each.get("source")
    }
    assert {target.removeprefix("#") for target in targets if target} <= known
    assert root.findtext("c:asset/c:up_axis", namespaces=space) == "Z_UP"
    meshes = root.findall("c:library_geometries/c:geometry/c:mesh", space)
    assert len(meshes) == len(root.findall(".//c:instance_geometry", space)) == 2
    places = meshes[0].findtext("c:source/c:float_array", namespaces=space)
    assert list(map(float, (places or "").split())) == [0, 0, 0, 2, 0, 0, 0, 2, 0, 0, 0, 2]
    corners = meshes[0].find("c:triangles", space)
    assert corners is not None
    assert (corners.get("count"), corners.findtext("c:p", namespaces=space)) == (
        "4",
        "0 2 1 0 1 3 0 3 2 1 2 3",
    )


@pytest.mark.parametrize(
    ("call", "text"),
    [
        ("2, 'a.dae', 0, 1, {{0}}, {{0}}", "not 2"),
        ("0, 'a.obj', 0, 1, {}, {}", "there are 0 and 0 tables"),
        ("0, 'a.obj', 0, 1, {{0, 0, 0}}, {{0, 0, 1}}", "indices of the 1 points"),
    ],
)
def test_a_mesh_that_cannot_be_exported_is_refused(world: ScriptWorld, call: str, text: str) -> None:
    world.fails(f"sim.exportMesh({call})", text)


# --- COLLADA and PLY ------------------------------------------------------------------------------


@pytest.fixture
def tetrahedra(tmp_path: Path) -> ScriptWorld:
    pytest.importorskip("collada")
    pytest.importorskip("trimesh")
    (tmp_path / "maps").mkdir()
    cv2.imwrite(str(tmp_path / "maps" / "map.png"), np.full((8, 8, 3), (0, 0, 255), np.uint8))
    (tmp_path / "t.dae").write_text(collada(unit=0.5, up="Y_UP", image="maps/map.png"))
    (tmp_path / "t.ply").write_text(PLY)
    (tmp_path / "bomb.dae").write_text(collada(head='<!DOCTYPE c [<!ENTITY a "a">]>'))
    return ScriptWorld(tmp_path)


def test_collada_becomes_a_shape_with_its_materials(tetrahedra: ScriptWorld) -> None:
    tetrahedra.lua("s = sim.importShape(0, 't.dae', 16, 0, 2)")
    pictured, blue = tetrahedra.lua("return sim.getShapeViz(s, 0), sim.getShapeViz(s, 1)")
    assert blue["colors"][:3] == [0, 0, 1]
    assert blue["transparency"] == pytest.approx(0.5)
    assert set(color_at_corners(pictured).values()) == {(255, 0, 0)}
    tetrahedra.lua("p = sim.importShape(0, 't.dae', 8, 0, 2)")
    plain, other = tetrahedra.lua("return sim.getShapeViz(p, 0), sim.getShapeViz(p, 1)")
    assert plain["colors"][:3] == other["colors"][:3] != [0, 0, 1]
    assert "texture" not in plain


def test_points_of_collada_and_ply_are_read_with_z_upwards(tetrahedra: ScriptWorld) -> None:
    for file, wanted in (
        ("t.dae", {(0, 0, 0), (1, 0, 0), (0, -1, 0), (0, 0, 1)}),
        ("t.ply", {(0, 0, 0), (2, 0, 0), (0, 2, 0), (0, 0, 2)}),
    ):
        ((points,), (indices,)) = tetrahedra.lua(f"return sim.importMesh(0, '{file}', 0, 0, 2)")
        assert len(indices) == 12
        assert {tuple(np.round(point, 5) + 0.0) for point in np.array(points).reshape(-1, 3)} == wanted
        (points, *_), _ = tetrahedra.lua(f"return simAssimp.importMeshes('{file}', 1, 1)")
        assert max(points) == (0.5 if file == "t.dae" else 1)
    assert tetrahedra.value("simAssimp.getImportFormat(2)") == "COLLADA"
    tetrahedra.lua("s = sim.importShape(0, 't.ply', 0, 0, 1)")
    assert tetrahedra.lua("return sim.getShapeViz(s, 0)")[0]["colors"][:3] == [1, 0, 0]


def test_collada_is_a_model_with_its_colours(tetrahedra: ScriptWorld) -> None:
    tetrahedra.lua("m = sim.loadModel('t.dae')")
    assert tetrahedra.lua("return sim.getShapeViz(m, 1)")[0]["colors"][:3] == [0, 0, 1]


def test_entities_of_collada_are_refused(tetrahedra: ScriptWorld) -> None:
    tetrahedra.fails("sim.importShape(0, 'bomb.dae', 0, 0, 1)", "declares XML entities")
    tetrahedra.fails("sim.importMesh(0, 'bomb.dae', 0, 0, 1)", "declares XML entities")
