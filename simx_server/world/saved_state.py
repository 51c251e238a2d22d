"""What a start saves and a stop brings back, bit for bit."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

if TYPE_CHECKING:
    from simx_server.joints.machine import Settings
    from simx_server.scene.formats.annotations import Annotation, Annotations
    from simx_server.scene.objects import Scene

    from .simulation import Simulation

_EDITABLE = (
    "body_", "jnt_", "dof_", "geom_", "site_", "cam_", "light_", "actuator_", "tendon_", "eq_", "mat_", "pair_", "qpos",
)  # fmt: skip
"""Beginnings of the names of model arrays a command may write; meshes, textures and the like are never written."""

STATE = mujoco.mjtState.mjSTATE_INTEGRATION
"""All that the next step depends on: physics, controls, applied forces, mocap, user data, warm start."""


def editable_arrays(model: mujoco.MjModel) -> Iterator[tuple[str, np.ndarray]]:
    """Name and live view of every model array a command may write."""
    for name in dir(model):
        if name.startswith(_EDITABLE):
            value = getattr(model, name)
            if isinstance(value, np.ndarray) and value.size:
                yield name, value


def option_values(model: mujoco.MjModel) -> dict[str, Any]:
    """A copy of all physics options."""
    values = ((name, getattr(model.opt, name)) for name in option_names())
    return {name: value.copy() if isinstance(value, np.ndarray) else value for name, value in values}


@cache
def option_names() -> tuple[str, ...]:
    """The physics options: numbers and arrays."""
    option = mujoco.MjOption()
    names = (name for name in dir(option) if not name.startswith("_"))
    return tuple(name for name in names if isinstance(getattr(option, name), np.ndarray | int | float))


def write_options(model: mujoco.MjModel, values: dict[str, Any]) -> None:
    """The reverse of `option_values`."""
    for name, value in values.items():
        if isinstance(value, np.ndarray):
            getattr(model.opt, name)[:] = value
        else:
            setattr(model.opt, name, value)


def get_state(model: mujoco.MjModel, data: mujoco.MjData) -> np.ndarray:
    """The full integration state as one vector."""
    state = np.empty(mujoco.mj_stateSize(model, STATE))
    mujoco.mj_getState(model, data, state, STATE)
    return state


@dataclass
class Snapshot:
    """A simulation as it was. An edit during the run makes a new model: the old objects are kept here untouched."""

    scene: Scene
    model: mujoco.MjModel
    data: mujoco.MjData
    state: np.ndarray
    arrays: dict[str, np.ndarray]
    options: dict[str, Any]
    parents: dict[int, int]
    identities: dict[int, tuple[str, str, Mapping[str, Annotation]]]
    """Handle to name, alias and annotations."""
    annotations: Annotations
    overrides: dict[int, int]
    model_properties: dict[int, int]
    withheld: dict[tuple[str, str], int]
    joints: Settings

    @classmethod
    def take(cls, sim: Simulation) -> Snapshot:
        """Save everything a run may change."""
        return cls(
            scene=sim.scene,
            model=sim.model,
            data=sim.data,
            state=get_state(sim.model, sim.data),
            arrays={name: value.copy() for name, value in editable_arrays(sim.model)},
            options=option_values(sim.model),
            parents={handle: item.parent for handle, item in sim.scene.objects.items()},
            identities={
                handle: (item.name, item.alias, item.annotations)
                for handle, item in sim.scene.objects.items()
            },
            annotations=sim.scene.annotations,
            overrides=dict(sim.scene.parent_overrides),
            model_properties=dict(sim.scene.model_properties),
            withheld=dict(sim.scene.withheld),
            joints=sim.joints.remember(),
        )

    def restore(self, sim: Simulation) -> bool:
        """Bring it back; True when scene, model and data are other objects than before."""
        replaced = sim.model is not self.model
        self.scene.next_handle = sim.scene.next_handle  # handles of what the run added are not given again
        sim.scene, sim.model, sim.data = self.scene, self.model, self.data
        for name, value in editable_arrays(self.model):
            saved = self.arrays[name]
            if not np.array_equal(value, saved, equal_nan=value.dtype.kind == "f"):
                value[...] = saved
        write_options(self.model, self.options)
        mujoco.mj_resetData(self.model, self.data)
        mujoco.mj_setState(self.model, self.data, self.state, STATE)
        self.scene.parent_overrides = dict(self.overrides)
        self.scene.model_properties = dict(self.model_properties)
        self.scene.withheld = dict(self.withheld)
        self.scene.annotations = self.annotations
        for handle, parent in self.parents.items():
            item = self.scene.objects[handle]
            item.parent = parent
            item.name, item.alias, item.annotations = self.identities[handle]
        self.scene.reindex()
        sim.joints.recall(self.joints)
        return replaced
