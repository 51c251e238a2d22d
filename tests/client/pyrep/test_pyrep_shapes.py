"""Functions of shapes, meshes, textures, lights, drawings, octrees and paths, called as PyRep calls them."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from c_program import CProgram, Out, ffi, numbers, text

from simx_client.protocol import constants as c
from simx_client.protocol.cli.installing import extra_line
from simx_server.scene.editing import recompile

CUBOID, RESPONDABLE, STATIC = 0, 8, 16
AMBIENT_DIFFUSE = 0
TETRAHEDRON = [0.0, 0, 0, 0.1, 0, 0, 0, 0.1, 0, 0, 0, 0.1]
FACES = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]
COLOUR = Out("float[3]")
PLACE = Out("float[3]")
MESH = Out("float **"), Out("int *"), Out("int **"), Out("int *")


def box(program: CProgram, size: float = 0.1, options: int = RESPONDABLE) -> int:
    handle: int = program.lib.simCreatePureShape(CUBOID, options, [size] * 3, 1.0, ffi.NULL)
    assert handle > 0
    return handle


def obj_file(folder: Path) -> Path:
    lines = [f"v {x} {y} {z}" for x, y, z in np.reshape(TETRAHEDRON, (4, 3))]
    lines += [f"f {a + 1} {b + 1} {d + 1}" for a, b, d in np.reshape(FACES, (4, 3))]
    (folder / "tetrahedron.obj").write_text("\n".join(lines))
    return folder / "tetrahedron.obj"


def test_a_pure_shape_has_the_mass_of_its_density(program: CProgram) -> None:
    shape = box(program)
    assert program.lib.simGetObjectType(shape) == c.sim_object_shape_type
    program.done("simComputeMassAndInertia", shape, 500.0)
    _, mass = program.call("simGetObjectFloatParameter", shape, c.sim_shapefloatparam_mass, Out("float *"))
    assert mass == pytest.approx(0.5, rel=1e-4)


def test_meshes_become_shapes_and_come_back(program: CProgram) -> None:
    shape = program.lib.simCreateMeshShape(0, math.radians(20), TETRAHEDRON, 12, FACES, 12, ffi.NULL)
    assert shape > 0
    pointers = program.call("simGetShapeMesh", shape, *MESH, Out("float **"))
    result, vertices, vertex_count, indices, index_count, normals = pointers
    assert (result, index_count) == (1, 12)
    assert len(numbers(vertices, vertex_count)) == vertex_count
    assert max(numbers(indices, index_count)) < vertex_count / 3
    assert len(numbers(indices, 3 * index_count)) == 3 * index_count, "programs read beyond the indices"
    assert np.linalg.norm(np.reshape(numbers(normals, 3 * index_count), (-1, 3)), axis=1) == pytest.approx(
        1.0
    )


def test_a_shape_is_described_part_by_part(program: CProgram) -> None:
    shape = box(program)
    info = ffi.new("struct SShapeVizInfo *")
    assert program.lib.simGetShapeViz(shape, 0, info) == 1
    assert info.indicesSize == 36
    assert len(numbers(info.normals, 3 * info.indicesSize)) == 108
    assert len(numbers(info.vertices, info.verticesSize)) == info.verticesSize
    assert list(info.textureRes) == [0, 0]
    assert program.lib.simGetShapeViz(shape, 1, info) == 0


def test_files_of_meshes_are_read_and_imported(program: CProgram, tmp_path: Path) -> None:
    path = str(obj_file(tmp_path)).encode()
    assert program.lib.simImportShape(0, path, 0, 0.0001, 1.0) > 0
    count, points, point_counts, corners, corner_counts, names = program.call(
        "simImportMesh", 0, path, 0, 0.0001, 2.0, Out("float ***"), Out("int **"), Out("int ***"), Out("int **"),
        ffi.NULL, Out("char ***"),
    )  # fmt: skip
    assert count == 1
    assert max(numbers(points[0], point_counts[0])) == pytest.approx(0.2)
    assert corner_counts[0] == 12
    assert len(numbers(corners[0], 12)) == 12
    assert text(names[0])


def test_a_convex_hull_is_returned_through_pointers(program: CProgram) -> None:
    points = [*TETRAHEDRON, 0.01, 0.01, 0.01]
    result, vertices, vertex_count, indices, index_count = program.call(
        "simGetQHull", points, len(points), *MESH, 0, ffi.NULL
    )
    assert (result, vertex_count, index_count) == (1, 12, 12)
    assert len(numbers(vertices, 12)) == len(numbers(indices, 12)) == 12


def test_shapes_are_grouped_merged_and_ungrouped(program: CProgram) -> None:
    shapes = [box(program) for _ in range(3)]
    program.done("simSetObjectPosition", shapes[1], -1, [0.3, 0, 0])
    group = program.lib.simGroupShapes(shapes[:2], 2)
    parts, count = program.call("simUngroupShape", group, Out("int*"))
    assert len(set(numbers(parts, count))) == 2
    merged = program.lib.simGroupShapes([numbers(parts, count)[0], shapes[2]], -2)
    assert program.lib.simGetObjectType(merged) == c.sim_object_shape_type


def test_a_box_is_turned_to_another_frame(program: CProgram) -> None:
    shape = box(program)
    program.done("simSetObjectOrientation", shape, -1, [0, 0, 0.5])
    program.done("simReorientShapeBoundingBox", shape, -1, 0)
    assert program.done("simGetObjectOrientation", shape, -1, Out("float[3]")) == pytest.approx(
        [0, 0, 0], abs=1e-6
    )


def test_colours(program: CProgram) -> None:
    shape = box(program)
    program.done("simSetShapeColor", shape, ffi.NULL, AMBIENT_DIFFUSE, [0.25, 0.5, 0.75])
    result, colour = program.call("simGetShapeColor", shape, ffi.NULL, AMBIENT_DIFFUSE, COLOUR)
    assert result == 1
    assert colour == pytest.approx([0.25, 0.5, 0.75])


def test_textures_are_made_set_and_read(program: CProgram, tmp_path: Path) -> None:
    lib, shape = program.lib, box(program)
    image = tmp_path / "stripes.png"
    cv2.imwrite(str(image), np.tile(np.array([[[255, 0, 0]], [[0, 255, 0]]], np.uint8), (4, 8, 1)))
    nothing = [ffi.NULL] * 3
    plane = lib.simCreateTexture(str(image).encode(), 0, *nothing, 0, *nothing)
    texture = lib.simGetShapeTextureId(plane)
    assert texture >= 0
    program.done("simSetShapeTexture", shape, texture, 0, 3, [4.0, 4.0], ffi.NULL, ffi.NULL)
    assert lib.simGetShapeTextureId(shape) == texture
    assert lib.simGetShapeTextureId(box(program)) == -1


def test_relative_paths_of_files_start_in_the_working_folder(
    program: CProgram, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    name = obj_file(tmp_path).name
    cv2.imwrite(str(tmp_path / "red.png"), np.full((4, 4, 3), 9, np.uint8))
    (tmp_path / "below").mkdir()
    monkeypatch.chdir(tmp_path / "below")
    nothing = [ffi.NULL] * 3
    assert program.lib.simCreateTexture(b"../red.png", 0, *nothing, 0, *nothing) > 0
    assert program.lib.simImportShape(0, f"../{name}".encode(), 0, 0.0001, 1.0) > 0
    assert program.lib.simSaveScene(b"kept.simx-scene") != -1
    assert (tmp_path / "below" / "kept.simx-scene").exists()


def test_a_texture_of_pixels_is_applied(program: CProgram) -> None:
    shape = program.lib.simCreateMeshShape(0, 0.3, TETRAHEDRON, 12, FACES, 12, ffi.NULL)
    coordinates = [0.0, 0.0, 1.0, 0.0, 1.0, 1.0] * 4
    pixels = bytes(range(48))
    assert program.lib.simApplyTexture(shape, coordinates, len(coordinates), pixels, [4, 4], 0) >= 0
    assert program.lib.simGetShapeTextureId(shape) >= 0


def test_forces_move_a_shape(program: CProgram) -> None:
    falling = program.handle("falling")
    program.run(1)
    before = program.done("simGetObjectPosition", falling, -1, PLACE)
    for _ in range(10):
        program.done("simAddForce", falling, [0, 0, 0], [5.0, 0, 0])
        program.done("simAddForceAndTorque", falling, ffi.NULL, [0.0, 0, 0.1])
        program.lib.simExtStep(True)
    assert program.done("simGetObjectPosition", falling, -1, PLACE)[0] > before[0] + 0.1
    assert program.call("simGetObjectVelocity", falling, PLACE, PLACE)[2][2] > 0.1


def test_lights_are_switched_and_coloured(program: CProgram) -> None:
    lamp = program.handle("lamp")
    program.done("simSetLightParameters", lamp, 1, ffi.NULL, [0.5, 0.25, 0.0], ffi.NULL)
    state, diffuse, _ = program.call("simGetLightParameters", lamp, ffi.NULL, COLOUR, COLOUR)
    assert state == 1
    assert diffuse == pytest.approx([0.5, 0.25, 0.0])
    program.done("simSetLightParameters", lamp, 0, ffi.NULL, ffi.NULL, ffi.NULL)
    assert program.call("simGetLightParameters", lamp, ffi.NULL, COLOUR, COLOUR)[0] == 0


def test_drawings_take_items_and_are_emptied(program: CProgram) -> None:
    nothing: Any = ffi.NULL
    drawing = program.lib.simAddDrawingObject(1, 3, 0, -1, 99999, [1, 0, 1], nothing, nothing, nothing)
    assert drawing > 0
    for item in ([0, 0, 0, 1, 1, 1], ffi.NULL):
        program.done("simAddDrawingObjectItem", drawing, item)
    program.done("simRemoveDrawingObject", drawing)


def test_octrees_take_and_give_voxels(program: CProgram) -> None:
    lib = program.lib
    octree = lib.simCreateOctree(0.1, 0, 2.0, ffi.NULL)
    assert lib.simGetOctreeVoxels(octree, ffi.new("int *"), ffi.NULL) == ffi.NULL
    assert lib.simInsertVoxelsIntoOctree(octree, 0, [1.0, 1, 1, 2, 2, 2], 2, ffi.NULL, ffi.NULL, ffi.NULL) > 0
    voxels, count = program.call("simGetOctreeVoxels", octree, Out("int *"), ffi.NULL)
    assert count == 2
    assert len(numbers(voxels, 6)) == 6
    assert lib.simCheckOctreePointOccupancy(octree, 0, [1.0, 1, 1], 1, ffi.NULL, ffi.NULL, ffi.NULL) == 1
    lib.simRemoveVoxelsFromOctree(octree, 0, [1.0, 1, 1], 1, ffi.NULL)
    assert lib.simCheckOctreePointOccupancy(octree, 0, [1.0, 1, 1], 1, ffi.NULL, ffi.NULL, ffi.NULL) == 0
    lib.simRemoveVoxelsFromOctree(octree, 0, ffi.NULL, 0, ffi.NULL)
    assert lib.simInsertObjectIntoOctree(octree, program.handle("crate"), 0, ffi.NULL, 0, ffi.NULL) > 0
    assert lib.simSubtractObjectFromOctree(octree, program.handle("crate"), 0, ffi.NULL) == 0


def test_paths_give_positions_and_directions(program: CProgram) -> None:
    colours = [0.0, 0, 1, 0, 0, 0, 0.25, 0.25, 0.25, 0, 0, 0]
    path = program.lib.simCreatePath(0, [3, 1, 0], [0.01, 0.1, 1.0], colours)
    assert program.lib.simGetObjectType(path) == c.sim_object_path_type
    assert program.call("simGetPositionOnPath", path, 0.5, PLACE)[0] in (-1, 1)
    assert program.call("simGetOrientationOnPath", path, 0.5, PLACE)[0] in (-1, 1)


def test_a_shape_is_decomposed_into_convex_parts_in_its_place_or_as_a_copy(program: CProgram) -> None:
    pytest.importorskip("coacd", reason=extra_line("convex"))
    shape = program.lib.simCreateMeshShape(0, math.radians(20), TETRAHEDRON, 12, FACES, 12, ffi.NULL)
    parameters = [1, 500, 200, 0, 0, 0, 0, 0, 0, 0], [100.0, 30.0, 0.25, 0, 0, 0, 0, 0, 0, 0]
    copy = program.lib.simConvexDecompose(shape, 0, *parameters)
    assert copy not in (-1, shape)
    assert program.lib.simConvexDecompose(shape, 1, *parameters) == shape


def test_a_mesh_becomes_coarser(program: CProgram) -> None:
    pytest.importorskip("fast_simplification")
    ball = program.lib.simCreatePureShape(1, 0, [0.2] * 3, 1.0, ffi.NULL)
    _, vertices, vertex_count, indices, index_count, _ = program.call(
        "simGetShapeMesh", ball, *MESH, Out("float **")
    )
    points, corners = numbers(vertices, vertex_count), numbers(indices, index_count)
    _, _, fewer_points, _, fewer = program.call(
        "simGetDecimatedMesh", points, len(points), corners, len(corners), *MESH, 0.2, 0, ffi.NULL
    )
    assert fewer < 0.3 * index_count
    assert fewer_points < vertex_count


def test_a_shape_is_decomposed_into_convex_parts(program: CProgram) -> None:
    pytest.importorskip("coacd")
    corner = [0.0, 0, 0, 0.2, 0, 0, 0.2, 0.05, 0, 0.05, 0.05, 0, 0.05, 0.2, 0, 0, 0.2, 0]
    points = [*corner, *[value + (0.1 if index % 3 == 2 else 0) for index, value in enumerate(corner)]]
    sides = [index for a in range(6) for b in [(a + 1) % 6] for index in (a, b, a + 6, b, b + 6, a + 6)]
    floor = [0, 3, 1, 1, 3, 2, 0, 4, 3, 0, 5, 4]
    faces = [*floor, *sides, *[index + 6 for index in (0, 1, 3, 1, 2, 3, 0, 3, 4, 0, 4, 5)]]
    shape = program.lib.simCreateMeshShape(0, 0.3, points, len(points), faces, len(faces), ffi.NULL)
    made = program.lib.simConvexDecompose(
        shape, 1, [1, 500, 200, 0, 0, 0, 0, 0, 0, 0], [100.0, 30.0, 0.25, *[0.0] * 7]
    )
    assert made == shape, "morphing keeps the handle"


def test_shapes_that_pyrep_makes_and_removes_are_compiled_together(
    program: CProgram, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The calls of `Shape.create` and `remove`."""
    compiles: list[int] = []
    compile_spec = recompile.compile_spec

    def counted(*arguments: Any) -> Any:
        compiles.append(1)
        return compile_spec(*arguments)

    program.call("simGetObjectPosition", box(program), -1, PLACE)
    monkeypatch.setattr(recompile, "compile_spec", counted)
    shapes: list[int] = []
    for number in range(10):
        shape = box(program, options=RESPONDABLE if number % 2 else STATIC)
        assert program.lib.simGetObjectType(shape) == c.sim_object_shape_type
        bits = program.lib.simGetObjectSpecialProperty(shape)
        program.done("simSetObjectSpecialProperty", shape, bits | c.sim_objectspecialproperty_renderable)
        program.done("simResetDynamicObject", shape)
        program.done("simSetObjectPosition", shape, -1, [0.3 * number, 0, 1])
        program.done("simSetShapeColor", shape, ffi.NULL, AMBIENT_DIFFUSE, [1, 0, 0])
        shapes.append(shape)
    assert not compiles
    _, place = program.call("simGetObjectPosition", shapes[-1], -1, PLACE)
    assert place == pytest.approx([2.7, 0, 1])
    assert len(compiles) == 1
    for shape in shapes:
        assert program.lib.simGetModelProperty(shape) == c.sim_modelproperty_not_model
        program.done("simRemoveObject", shape)
    assert len(compiles) == 1
