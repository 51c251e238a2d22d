"""The state that a start saves and a stop restores, bit for bit."""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from simx_server.scene.editing.model_state import (
    STATE,
    get_state,
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
    arrays: list[bytes]
    """Content of each array of the model that a command may write."""

    options: mujoco.MjOption
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
            arrays=list(map(bytes, sim.editable_arrays())),
            options=copy(sim.model.opt),
            parents=_parents(sim.scene),
            identities=_identities(sim.scene),
            annotations=sim.scene.annotations,
            overrides=dict(sim.scene.parent_overrides),
            model_properties=dict(sim.scene.model_properties),
            withheld=dict(sim.scene.withheld),
            joints=sim.joints.remember(),
        )

    def restore(self, sim: Simulation) -> bool:
        """Restore the saved state; return whether scene or model are other objects than before."""
        replaced = sim.model is not self.model or sim.scene is not self.scene
        self.scene.next_handle = sim.scene.next_handle  # handles of the run's new objects are not used again
        sim.scene, sim.model, sim.data = self.scene, self.model, self.data
        arrays = sim.editable_arrays()
        if b"".join(arrays) != b"".join(self.arrays):
            for array, saved in zip(arrays, self.arrays, strict=True):
                array[:] = saved
        self.model.opt = self.options  # copies them
        mujoco.mj_resetData(self.model, self.data)
        mujoco.mj_setState(self.model, self.data, self.state, STATE)
        if replaced or not self._is_of(self.scene):
            self._restore(self.scene)
        sim.joints.recall(self.joints)
        return replaced

    def _is_of(self, scene: Scene) -> bool:
        """Return whether no object was renamed, moved in the tree or given other properties since."""
        return (
            scene.annotations is self.annotations
            and scene.parent_overrides == self.overrides
            and scene.model_properties == self.model_properties
            and scene.withheld == self.withheld
            and _parents(scene) == self.parents
            and _identities(scene) == self.identities
        )

    def _restore(self, scene: Scene) -> None:
        scene.recall(self.overrides, self.model_properties, self.withheld, self.annotations)
        for handle, parent in self.parents.items():
            item = scene.objects[handle]
            item.parent = parent
            item.name, item.alias, item.annotations = self.identities[handle]
        scene.reindex()


def _parents(scene: Scene) -> dict[int, int]:
    return {handle: item.parent for handle, item in scene.objects.items()}


def _identities(scene: Scene) -> dict[int, tuple[str, str, Mapping[str, Annotation]]]:
    return {handle: (item.name, item.alias, item.annotations) for handle, item in scene.objects.items()}
