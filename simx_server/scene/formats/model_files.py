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
from simx_server.scene.editing.transplant import gather_geoms
from simx_server.scene.geometry.highlights import SPECULAR
from simx_server.scene.objects import Scene
from simx_server.scene.spec_elements import bodies_of

from .annotations import PREFIX, SceneError
from .loader import build
from .loose_meshes import settle
from .sources import Sources
from .specs import SpecOfFile, read_spec


@dataclass(frozen=True)
class Model:
    """A file that was read, without what `strip` takes from its spec, and its object that is the base."""

    scene: Scene
    base: int
    is_saved: bool = False
    """The server has saved the file."""


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
    scene, _ = build(spec, path.with_name(name))
    scene.import_report, scene.vrep_source = read.report, read.source
    strip(scene.spec)
    top = scene.children(-1)
    if not top:
        raise SceneError(f"'{name}' has no objects, so it is no model")
    marked = [h for h in top if scene.objects[h].annotations.get("model", {}).get("base")]
    bodies = [h for h in top if scene.objects[h].element in ("body", "joint")]
    return Model(scene, (marked or bodies or top)[0], read.is_saved)


def strip(spec: mujoco.MjSpec) -> None:
    """Remove elements of a whole scene that belong to no object: keyframes, annotations, sensors without an object."""
    for many in (spec.keys, spec.tuples, spec.numerics):
        for element in list(many):
            if not element.name.startswith(SPECULAR):
                spec.delete(element)
    for text in list(spec.texts):
        if text.name.startswith(PREFIX):
            spec.delete(text)
    for sensor in list(spec.sensors):
        if sensor.objtype == mujoco.mjtObj.mjOBJ_UNKNOWN or sensor.objname == "world":
            spec.delete(sensor)


@dataclass(frozen=True)
class Triangles:
    """The content of a mesh file."""

    points: NDArray[np.float64]
    """(n, 3) in the file's own coordinates, metres."""
    faces: NDArray[np.int32]
    """(m, 3) indices of points."""
    places: NDArray[np.float32] | None
    """(m, 3, 2) u and v of a texture at the corners, v downwards; None where the file does not say."""


def read_triangles(path: Path, name: str, sources: Sources | None = None) -> Triangles:
    """Return the content of a mesh file. Raises SceneError."""
    reader = mujoco.MjSpec()
    reader.add_mesh(name="mesh", file=str(path.resolve()), inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL)
    reader.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname="mesh")
    if sources is not None and sources.contents is not None:
        reader.assets = dict(sources.contents.assets)
    try:
        read = reader.compile()
    except (ValueError, mujoco.FatalError) as error:
        raise SceneError(f"cannot read '{name}': {' '.join(str(error).split())}") from error
    points = read.mesh_vert.copy().astype(float)
    for index, point in enumerate(read.mesh_vert):
        mujoco.mju_rotVecQuat(points[index], point.astype(float), read.mesh_quat[0])
    points += read.mesh_pos[0]
    places = read.mesh_texcoord[read.mesh_facetexcoord].copy() if len(read.mesh_texcoord) else None
    return Triangles(points, read.mesh_face.copy(), places)


def _mesh_spec(path: Path, file_name: str, sources: Sources | None) -> mujoco.MjSpec:
    """Return a static body with the mesh as its shape, in the file's own coordinates (metres).

    The spec contains the points: later edits do not need the file.
    """
    name = PurePosixPath(file_name).stem
    read = read_triangles(path, file_name, sources)
    spec = mujoco.MjSpec()
    spec.add_mesh(
        name=name,
        uservert=read.points.ravel(),
        userface=read.faces.ravel(),
        inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
    )
    body = spec.worldbody.add_body(name=name)
    settle(body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name))
    return spec
