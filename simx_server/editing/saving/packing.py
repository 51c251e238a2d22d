"""Save the scene or a model: from the world to MJCF with all the files that it names, and to the bytes of one file."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from simx_server.errors import CommandError
from simx_server.scene.editing.saving.naming import rename_elements
from simx_server.scene.formats.annotations import SceneError
from simx_server.scene.formats.archives.archive import pack
from simx_server.scene.formats.archives.packing import files_of
from simx_server.scene.formats.loader import compile_spec
from simx_server.scene.formats.specs import one_line
from simx_server.scene.naming.names import GRAFT_END, INTERNAL
from simx_server.scene.poses.start import StartKey

from .notes import note_parents, noted
from .specs import PreparedSpec, bring_up_to_date, spec_of_objects, spec_of_scene

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation
    from simx_server.world.world import World

_HIDDEN = INTERNAL + "hidden:"
"""Prefix of the names of saved bodies without an object."""


@dataclass(frozen=True)
class Packed:
    """A scene or model as files."""

    files: dict[str, bytes]
    """By their paths: `archive.XML`, which is MJCF with annotations, and the files that it names."""
    is_model: bool
    has_code_of_client: bool
    """Whether a client sent one of its scripts."""

    @cached_property
    def data(self) -> bytes:
        """Return all of them as the bytes of one file."""
        return pack(self.files, is_model=self.is_model)


def pack_scene(world: World, folder: str = "") -> Packed:
    """Return the scene with its present state, stopped or running.

    Args:
        world: the world.
        folder: start of the paths of the files that the MJCF text names, with a slash at its end.

    Raises:
        CommandError: the scene cannot be saved; the text says why.
    """
    return _pack(world, list(world.simulation.scene.objects), folder, is_model=False)


def pack_model(world: World, base: int, folder: str = "") -> Packed:
    """Return an object and all below it, as `pack_scene` does the scene.

    Raises:
        UnknownHandle: the object does not exist.
        CommandError: it is not the base of a model, or cannot be saved.
    """
    check_base(world, base)
    scene = world.simulation.scene
    handles = [base, *scene.descendants(base)]
    for each in map(scene.get, handles):
        if each.element == "geom":
            raise CommandError(
                f"'{each.name}' is a part of the world itself, which no model has; make it a body in the scene's file"
            )
    return _pack(world, handles, folder, is_model=True)


def check_base(world: World, base: int) -> None:
    """Raise UnknownHandle, or CommandError for an object that is not the base of a model."""
    scene = world.simulation.scene
    item = scene.get(base)
    if not scene.is_model_base(base):
        raise CommandError(
            f"'{item.name}' is not the base of a model, which alone can be saved; make it one with "
            "sim.setModelProperty(handle, 0)"
        )


def _pack(world: World, handles: list[int], folder: str, *, is_model: bool) -> Packed:
    sim = world.simulation
    world.clouds.show()
    world.textures.show()
    sim.refresh()
    try:
        prepared = spec_of_objects(sim, handles) if is_model else spec_of_scene(sim)
        model = bring_up_to_date(sim, prepared)
        saved = noted(sim, prepared.spec, handles, is_model=is_model)
        names = _new_names(sim, prepared, handles)
        if rename_elements(prepared.spec, names) or model is None:
            model = compile_spec(prepared.spec, logging.DEBUG)
        note_parents(saved, sim.scene, model)
        _start(sim, model, {(kind, new): old for (kind, old), new in names.items()}).add_to(prepared.spec)
        files = files_of(prepared.spec, saved.annotations(), folder)
        return Packed(files, is_model, saved.has_code_of_client)
    except (ValueError, RuntimeError, mujoco.FatalError) as error:
        if isinstance(error, CommandError):
            raise
        raise SceneError(f"MuJoCo cannot make a model of what is saved: {one_line(error)}") from error


def _new_names(sim: Simulation, prepared: PreparedSpec, handles: list[int]) -> dict[tuple[str, str], str]:
    """Return the names that elements get: those of their objects; bodies without an object get internal ones."""
    items = (sim.scene.objects[handle] for handle in handles)
    names = {(item.element, item.element_name): item.name for item in items}
    for hidden in sorted(prepared.hidden):
        plain = hidden.rpartition(GRAFT_END)[2]
        if ("body", hidden) not in names and not plain.startswith(INTERNAL):
            names["body", hidden] = _HIDDEN + plain
    return names


def _start(sim: Simulation, model: mujoco.MjModel, old_names: dict[tuple[str, str], str]) -> StartKey:
    """Return the present positions of the joints and mocap bodies of a model.

    Args:
        old_names: names in the simulation's model by kind and name, where they differ.
    """
    objects = mujoco.mjtObj
    qpos = np.array(mujoco.MjData(model).qpos)
    for joint in range(model.njnt):
        name = model.joint(joint).name
        old = mujoco.mj_name2id(sim.model, objects.mjOBJ_JOINT, old_names.get(("joint", name), name))
        if old >= 0 and sim.model.jnt_type[old] == model.jnt_type[joint]:
            here, there = int(model.jnt_qposadr[joint]), int(sim.model.jnt_qposadr[old])
            end = int(model.jnt_qposadr[joint + 1]) if joint + 1 < model.njnt else model.nq
            qpos[here:end] = sim.data.qpos[there : there + end - here]
    places: list[int] = []
    for body in np.flatnonzero(model.body_mocapid >= 0).tolist():
        name = model.body(body).name
        old = mujoco.mj_name2id(sim.model, objects.mjOBJ_BODY, old_names.get(("body", name), name))
        places.append(int(sim.model.body_mocapid[old]))
    return StartKey(qpos, sim.data.mocap_pos[places].ravel(), sim.data.mocap_quat[places].ravel())
