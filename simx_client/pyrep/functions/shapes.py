"""Functions of shapes that return meshes through pointers."""

from __future__ import annotations

from typing import Any

from .. import c_values as c
from ..plain import Call
from .registry import c_function


@c_function()
def simGroupShapes(call: Call, shapes: Any, count: int) -> int:
    """Make a compound of shapes; a negative number of shapes merges them."""
    (handle,) = call("sim.groupShapes", [(c.integers(shapes) or [])[: abs(count)], count < 0])
    return int(handle)


@c_function()
def simImportMesh(
    call: Call, file_format: int, path: Any, options: int, tolerance: float, scaling: float,
    vertices: c.C, vertex_counts: c.C, triangles: c.C, triangle_counts: c.C, _reserved: Any, names: c.C,
) -> int:  # fmt: skip
    """Read the meshes of a file; return how many there are."""
    found = call(
        "sim.importMesh", [int(file_format), c.path(path), int(options), float(tolerance), float(scaling)]
    )
    points, faces = found[0], found[1]
    kept = [c.array("float", each) for each in points], [c.array("int", each) for each in faces]
    texts, texts_kept = c.strings(f"mesh{number}" for number in range(len(points)))
    tables = c.pointers("float", kept[0]), c.pointers("int", kept[1])
    counts = [c.array("int", [len(each) for each in some]) for some in (points, faces)]
    c.keep("simImportMesh", kept, texts, texts_kept, tables, counts)
    for target, value in zip(
        (vertices, vertex_counts, triangles, triangle_counts, names),
        (tables[0], counts[0], tables[1], counts[1], texts),
        strict=True,
    ):
        c.fill_pointer(target, value)
    return len(points)


@c_function()
def simGetShapeMesh(
    call: Call, shape: int, vertices: c.C, vertex_count: c.C, indices: c.C, index_count: c.C, normals: c.C
) -> int:
    """Write the mesh of a shape in its own frame: points, corners of triangles, three normals for each triangle."""
    points, corners, directions = call("sim.getShapeMesh", [int(shape)])
    # Programs in use read three times as many indices, in place of the normals.
    spare = [0] * (2 * len(corners))
    kept = c.array("float", points), c.array("int", [*corners, *spare]), c.array("float", directions)
    c.keep("simGetShapeMesh", kept)
    for target, value in zip((vertices, indices, normals), kept, strict=True):
        c.fill_pointer(target, value)
    vertex_count[0], index_count[0] = len(points), len(corners)
    return 1


@c_function()
def simGetQHull(
    call: Call, points: Any, length: int, vertices: c.C, vertex_count: c.C, indices: c.C, index_count: c.C,
    _option: int, _reserved: Any,
) -> int:  # fmt: skip
    """Write the convex hull of points."""
    hull, corners = call("sim.getQHull", [(c.floats(points) or [])[:length]])
    _write_mesh("simGetQHull", hull, corners, vertices, vertex_count, indices, index_count)
    return 1


@c_function()
def simGetDecimatedMesh(
    call: Call, points: Any, length: int, corners: Any, corner_length: int, vertices: c.C, vertex_count: c.C,
    indices: c.C, index_count: c.C, share: float, _option: int, _reserved: Any,
) -> int:  # fmt: skip
    """Write a mesh with this share (0 to 1) of the triangles."""
    fewer, fewer_corners = call(
        "sim.getDecimatedMesh",
        [(c.floats(points) or [])[:length], (c.integers(corners) or [])[:corner_length], float(share)],
    )
    _write_mesh("simGetDecimatedMesh", fewer, fewer_corners, vertices, vertex_count, indices, index_count)
    return 1


def _write_mesh(
    name: str, points: list[float], corners: list[int], vertices: c.C, vertex_count: c.C, indices: c.C,
    index_count: c.C,
) -> None:  # fmt: skip
    kept = c.array("float", points), c.array("int", corners)
    c.keep(name, kept)
    c.fill_pointer(vertices, kept[0])
    c.fill_pointer(indices, kept[1])
    vertex_count[0], index_count[0] = len(points), len(corners)


@c_function()
def simGetShapeViz(call: Call, shape: int, index: int, info: c.C) -> int:
    """Write how a part of a shape is drawn; return 0 behind the last part."""
    found = call("sim.getShapeViz", [int(shape), int(index)])
    if not found or found[0] is None:
        return 0
    part: dict[str, Any] = found[0]
    texture: dict[str, Any] = part.get("texture") or {}
    kept: list[Any] = [
        c.array("float", part["vertices"]),
        c.array("int", part["indices"]),
        c.array("float", part["normals"]),
        c.block(texture.get("texture", b"")),
        c.array("float", texture.get("coordinates", [])),
    ]
    c.keep("simGetShapeViz", kept)
    info.vertices, info.indices, info.normals, info.texture, info.textureCoords = kept
    info.verticesSize, info.indicesSize = len(part["vertices"]), len(part["indices"])
    info.shadingAngle = part["shadingAngle"]
    info.colors = part["colors"]
    info.textureId = texture.get("id", -1)
    info.textureRes = texture.get("resolution", [0, 0])
    info.textureApplyMode = texture.get("applyMode", 0)
    info.textureOptions = texture.get("options", part["options"])
    return 1


@c_function(c.NULL)
def simGetOctreeVoxels(call: Call, octree: int, count: c.C, _reserved: Any) -> c.C:
    """Return the centres of an octree's voxels and their number; NULL for none."""
    found = call("sim.getOctreeVoxels", [int(octree)])
    if not found or not found[0]:
        return c.NULL
    count[0] = len(found[0]) // 3
    return c.array("float", found[0])
