"""Models that a stop does not reset (`sim_modelproperty_not_reset`): they stay where the run has brought them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from simx_client.protocol import constants as c
from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.scene.objects import SceneObject
from simx_server.scene.poses.placing import free_joint, object_pose, place
from simx_server.scene.poses.poses import Pose
from simx_server.simulation.part import Part

if TYPE_CHECKING:
    from simx_server.scene.live import LiveScene
    from simx_server.scene.objects import Scene

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
        self._wanted: tuple[Scene | None, int, dict[int, SceneObject]] = None, -1, {}
        """The objects that keep their poses in a scene, and its version of the properties."""

    def scene_closing(self) -> None:
        self._wanted = None, -1, {}

    def run_stopping(self) -> None:
        self._keep()

    def run_stopped(self) -> None:
        self._bring_back()

    def _keep(self) -> None:
        self._kept = _Kept({}, {})
        wanted = self._find_wanted()
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

    def _find_wanted(self) -> dict[int, SceneObject]:
        scene, (known, version, wanted) = self._sim.scene, self._wanted
        if known is not scene or version != scene.properties_version:
            wanted = {
                handle: item
                for handle, item in scene.objects.items()
                if scene.overridden(handle) & c.sim_modelproperty_not_reset
            }
            self._wanted = scene, scene.properties_version, wanted
        return wanted

    def _bring_back(self) -> None:
        sim = self._sim
        kept, self._kept = self._kept, _Kept({}, {})
        if self._wanted[0] is not sim.scene:  # that of an edit, which the stop has taken back
            self._wanted = None, -1, {}
        if not kept.bases and not kept.positions:
            return
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
