"""Move meshes and images of a spec into files in memory.

MuJoCo keeps hulls, normals and trees of meshes that come from files, and computes them in each compile for meshes
whose points are in the spec. It also copies a spec without points in a tenth of the time. The files have MuJoCo's own
form (MSH), from which it reads the same numbers bit for bit.
"""

from __future__ import annotations

from pathlib import PurePosixPath
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from .naming import is_name, name_of

_SUFFIX = ".msh"

_FEWEST_POINTS = 4
"""Of a file; MuJoCo's message about fewer points in the spec is clearer."""

_HEAD = np.dtype("<4i4")
"""Numbers of points, normals, texture coordinates and triangles."""


def file_assets(spec: mujoco.MjSpec) -> None:
    """Move points of meshes into files in memory, and name the images among the spec's assets by their content.

    Meshes whose normals or texture coordinates have separate indices stay as they are. Files in memory that belong to
    no asset any more are dropped.
    """
    for mesh in spec.meshes:
        if len(mesh.uservert) and (data := _packed(mesh)) is not None:
            _store(spec, mesh, data)
            for name in _OF_FILE:
                setattr(mesh, name, [])
    renamed: set[str] = set()
    for texture in spec.textures:
        if texture.file in spec.assets and not is_name(texture.file):
            data = spec.assets[texture.file]
            renamed.add(texture.file)
            texture.file = name_of(data, PurePosixPath(texture.file).suffix)
            spec.assets[texture.file] = data
    if renamed:
        others = {file for texture in spec.textures for file in texture.cubefiles}
        others.update(each.file for many in (spec.meshes, spec.hfields, spec.skins) for each in many)
        for file in renamed - others:
            del spec.assets[file]
    used = {each.file for many in (spec.meshes, spec.textures) for each in many}
    for file in [file for file in spec.assets if is_name(file) and file not in used]:
        del spec.assets[file]


def give_points(
    spec: mujoco.MjSpec,
    mesh: Any,
    points: NDArray[Any],
    faces: NDArray[Any],
    *,
    coordinates: NDArray[Any] | None = None,
    normals: NDArray[Any] | None = None,
) -> None:
    """Give a new mesh its points as a file in memory. Lists of the spec are read and written value by value.

    Args:
        spec: the spec that the mesh is in.
        mesh: a mesh without points.
        points: (n, 3) in metres, at least 4.
        faces: (m, 3) indices of points.
        coordinates: (n, 2) of the texture; None: it has none.
        normals: (n, 3); None: MuJoCo computes them.
    """
    none = np.zeros(0)
    reals = points, none if normals is None else normals, none if coordinates is None else coordinates
    vertices, directions, places = (each.astype("<f4").ravel() for each in reals)
    _store(spec, mesh, _bytes_of(vertices, directions, places, faces.astype("<i4").ravel()))


def _store(spec: mujoco.MjSpec, mesh: Any, data: bytes) -> None:
    mesh.file = name_of(data, _SUFFIX)
    spec.assets[mesh.file] = data


def points_and_faces(spec: mujoco.MjSpec, mesh: Any) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """Return points (n, 3) in metres and triangles (m, 3) of a mesh whose points are in the spec, or were."""
    if not is_name(mesh.file):
        return _rows(mesh.uservert, np.float32), _rows(mesh.userface, np.int32)
    data: bytes = spec.assets[mesh.file]
    points, normals, coordinates, faces = np.frombuffer(data, _HEAD, 1)[0].tolist()
    start = _HEAD.itemsize
    end = start + 4 * (3 * points + 3 * normals + 2 * coordinates)
    return (
        np.frombuffer(data, "<f4", 3 * points, start).reshape(-1, 3),
        np.frombuffer(data, "<i4", 3 * faces, end).reshape(-1, 3),
    )


_OF_FILE = ("uservert", "usernormal", "usertexcoord", "userface")


def _packed(mesh: Any) -> bytes | None:
    """Return a mesh as a file; None if a file cannot have all of it."""
    if mesh.file or len(mesh.userfacenormal) or len(mesh.userfacetexcoord) or len(mesh.usertet):
        return None
    points, normals = np.asarray(mesh.uservert, "<f4"), np.asarray(mesh.usernormal, "<f4")
    coordinates, faces = np.asarray(mesh.usertexcoord, "<f4"), np.asarray(mesh.userface, "<i4")
    count = len(points) // 3
    if count < _FEWEST_POINTS or len(normals) not in (0, 3 * count) or len(coordinates) not in (0, 2 * count):
        return None
    if 3 * count != len(points) or len(faces) % 3:
        return None
    return _bytes_of(points, normals, coordinates, faces)


def _bytes_of(
    points: NDArray[Any], normals: NDArray[Any], coordinates: NDArray[Any], faces: NDArray[Any]
) -> bytes:
    """Return the content of a file in MuJoCo's form; all arrays are flat."""
    head = np.array([len(points) // 3, len(normals) // 3, len(coordinates) // 2, len(faces) // 3], "<i4")
    return b"".join(part.tobytes() for part in (head, points, normals, coordinates, faces))


def _rows(values: Any, kind: Any) -> NDArray[Any]:
    return np.array(values, kind).reshape(-1, 3)
