"""The elements before and after an edit without a compile: all have the same ids, some are another thing now."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from simx_server.scene.editing.twins import Names, Twins

if TYPE_CHECKING:
    from simx_server.scene.objects import Scene


class SameModel(Twins):
    """Twins within one model."""

    def __init__(
        self, scene: Scene, model: mujoco.MjModel, others: Mapping[str, Sequence[int]] | None = None
    ) -> None:
        """Note an edit.

        Args:
            scene: the scene before or after it.
            model: its model.
            others: ids, by kind, of the elements that became objects or were ones: they have no twin.
        """
        if scene.names is None:
            scene.names = Names(model)
        self.old = self.new = scene.names
        self._others = others or {}
        self._before: dict[str, np.ndarray] = {}
        self._after: dict[str, np.ndarray] = {}

    def before(self, kind: str) -> np.ndarray:
        if kind not in self._before:
            found = np.arange(self.new.count(kind))
            found[list(self._others.get(kind, ()))] = -1
            self._before[kind] = found
        return self._before[kind]
