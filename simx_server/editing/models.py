"""Add a model to a scene: a tree of objects under a base, see `formats/model_files.py`.

Settings of the file that concern a whole scene are left out: physics options, keyframes, the simulation step.
"""

from __future__ import annotations

import logging
from pathlib import Path
from typing import TYPE_CHECKING

from simx_server.scene import properties
from simx_server.scene.editing.waiting.basis import when_compiled
from simx_server.scene.formats.annotations import BROUGHT
from simx_server.scene.formats.exporting.asset_files import give_full_paths
from simx_server.scene.formats.loose_meshes import settle_loose_meshes
from simx_server.scene.formats.texts.scripts import SCRIPT_NOTES
from simx_server.scene.poses.first_turns import has_turn, set_turns

from .grafts.grafting import Graft, graft
from .grafts.late import may_wait

if TYPE_CHECKING:
    from simx_server.scene.formats.model_files import Model
    from simx_server.world.world import World

logger = logging.getLogger(__name__)


def load_model(world: World, path: Path) -> int:
    """Read the model of an MJCF, URDF or mesh file, and add it; return the handle of its base.

    Raises SceneError, CommandError: the file is not a model; the scene stays as it is.
    """
    sim = world.simulation
    model = world.kept_models.read(path, path.name, sim.files.sources)
    return add_model(world, model, path.resolve().parent, is_of_client=sim.files.client_files.made(path))


def add_model(world: World, model: Model, folder: Path, *, is_of_client: bool) -> int:
    """Add a model to the scene, stopped or running; return the handle of its base.

    Args:
        folder: the folder of its file, which contains its scripts.
        is_of_client: whether a client sent the file.

    Raises:
        SceneError, CommandError: the model and the scene do not fit together; the scene stays as it is.
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
    if (report := model.scene.import_report) is not None:
        sim.parts.tell(lambda part: part.file_imported(report))
    elif not model.is_saved:
        settle_loose_meshes(spec)
    give_full_paths(spec)
    elements = {(item.element, item.element_name): item.name for item in objects.values()}
    addition = Graft(
        part=spec,
        names=elements,
        annotations=notes,
        welded=model.scene.welded_bodies,
        weightless=model.scene.weightless_bodies,
        start=model.scene.start,
        registered={
            kind: model.scene.annotations.registered[kind]
            for kind in BROUGHT
            if kind in model.scene.annotations.registered
        },
        template=lambda: model.template,
    )
    handles = graft(sim, addition, late=may_wait(world, addition))
    world.origins.add(
        model.scene,
        {elements[element]: handle for element, handle in handles.items() if element in elements},
        is_of_client=is_of_client,
    )
    found = handles[base.element, base.element_name]
    for handle in model.scene.children(-1):
        item = objects[handle]
        added = handles.get((item.element, item.element_name))
        if added is not None and added != found:
            sim.scene.override_parent(added, found)
    turned = [handle for handle in handles.values() if has_turn(sim.scene.objects[handle])]
    if turned:
        when_compiled(sim, lambda: set_turns(sim.scene, sim.model, sim.data, turned))
    properties.apply(sim)
    world.object_settings.apply_masks()
    sim.changed()
    logger.info("model '%s' is loaded with %d objects", sim.scene.get(found).name, len(handles))
    return found
