"""State, options and editable arrays of a compiled model, as copies and edits carry them over."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Any

import mujoco
import numpy as np

_EDITABLE = (
    "body_", "jnt_", "dof_", "geom_", "site_", "cam_", "light_", "actuator_", "tendon_", "eq_", "mat_", "pair_",
    "numeric_data", "qpos",
)  # fmt: skip
"""Prefixes of the names of model arrays a command may write; meshes, textures and the like are never written."""

STATE = mujoco.mjtState.mjSTATE_INTEGRATION
"""All values that the next physics step depends on: physics, controls, applied forces, mocap, user data, warm start."""


def editable_arrays(model: mujoco.MjModel) -> Iterator[tuple[str, np.ndarray]]:
    """Yield name and live view of every model array a command may write."""
    for name in _editable_names():
        value = getattr(model, name)
        if value.size:
            yield name, value


@cache
def _editable_names() -> tuple[str, ...]:
    model = mujoco.MjModel.from_xml_string("<mujoco/>")
    names = (name for name in dir(model) if name.startswith(_EDITABLE))
    return tuple(name for name in names if isinstance(getattr(model, name), np.ndarray))


def option_values(options: mujoco.MjOption) -> dict[str, Any]:
    """Return a copy of all physics options by name."""
    values = ((name, getattr(options, name)) for name in option_names())
    return {name: value.copy() if isinstance(value, np.ndarray) else value for name, value in values}


@cache
def option_names() -> tuple[str, ...]:
    """Return the names of the physics options: numbers and arrays."""
    option = mujoco.MjOption()
    names = (name for name in dir(option) if not name.startswith("_"))
    return tuple(name for name in names if isinstance(getattr(option, name), np.ndarray | int | float))


def options_of(values: dict[str, Any]) -> mujoco.MjOption:
    """Return the physics options whose values `option_values` returned."""
    options = mujoco.MjOption()
    for name, value in values.items():
        if isinstance(value, np.ndarray):
            getattr(options, name)[:] = value
        else:
            setattr(options, name, value)
    return options


def get_state(model: mujoco.MjModel, data: mujoco.MjData) -> np.ndarray:
    """Return the full integration state as one vector."""
    state = np.empty(mujoco.mj_stateSize(model, STATE))
    mujoco.mj_getState(model, data, state, STATE)
    return state
