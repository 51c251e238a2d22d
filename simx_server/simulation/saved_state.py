"""The state that a start saves and a stop restores, bit for bit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.scene.editing.model_state import (
    STATE,
    get_state,
)

if TYPE_CHECKING:
    from simx_server.joints import Joints
    from simx_server.joints.moments import Settings
    from simx_server.scene.formats.annotations import Annotation, Annotations
    from simx_server.scene.objects import Scene


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
    def take(
        cls,
        scene: Scene,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        arrays: Sequence[memoryview],
        joints: Joints,
    ) -> Snapshot:
        """Save everything a run may change; `arrays`: those of the model that a command may write."""
        return cls(
            scene=scene,
            model=model,
            data=data,
            state=get_state(model, data),
            arrays=list(map(bytes, arrays)),
            options=copy(model.opt),
            parents=_parents(scene),
            identities=_identities(scene),
            annotations=scene.annotations,
            overrides=dict(scene.parent_overrides),
            model_properties=dict(scene.model_properties),
            withheld=dict(scene.withheld),
            joints=joints.remember(),
        )

    def restore(self, arrays: Sequence[memoryview], *, is_replaced: bool) -> None:
        """Restore model, data and scene; the joints follow.

        Args:
            arrays: those of the model that a command may write.
            is_replaced: scene or model were other objects.
        """
        if b"".join(arrays) != b"".join(self.arrays):
            for array, saved in zip(arrays, self.arrays, strict=True):
                array[:] = saved
        self.model.opt = self.options  # copies them
        mujoco.mj_resetData(self.model, self.data)
        mujoco.mj_setState(self.model, self.data, self.state, STATE)
        if is_replaced or not self._is_of(self.scene):
            self._restore(self.scene)

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
