"""Joint velocities as V-REP measures them: from the positions at the ends of the last two simulation steps."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from .state import Binding

if TYPE_CHECKING:
    from simx_server.scene.live import LiveScene


Positions = tuple[np.ndarray, np.ndarray]
"""Copies of `qpos` and `ten_length`; never written."""


class Measured:
    """Keeps positions from one simulation step to the next.

    Positions set between two steps count as motion, as in V-REP.
    """

    def __init__(self, sim: LiveScene) -> None:
        self._sim = sim
        self._before: Positions | None = None
        self._after: Positions | None = None
        self._kept: dict[int, float] = {}
        self._data = sim.data
        self._copy, self._lengths = self._data.qpos.copy, self._data.ten_length

    def forget(self) -> None:
        """Forget all positions: a run starts and everything is at rest."""
        self._before = self._after = None
        self._kept = {}

    def keep(self, bindings: Iterable[Binding]) -> None:
        """Keep the measured values until the next simulation step; the model is about to be replaced."""
        self._kept = {b.handle: self.velocity(b) for b in bindings if b.kind != "ball"}
        self._before = self._after = None

    def remember(self) -> tuple[Positions | None, Positions | None, Mapping[int, float]]:
        """Return the kept positions, for `recall`."""
        return self._before, self._after, self._kept

    def recall(self, memory: tuple[Positions | None, Positions | None, Mapping[int, float]]) -> None:
        """Restore positions that were kept at the end of an earlier simulation step of the same model."""
        self._before, self._after = memory[:2]
        self._kept = dict(memory[2])

    @property
    def newest(self) -> Positions | None:
        """Return the positions at the end of the last simulation step of this run; None: it has had none."""
        return self._after

    def adopt(self, before: Positions | None, after: Positions | None) -> None:
        """Take over positions around a simulation step that was made outside; None: this run has had none."""
        self._before, self._after = before, after
        self._kept = {}

    def begin(self) -> None:
        """Note that a simulation step starts."""
        self._before = self._after if self._after is not None else self._positions()

    def end(self) -> None:
        """Note that a simulation step has ended, and the kinematics are fresh."""
        self._after = self._positions()
        if self._kept:
            self._kept = {}

    def velocity(self, binding: Binding) -> float:
        """Return the velocity, rad/s or m/s; a hinge's difference is taken the short way round."""
        if self._before is None or self._after is None:
            return self._kept.get(binding.handle, 0.0)
        which, index = (1, binding.id) if binding.element == "tendon" else (0, binding.qpos)
        change = float(self._after[which][index] - self._before[which][index])
        if binding.kind == "hinge" and math.isfinite(change):  # diverged physics gives any value
            change = math.remainder(change, 2 * math.pi)
        return change / self._sim.time_step

    def _positions(self) -> Positions:
        data = self._sim.data
        if data is not self._data:
            self._data, self._copy, self._lengths = data, data.qpos.copy, data.ten_length
        lengths = self._lengths
        return self._copy(), lengths.copy() if lengths.size else lengths
