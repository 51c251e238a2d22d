"""The state that a start saves and a stop restores, bit for bit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from simx_server.scene.editing.model_state import (
    STATE,
    get_state,
    option_values,
    write_options,
)

if TYPE_CHECKING:
    from simx_server.joints.machine import Settings
    from simx_server.scene.formats.annotations import Annotation, Annotations
    from simx_server.scene.objects import Scene

    from .simulation import Simulation


@dataclass
class Snapshot:
    """A simulation as it was. An edit during the run makes a new model: the old objects are kept here unchanged."""

    scene: Scene
    model: mujoco.MjModel
    data: mujoco.MjData
    state: np.ndarray
    arrays: list[tuple[np.ndarray, bytes]]
    """Arrays of the model that a command may write, and their content: comparing bytes takes a tenth of the time."""

    options: dict[str, Any]
    parents: dict[int, int]
    identities: dict[int, tuple[str, str, Mapping[str, Annotation]]]
    """Maps handles to name, alias and annotations."""
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
            arrays=[(value, value.tobytes()) for value in sim.editable_arrays()],
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
        """Restore the saved state; return whether scene, model and data are other objects than before."""
        replaced = sim.model is not self.model
        self.scene.next_handle = sim.scene.next_handle  # handles of the run's new objects are not used again
        sim.scene, sim.model, sim.data = self.scene, self.model, self.data
        for value, saved in self.arrays:
            if value.tobytes() != saved:
                value[...] = np.frombuffer(saved, value.dtype).reshape(value.shape)
        write_options(self.model, self.options)
        mujoco.mj_resetData(self.model, self.data)
        mujoco.mj_setState(self.model, self.data, self.state, STATE)
        self.scene.recall(self.overrides, self.model_properties, self.withheld, self.annotations)
        for handle, parent in self.parents.items():
            item = self.scene.objects[handle]
            item.parent = parent
            item.name, item.alias, item.annotations = self.identities[handle]
        self.scene.reindex()
        sim.joints.recall(self.joints)
        return replaced
