"""Copies of the state for rendering: one per version for all views; MjData is reused."""

from collections.abc import Hashable

import mujoco

from simx_client.protocol.python.light_dataclass import dataclass

_KEPT = 4
"""Number of idle MjData kept for the next copies; rarely more than a few versions are in use at once."""


@dataclass(eq=False)
class Snapshot:
    """One state, shared by its users; it must not be changed."""

    model: mujoco.MjModel
    version: Hashable
    data: mujoco.MjData
    users: int = 0


class SnapshotPool:
    """Creates and reuses snapshots. Not locked: the caller serialises."""

    def __init__(self) -> None:
        self._taken: dict[Hashable, Snapshot] = {}
        self._model: mujoco.MjModel | None = None
        self._idle: list[mujoco.MjData] = []

    def take(self, model: mujoco.MjModel, data: mujoco.MjData, version: Hashable) -> Snapshot:
        """Return a snapshot of `data`; the existing one if this version is still in use."""
        snapshot = self._taken.get((id(model), version))
        if snapshot is None:
            if model is not self._model:
                self._model, self._idle = model, []
            copied = self._idle.pop() if self._idle else mujoco.MjData(model)
            mujoco.mj_copyData(copied, model, data)
            snapshot = self._taken[id(model), version] = Snapshot(model, version, copied)
        snapshot.users += 1
        return snapshot

    def rest(self) -> None:
        """Free the MjData kept for the next copies."""
        self._model, self._idle = None, []

    def give_back(self, snapshot: Snapshot) -> None:
        """Remove one user; the last one returns the MjData to the pool."""
        snapshot.users -= 1
        if snapshot.users:
            return
        del self._taken[id(snapshot.model), snapshot.version]
        if snapshot.model is self._model and len(self._idle) < _KEPT:
            self._idle.append(snapshot.data)
