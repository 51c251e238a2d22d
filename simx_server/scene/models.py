"""Models: trees of objects under a base, brought in from files and restricted by the bits of their base.

A file becomes a model thus: its one top-level object is the base; of several it is the one annotated
`simx:model base=yes`, else the first body, and the others become its children in the tree. Geoms that stand in the
file's world itself become one body, named after the file, so that they can be moved. What a file says of a whole scene
(physics options, keyframes, length of a pass) is left out.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING

import mujoco

from simx_client.protocol.files import MESH_SUFFIXES
from simx_server.scene.editing.grafting import Graft, graft
from simx_server.scene.editing.transplant import gather_geoms
from simx_server.scene.formats.annotations import MEASURED, SceneError
from simx_server.scene.formats.loader import build, read_spec
from simx_server.scene.formats.loose_meshes import settle, settle_loose_meshes
from simx_server.scene.formats.script_texts import SCRIPT_NOTES
from simx_server.scene.formats.sources import Sources
from simx_server.scene.objects import Scene

if TYPE_CHECKING:
    from simx_server.world.world import World

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class Model:
    """A file that was read, and which of its objects is the base."""

    scene: Scene
    base: int


def load_model(world: World, path: Path) -> int:
    """Read the model of an MJCF, URDF or mesh file, and add it; the handle of its base.

    Raises SceneError, CommandError: the file is no model; the scene stays as it is.
    """
    sim = world.simulation
    model = read_model(path, path.name, sim.files.sources)
    return add_model(world, model, path.resolve().parent, is_of_client=sim.files.client_files.made(path))


def add_model(world: World, model: Model, folder: Path, *, is_of_client: bool) -> int:
    """Add a model to the scene, stopped or running; the handle of its base.

    Args:
        folder: that of its file, where its scripts lie.
        is_of_client: a client sent the file.

    Raises:
        SceneError, CommandError: it does not fit in; the scene stays as it is.
    """
    sim = world.simulation
    objects = model.scene.objects
    notes = {item.name: dict(item.annotations) for item in objects.values() if item.annotations}
    origin = {"folder": str(folder), "of_client": is_of_client}
    for note in notes.values():
        for kind in SCRIPT_NOTES.keys() & note.keys():
            note[kind] = {**note[kind], **origin}
    base = objects[model.base]
    notes.setdefault(base.name, {}).setdefault("model", {})["base"] = True
    spec = model.scene.spec.copy()
    settle_loose_meshes(spec)
    handles = graft(
        world,
        Graft(
            spec=spec,
            names={(item.element, item.element_name): item.name for item in objects.values()},
            annotations=notes,
            welded=model.scene.welded_bodies,
            registered={
                kind: model.scene.annotations.registered[kind]
                for kind in MEASURED
                if kind in model.scene.annotations.registered
            },
        ),
    )
    found = handles[base.element, base.element_name]
    for handle in model.scene.children(-1):
        item = objects[handle]
        added = handles.get((item.element, item.element_name))
        if added is not None and added != found:
            sim.scene.override_parent(added, found)
    world.object_settings.apply_masks()
    sim.changed()
    logger.info("model '%s' is loaded with %d objects", sim.scene.get(found).name, len(handles))
    return found


def read_model(path: Path, name: str | None = None, sources: Sources | None = None) -> Model:
    """Read and check a file by itself.

    Args:
        name: what the file is called, if not by its own name; objects without a name are called by its stem.
        sources: where what it names is searched.

    Raises:
        SceneError: it is no model.
    """
    name = name or path.name
    is_mesh = path.suffix.lower() in MESH_SUFFIXES
    spec = _mesh_spec(path, name, sources) if is_mesh else read_spec(path, sources, name)
    if list(spec.worldbody.geoms):
        stem = PurePosixPath(name).stem
        taken = {body.name for body in spec.bodies}
        while stem in taken:
            stem += "_base"
        gather_geoms(spec, stem)
    scene, _ = build(spec, path.with_name(name))
    top = scene.children(-1)
    if not top:
        raise SceneError(f"'{name}' has no objects, so it is no model")
    marked = [h for h in top if scene.objects[h].annotations.get("model", {}).get("base")]
    bodies = [h for h in top if scene.objects[h].element in ("body", "joint")]
    return Model(scene, (marked or bodies or top)[0])


def _mesh_spec(path: Path, file_name: str, sources: Sources | None) -> mujoco.MjSpec:
    """A static body with the mesh as its shape, in the file's own coordinates (metres).

    The points are taken into the spec: later edits need the file no more.
    """
    name = PurePosixPath(file_name).stem
    reader = mujoco.MjSpec()
    reader.add_mesh(name="mesh", file=str(path.resolve()), inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL)
    reader.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname="mesh")
    if sources is not None and sources.contents is not None:
        reader.assets = dict(sources.contents.assets)
    try:
        read = reader.compile()
    except (ValueError, mujoco.FatalError) as error:
        raise SceneError(f"cannot read '{file_name}': {' '.join(str(error).split())}") from error
    points = read.mesh_vert.copy().astype(float)
    for index, point in enumerate(read.mesh_vert):
        mujoco.mju_rotVecQuat(points[index], point.astype(float), read.mesh_quat[0])
    points += read.mesh_pos[0]
    spec = mujoco.MjSpec()
    spec.add_mesh(
        name=name,
        uservert=points.ravel(),
        userface=read.mesh_face.ravel(),
        inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
    )
    body = spec.worldbody.add_body(name=name)
    settle(body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name))
    return spec
