"""Model files: a tree of objects under one base, read from MJCF, URDF, a V-REP file or a mesh.

The one top-level object of the file is the base; of several it is the one annotated `simx:model base=yes`, else the
first body, and the others become its children in the tree. Geoms in the file's world itself become one body, named
after the file, so that they can be moved.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path, PurePosixPath

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_client.protocol.files import MESH_SUFFIXES
from simx_server.scene.editing.transplant import gather_geoms, strip
from simx_server.scene.editing.waiting.templates import Template
from simx_server.scene.objects import Scene
from simx_server.scene.spec_elements import bodies_of

from .annotations import SceneError
from .loader import build
from .loose_meshes import settle
from .meshes.parts import Part, as_one
from .meshes.reading import COLORED, is_mujocos, read_by_mujoco, read_parts
from .sources import Sources
from .specs import SpecOfFile, read_spec


@dataclass(frozen=True)
class Model:
    """A file that was read, without what `strip` takes from its spec, and its object that is the base."""

    scene: Scene
    base: int
    is_saved: bool = False
    """The server has saved the file."""
    template: Template | None = None
    """The objects; None if some are in the file's world itself."""
    size: int = 0
    """Bytes of the compiled model."""


def read_model(path: Path, name: str | None = None, sources: Sources | None = None) -> Model:
    """Read and check a model file alone.

    Args:
        name: name of the file, by default its own name; objects without a name get its stem.
        sources: search folders for the files that it names.

    Raises:
        SceneError: it is not a model.
    """
    name = name or path.name
    is_mesh = path.suffix.lower() in MESH_SUFFIXES
    read = SpecOfFile(_mesh_spec(path, name, sources)) if is_mesh else read_spec(path, sources, name)
    spec = read.spec
    if list(spec.worldbody.geoms):
        stem = PurePosixPath(name).stem
        taken = {body.name for body in bodies_of(spec)}
        while stem in taken:
            stem += "_base"
        gather_geoms(spec, stem)
    scene, compiled = build(spec, path.with_name(name))
    scene.import_report, scene.vrep_source = read.report, read.source
    strip(scene.spec)
    top = scene.children(-1)
    if not top:
        raise SceneError(f"'{name}' has no objects, so it is no model")
    marked = [h for h in top if scene.objects[h].annotations.get("model", {}).get("base")]
    bodies = [h for h in top if scene.objects[h].element in ("body", "joint")]
    template = Template.of_part(scene, compiled, [sensor.name for sensor in scene.spec.sensors])
    base = (marked or bodies or top)[0]
    return Model(scene, base, read.is_saved, template, mujoco.mj_sizeModel(compiled))


@dataclass(frozen=True)
class Triangles:
    """The content of a mesh file."""

    points: NDArray[np.float64]
    """(n, 3) in the file's own coordinates, metres."""
    faces: NDArray[np.int32]
    """(m, 3) indices of points."""
    places: NDArray[np.float32] | None
    """(m, 3, 2) u and v of a texture at the corners, v downwards; None where the file does not say."""


def read_triangles(path: Path, name: str, sources: Sources | None = None, *, turns: bool = True) -> Triangles:
    """Return the content of a mesh file.

    Args:
        name: name of the file in errors.
        sources: the files that may be read.
        turns: whether to turn the up axis of a COLLADA file to z.

    Raises:
        SceneError: it cannot be read.
    """
    sources = sources or Sources.of()
    data = _content(path, name, sources)
    if is_mujocos(path, data) or path.suffix.lower() == ".obj":
        points, faces, places = read_by_mujoco(data, path, name)
        return Triangles(points, faces.astype(np.int32), places)
    part = as_one(read_parts(path, name, sources, turns=turns))
    return Triangles(part.points, part.faces.astype(np.int32), None)


def _content(path: Path, name: str, sources: Sources) -> bytes:
    try:
        return sources.read(path)
    except OSError as error:
        raise SceneError(f"cannot read '{name}': {error.strerror}") from None


def _mesh_spec(path: Path, file_name: str, sources: Sources | None) -> mujoco.MjSpec:
    """Return a static body with the mesh as its shape, in the file's own coordinates (metres).

    The spec contains the points: later edits do not need the file. COLLADA and PLY files have their colours.
    """
    name = PurePosixPath(file_name).stem
    spec = mujoco.MjSpec()
    body = spec.worldbody.add_body(name=name)
    for number, part in enumerate(_parts(path, file_name, sources or Sources.of())):
        own = name if number == 0 else f"{name}_{number}"
        spec.add_mesh(
            name=own,
            uservert=part.points.ravel(),
            userface=part.faces.ravel().astype(np.int32),
            inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
        )
        geom = body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=own)
        if part.look.color is not None:
            geom.rgba = list(part.look.color)
        settle(geom)
    return spec


def _parts(path: Path, file_name: str, sources: Sources) -> list[Part]:
    if path.suffix.lower() in COLORED:
        _content(path, file_name, sources)
        return read_parts(path, file_name, sources, turns=True)
    read = read_triangles(path, file_name, sources)
    return [Part(read.points, read.faces.astype(np.int64))]
