"""Compile the edits that wait; see `waiting.py`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import mujoco
import numpy as np

from simx_server.scene.editing.in_place.same_model import SameModel
from simx_server.scene.editing.recompile import compile_edited, refusal, set_constants
from simx_server.scene.editing.transfer import carried_values, carry_over
from simx_server.scene.editing.twins import Names, Twins
from simx_server.scene.formats.loader import SceneError, take_weight

if TYPE_CHECKING:
    from simx_server.scene.live import LiveScene

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
    data = mujoco.MjData(model)
    twins = Twins(waiting.before.names or Names(waiting.model), model)
    _check_ids(twins)
    differs = carry_over(waiting.model, waiting.data, model, data, twins)
    differs |= take_weight(model, scene.weightless_bodies)
    if differs:
        set_constants(model)
    scene.names = twins.new
    sim.replace_model(scene, model, data, twins)
    _make_calls(sim, waiting, differs)


def _make_calls(sim: LiveScene, waiting: Waiting, differs: bool) -> None:
    """Make the calls. Those before the last edit precede what its own compile would have done."""
    early = [call for number, call in waiting.calls if number < waiting.edits]
    values = carried_values(sim.model) if early else []
    for call in early:
        call()
    if early:
        if differs or carried_values(sim.model) != values:
            set_constants(sim.model)
        sim.replace_model(sim.scene, sim.model, sim.data, SameModel(sim.scene, sim.model))
    for call in (*(call for _, call in waiting.calls[len(early) :]), *waiting.afterwards):
        call()


_NUMBERED = ("body", "geom", "jnt", "site", "cam", "light", "tendon", "sensor")


def _check_ids(twins: Twins) -> None:
    """Raise RuntimeError where elements that stay have another order than before."""
    for kind in _NUMBERED:
        after = twins.after(kind)
        if not np.array_equal(after[after >= 0], np.arange(np.count_nonzero(after >= 0))):
            raise RuntimeError(f"elements of the kind {kind} have got another order by an edit that waited")
