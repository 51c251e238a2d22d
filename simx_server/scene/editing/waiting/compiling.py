"""Compile the edits that wait; see `waiting.py`."""

from __future__ import annotations

import copy
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from simx_server.scene.editing.in_place.same_model import SameModel
from simx_server.scene.editing.recompile import compile_edited, refusal, set_constants
from simx_server.scene.editing.transfer import carry_over
from simx_server.scene.editing.twins import Names, Twins
from simx_server.scene.formats.loader import SceneError, take_weight

from .sizes import PREFIXES

if TYPE_CHECKING:
    from simx_server.scene.live import LiveScene
    from simx_server.scene.objects import Scene

    from .waiting import Waiting


def compile_waiting(sim: LiveScene, waiting: Waiting) -> None:
    """Give the simulation, which has the scene before again, the model; make the calls that wait.

    Raises CommandError when MuJoCo cannot compile the scene; the edits are lost then.
    """
    sim.refresh()
    scene = waiting.scene
    try:
        model = compile_edited(scene.blueprint, waiting.before, scene.slots)
    except (ValueError, mujoco.FatalError, SceneError) as error:
        waiting.before.next_handle = scene.next_handle  # programs know the handles
        raise refusal(error) from error
    twins = Twins(waiting.before.names or Names(waiting.model), model)
    _check_ids(twins, waiting)
    early = [call for number, call in waiting.calls if number < waiting.edits]
    first = copy.copy(model) if early else model
    data = mujoco.MjData(first)
    differs = carry_over(
        waiting.model, waiting.data, first, data, twins, waiting.moved, waiting.weighed, waiting.copies
    )
    for start in waiting.starts:
        start.put_into(first, data)
    _settle(first, scene, differs=differs)
    scene.names = twins.new
    sim.replace_model(scene, first, data, twins)
    if early:
        for call in early:
            call()
        _compile_last(sim, model)
    for call in (*(call for _, call in waiting.calls[len(early) :]), *waiting.afterwards):
        call()


def _compile_last(sim: LiveScene, model: mujoco.MjModel) -> None:
    """Do after the calls that precede the last edit what its own compile would do. `model`: as it was compiled."""
    data, same = mujoco.MjData(model), SameModel(sim.scene, model)
    differs = carry_over(sim.model, sim.data, model, data, same)
    _settle(model, sim.scene, differs=differs)
    sim.replace_model(sim.scene, model, data, same)


def _settle(model: mujoco.MjModel, scene: Scene, *, differs: bool) -> None:
    """Complete a model that has got the settings of the one before. `differs`: they are not the compiled ones."""
    differs |= take_weight(model, scene.weightless_bodies)
    if differs:
        set_constants(model)


_NUMBERED = ("body", "geom", "jnt", "site", "cam", "light", "tendon", "sensor")


def _check_ids(twins: Twins, waiting: Waiting) -> None:
    """Raise RuntimeError where elements have other numbers than the scene says."""
    for kind in _NUMBERED:
        before = twins.before(kind)
        if not twins.keeps_order(kind) or (before[np.count_nonzero(before >= 0) :] >= 0).any():
            raise RuntimeError(f"elements of the kind {kind} have got another order by an edit that waited")
    objects = waiting.scene.objects
    new = [objects[handle] for handle in waiting.handles if handle in objects]
    for element in {item.element for item in new}:
        items = [item for item in new if item.element == element]
        names = twins.new.some(PREFIXES[element], [item.id for item in items])
        for item, name in zip(items, names, strict=True):
            if name != item.element_name:
                raise RuntimeError(
                    f"the {element} '{item.name}' has got another number by an edit that waited"
                )
