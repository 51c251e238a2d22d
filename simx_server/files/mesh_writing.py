"""Meshes as the content of files: OBJ, STL, PLY and COLLADA."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from simx_server.errors import CommandError

_BINARY_STL = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_BINARY_FACE = np.dtype([("count", "u1"), ("corners", "<i4", 3)])


class Mesh(NamedTuple):
    """Triangles."""

    vertices: NDArray[np.float64]
    """(vertices, 3)"""
    faces: NDArray[np.intp]
    """(triangles, 3) indices of vertices."""


def mesh_of(numbers: Sequence[float], indices: Sequence[int], scaling: float = 1.0) -> Mesh:
    """Return a mesh of flat lists; numbers after the last three are ignored, as in V-REP.

    Args:
        numbers: x, y, z of each point.
        indices: of the points of each triangle, from 0.
        scaling: of the points.

    Raises:
        CommandError: an index has no point.
    """
    points = np.array(numbers[: len(numbers) // 3 * 3], dtype=float).reshape(-1, 3)
    faces = np.array(indices[: len(indices) // 3 * 3], dtype=np.intp).reshape(-1, 3)
    if faces.size and not 0 <= faces.min() <= faces.max() < len(points):
        raise CommandError(f"corners of triangles are indices of the {len(points)} points, from 0")
    return Mesh(points * scaling, faces)


def as_obj(meshes: Sequence[Mesh]) -> bytes:
    """Return an OBJ file with an object for each mesh."""
    lines: list[str] = []
    first = 1
    for number, mesh in enumerate(meshes, 1):
        lines.append(f"o mesh{number}")
        lines += [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in mesh.vertices.tolist()]
        lines += [f"f {a} {b} {c}" for a, b, c in (mesh.faces + first).tolist()]
        first += len(mesh.vertices)
    return ("\n".join(lines) + "\n").encode()


def as_text_stl(meshes: Sequence[Mesh]) -> bytes:
    """Return a text STL file with a solid for each mesh."""
    lines: list[str] = []
    for number, mesh in enumerate(meshes, 1):
        lines.append(f"solid mesh{number}")
        corners = mesh.vertices[mesh.faces]
        for normal, triangle in zip(_normals(corners).tolist(), corners.tolist(), strict=True):
            lines.append("facet normal {:.9g} {:.9g} {:.9g}\nouter loop".format(*normal))
            lines += ["vertex {:.9g} {:.9g} {:.9g}".format(*corner) for corner in triangle]
            lines.append("endloop\nendfacet")
        lines.append(f"endsolid mesh{number}")
    return ("\n".join(lines) + "\n").encode()


def as_binary_stl(meshes: Sequence[Mesh]) -> bytes:
    """Return a binary STL file with the triangles of all meshes."""
    corners = np.concatenate([mesh.vertices[mesh.faces] for mesh in meshes])
    rows = np.zeros(len(corners), _BINARY_STL)
    rows["normal"], rows["corners"] = _normals(corners), corners
    return bytes(80) + len(rows).to_bytes(4, "little") + rows.tobytes()


def as_text_ply(meshes: Sequence[Mesh]) -> bytes:
    """Return a text PLY file with the triangles of all meshes."""
    vertices, faces = _joined(meshes)
    lines = [f"{x:.9g} {y:.9g} {z:.9g}" for x, y, z in vertices.tolist()]
    lines += [f"3 {a} {b} {c}" for a, b, c in faces.tolist()]
    return _ply_head("ascii", len(vertices), len(faces)) + ("\n".join(lines) + "\n").encode()


def as_binary_ply(meshes: Sequence[Mesh]) -> bytes:
    """Return a binary PLY file with the triangles of all meshes."""
    vertices, faces = _joined(meshes)
    rows = np.zeros(len(faces), _BINARY_FACE)
    rows["count"], rows["corners"] = 3, faces
    head = _ply_head("binary_little_endian", len(vertices), len(faces))
    return head + vertices.astype("<f4").tobytes() + rows.tobytes()


def as_collada(meshes: Sequence[Mesh]) -> bytes:
    """Return a COLLADA 1.4.1 file with a node for each mesh; metres, z up."""
    geometries, nodes = "", ""
    for number, mesh in enumerate(meshes, 1):
        name, numbers = f"mesh{number}", mesh.vertices.ravel().tolist()
        places = " ".join(f"{value:.9g}" for value in numbers)
        corners = " ".join(map(str, mesh.faces.ravel().tolist()))
        axes = "".join(f'<param name="{axis}" type="float"/>' for axis in "XYZ")
        geometries += (
            f'<geometry id="{name}"><mesh><source id="{name}-points">'
            f'<float_array id="{name}-numbers" count="{len(numbers)}">{places}</float_array><technique_common>'
            f'<accessor source="#{name}-numbers" count="{len(mesh.vertices)}" stride="3">{axes}</accessor>'
            f'</technique_common></source><vertices id="{name}-vertices"><input semantic="POSITION" '
            f'source="#{name}-points"/></vertices><triangles count="{len(mesh.faces)}"><input semantic="VERTEX" '
            f'source="#{name}-vertices" offset="0"/><p>{corners}</p></triangles></mesh></geometry>\n'
        )
        nodes += f'<node id="{name}-node"><instance_geometry url="#{name}"/></node>\n'
    return (
        '<?xml version="1.0" encoding="utf-8"?>\n'
        '<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">\n'
        '<asset><unit name="meter" meter="1"/><up_axis>Z_UP</up_axis></asset>\n'
        f"<library_geometries>\n{geometries}</library_geometries>\n"
        f'<library_visual_scenes><visual_scene id="scene">\n{nodes}</visual_scene></library_visual_scenes>\n'
        '<scene><instance_visual_scene url="#scene"/></scene>\n</COLLADA>\n'
    ).encode()


WRITERS: Mapping[int, Callable[[Sequence[Mesh]], bytes]] = MappingProxyType(
    {0: as_obj, 3: as_text_stl, 4: as_binary_stl, 5: as_collada, 6: as_text_ply, 7: as_binary_ply}
)
"""By V-REP's numbers of file formats."""


def _normals(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.finfo(float).tiny)


def _joined(meshes: Sequence[Mesh]) -> Mesh:
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[:-1])])
    faces = [mesh.faces + start for mesh, start in zip(meshes, starts, strict=True)]
    return Mesh(np.concatenate([mesh.vertices for mesh in meshes]), np.concatenate(faces))


def _ply_head(form: str, vertices: int, faces: int) -> bytes:
    return (
        f"ply\nformat {form} 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n"
        f"element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    ).encode()
