"""Add shapes whose model is compiled later; see `waiting.py`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from simx_server.scene.editing.copies.joining import join
from simx_server.scene.editing.recompile import refuse_in_physics
from simx_server.scene.editing.transplant import strip
from simx_server.scene.formats.annotations import Annotation
from simx_server.scene.formats.loader import SceneError, compile_spec
from simx_server.scene.naming.names import GRAFT_END, alias_of
from simx_server.scene.objects import ObjectKind, SceneObject

from .waiting import Waiting

if TYPE_CHECKING:
    from simx_server.scene.live import LiveScene


def add_shape(sim: LiveScene, spec: mujoco.MjSpec, name: str, notes: Mapping[str, Annotation]) -> int | None:
    """Add a shape that waits for the compile; return its handle, or None if it has to be compiled at once.

    Args:
        spec: one body at the top without sites, cameras and the like; adding it consumes it.
        name: of the body, and of the object; no object has it yet.
        notes: annotations by kind.

    Raises CommandError: within a physics step, or the scene has too many objects.
    """
    refuse_in_physics(sim)
    if not sim.scene.keeps_ids:
        return None
    try:
        compile_spec(spec)
    except (ValueError, mujoco.FatalError, SceneError):
        return None  # the compile of the scene has the error's text
    sim.limits.check("objects", len(sim.scene.objects) + 1, "remove some")
    waiting = sim.waiting or Waiting.of(sim.scene, sim.model, sim.data)
    scene, handle = waiting.scene, waiting.scene.next_handle
    prefix = f"{handle}{GRAFT_END}"
    strip(spec)
    known = scene.annotations
    scene.annotations = replace(known, objects={**known.objects, **({name: dict(notes)} if notes else {})})
    body = len(scene.owners)
    item = SceneObject(
        handle, name, ObjectKind.SHAPE, -1, "body", prefix + name, body, body, alias_of(name),
        scene.annotations.objects.get(name, {}),
    )  # fmt: skip
    scene.owners = np.append(scene.owners, handle)
    scene.append(item)
    waiting.added(handle, lambda whole: join(spec, whole, prefix))
    sim.hold(waiting)
    return handle
