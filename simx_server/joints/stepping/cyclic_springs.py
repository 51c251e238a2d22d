"""Springs that pull the short way round; those of other joints need no control between the physics steps."""

from __future__ import annotations

import math
from collections.abc import Sequence

import mujoco
import numpy as np

from simx_server.joints.servo import Entry, Rule

from .indices import Columns


class CyclicSprings:
    """The springs of cyclic joints of one model, in arrays."""

    def __init__(self, entries: Sequence[Entry]) -> None:
        chosen = [(b, s) for b, s, r in entries if r == Rule.SPRING and s.cyclic]
        self._index = {binding.handle: i for i, (binding, _) in enumerate(chosen)}
        self._qpos = np.array([b.qpos for b, _ in chosen], dtype=np.intp)
        self._ctrl = np.array([b.ctrl for b, _ in chosen], dtype=np.intp)
        self._gear = np.array([b.gear for b, _ in chosen])
        self._target = np.array([s.target_position for _, s in chosen])

    def __bool__(self) -> bool:
        return bool(self._index)

    @property
    def columns(self) -> Columns:
        """Return the arrays by name, for the compiled form."""
        return {
            "spring.qpos": self._qpos,
            "spring.ctrl": self._ctrl,
            "spring.gear": self._gear,
            "spring.target": self._target,
        }

    def retarget(self, handle: int, value: float) -> bool:
        """Set the target of a joint; return False if it has no such spring."""
        index = self._index.get(handle)
        if index is None:
            return False
        self._target[index] = value
        return True

    def place_of(self, handle: int) -> int | None:
        """Return the place of a joint among the targets; None: it has no such spring."""
        return self._index.get(handle)

    def target_of(self, handle: int) -> float:
        """Return the target of a joint, rad."""
        return float(self._target[self._index[handle]])

    def control(self, data: mujoco.MjData) -> None:
        """Set the controls for the next physics step."""
        position = data.qpos[self._qpos]
        error = np.remainder(self._target - position + math.pi, 2 * math.pi) - math.pi
        data.ctrl[self._ctrl] = (position + error) * self._gear
