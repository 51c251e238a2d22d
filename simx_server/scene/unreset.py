"""Models that a stop does not reset (`sim_modelproperty_not_reset`): they stay where the run has brought them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from simx_client.protocol import constants as c
from simx_server.simulation.part import Part

from .objects import SceneObject
from .poses.placing import free_joint, object_pose, place
from .poses.poses import Pose

if TYPE_CHECKING:
    from .live import LiveScene

_SIZES = (7, 4, 1, 1)
"""Number of position values of a free, ball, slide and hinge joint."""


@dataclass(frozen=True)
class _Kept:
    bases: dict[int, Pose]
    positions: dict[str, np.ndarray]
    """Position values by MuJoCo joint name."""


class UnresetModels(Part):
    """Keep poses of such models and positions of their joints over the stop of a run."""

    def __init__(self, sim: LiveScene) -> None:
        self._sim = sim
        self._kept = _Kept({}, {})

    def run_stopping(self) -> None:
        self._keep()

    def run_stopped(self) -> None:
        self._bring_back()

    def _keep(self) -> None:
        scene = self._sim.scene
        self._kept = _Kept({}, {})
        wanted = {
            handle: item
            for handle, item in scene.objects.items()
            if scene.overridden(handle) & c.sim_modelproperty_not_reset
        }
        if not wanted or not np.isfinite(self._sim.data.qpos).all():  # diverged values are not kept
            return
        self._sim.refresh()
        for handle, item in wanted.items():
            if item.parent not in wanted:
                self._kept.bases[handle] = object_pose(self._sim, item)
            for joint in self._joints(item):
                address = int(self._sim.model.jnt_qposadr[joint])
                size = _SIZES[int(self._sim.model.jnt_type[joint])]
                name = self._sim.model.joint(joint).name
                self._kept.positions[name] = self._sim.data.qpos[address : address + size].copy()

    def _bring_back(self) -> None:
        sim = self._sim
        kept, self._kept = self._kept, _Kept({}, {})
        for handle, pose in kept.bases.items():
            item = sim.scene.objects.get(handle)
            if item is not None and item.element != "tendon":
                place(sim, item, pose)
        for joint in range(sim.model.njnt):
            values = kept.positions.get(sim.model.joint(joint).name)
            if values is not None:
                address = int(sim.model.jnt_qposadr[joint])
                sim.data.qpos[address : address + len(values)] = values
        if kept.bases:
            sim.changed()

    def _joints(self, item: SceneObject) -> list[int]:
        if item.element == "joint":
            return [item.id]
        free = free_joint(self._sim.model, item.id) if item.element == "body" else -1
        return [free] if free >= 0 else []
