"""Changes of a model's arrays that are undone when MuJoCo cannot compute with them."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import mujoco

from simx_server.errors import CommandError, one_line

from .model_state import STATE, editable_arrays, get_state
from .twins import Names, Twins

if TYPE_CHECKING:
    from simx_server.scene.live import LiveScene


@contextmanager
def undone_on_failure(sim: LiveScene) -> Generator[None]:
    """Undo the block's changes of the model's arrays, the state, or the model itself when it fails.

    MuJoCo's error message becomes a CommandError.
    """
    scene, model, data = sim.scene, sim.model, sim.data
    arrays = {name: value.copy() for name, value in editable_arrays(model)}
    state = get_state(model, data)
    joints = sim.joints.remember()
    try:
        yield
    except Exception as error:
        if sim.model is not model:
            sim.replace_model(scene, model, data, Twins(Names(sim.model), model))
        for name, value in editable_arrays(model):
            value[...] = arrays[name]
        mujoco.mj_setState(model, data, state, STATE)
        sim.joints.recall(joints)
        sim.model_edited()
        sim.changed()
        if isinstance(error, mujoco.FatalError):
            raise CommandError(f"MuJoCo cannot make a model of that: {one_line(error)}") from error
        raise
