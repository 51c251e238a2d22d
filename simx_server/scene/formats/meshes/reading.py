"""A mesh file as parts, whatever its format. MuJoCo reads STL and OBJ itself, without colours."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.scene.formats.annotations import SceneError
from simx_server.scene.formats.sources import Sources

from . import collada, polygons
from .naming import beside, library_bytes
from .obj_materials import ObjMaterial, ObjUse, library_of, materials_used, read_materials
from .parts import Look, Part, merged

COLORED = (".dae", ".ply")
"""Endings of files with colours of their materials; the colours of an OBJ file are in its library."""

_MIRROR, _SHIFT = np.array([1.0, -1.0], np.float32), np.array([0.0, 1.0], np.float32)


def prepare(files: Mapping[str, bytes]) -> None:
    """Import the libraries that these files need, as far as they are installed. `files`: name to bytes."""
    if any(name.lower().endswith(".dae") for name in files):
        collada.prepare()
    if any(
        name.lower().endswith(".ply") or (name.lower().endswith(".stl") and polygons.is_unusual_stl(data))
        for name, data in files.items()
    ):
        polygons.prepare()


def lacks_library(ending: str) -> bool:
    """Return whether a library for files with this ending is not installed."""
    return not {".dae": collada.is_available, ".ply": polygons.is_available}[ending]()


def is_mujocos(path: Path, data: bytes) -> bool:
    """Return whether MuJoCo reads a mesh file completely: OBJ without materials, usual STL, its own format."""
    ending = path.suffix.lower()
    if ending == ".stl":
        return not polygons.is_unusual_stl(data)
    return ending == ".msh" or (ending == ".obj" and not library_of(data))


def read_parts(path: Path, name: str, sources: Sources, *, turns: bool = False) -> list[Part]:
    """Return the triangles of a mesh file by their materials.

    Args:
        path: the file.
        name: its name in errors.
        sources: the files that may be read.
        turns: whether to turn the up axis of a COLLADA file to z.

    Raises:
        SceneError: it cannot be read, or a library is missing.
        OSError: it is not there.
    """
    data, ending = sources.read(path), path.suffix.lower()
    if ending == ".dae":
        return collada.read_collada(data, name, turns=turns)
    if ending == ".ply" or (ending == ".stl" and polygons.is_unusual_stl(data)):
        return polygons.read_polygons(data, name, ending[1:])
    points, faces, places = read_by_mujoco(data, path, name)
    if ending != ".obj":
        return merged([Part(points, faces)], name)
    use = materials_used(data, len(faces))
    library = beside(path, sources)(use.library)
    known = read_materials(b"" if library is None else library_bytes(library, sources))
    return merged(by_material(points, faces, places, use, known), name)


def by_material(
    points: NDArray[np.float64],
    faces: NDArray[np.int64],
    places: NDArray[np.float32] | None,
    use: ObjUse,
    known: Mapping[str, ObjMaterial],
) -> list[Part]:
    """Return the triangles of an OBJ file by their materials; all parts have all points.

    Args:
        points: (n, 3).
        faces: (m, 3) indices of points.
        places: (m, 3, 2) u and v of the corners as MuJoCo reads them; None: the file has none.
        use: which triangles have which material.
        known: the materials of the file's library.
    """
    # MuJoCo turns the places of OBJ files upside down, as it does with images.
    upwards = None if places is None else places * _MIRROR + _SHIFT
    return [
        Part(
            points,
            faces[use.of_triangle == number],
            _look(known.get(material)),
            None if upwards is None else upwards[use.of_triangle == number],
        )
        for number, material in enumerate(use.names)
    ]


def read_by_mujoco(
    data: bytes, path: Path, name: str
) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.float32] | None]:
    """Return points (n, 3), faces (m, 3), and u and v (m, 3, 2) or None, in the file's own coordinates.

    Raises:
        SceneError: it cannot be read.
    """
    reader = mujoco.MjSpec()
    own = f"mesh{path.suffix.lower()}"
    reader.add_mesh(name="mesh", file=own, inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL)
    geom = reader.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname="mesh")
    geom.contype = geom.conaffinity = 0
    reader.assets = {own: data}
    try:
        read = reader.compile()
    except (ValueError, mujoco.FatalError) as error:
        raise SceneError(f"cannot read '{name}': {' '.join(str(error).split())}") from error
    points = read.mesh_vert.astype(float)
    for index, point in enumerate(points.copy()):
        mujoco.mju_rotVecQuat(points[index], point, read.mesh_quat[0])
    points += read.mesh_pos[0]
    places = read.mesh_texcoord[read.mesh_facetexcoord].copy() if len(read.mesh_texcoord) else None
    return points, read.mesh_face.astype(np.int64), places


def _look(material: ObjMaterial | None) -> Look:
    if material is None:
        return Look()
    color = material.color or ((1.0, 1.0, 1.0) if material.image else None)
    return Look(
        None if color is None else (*color, material.opacity),
        material.highlights,
        material.image,
    )
