"""Proximity sensors: sites with a rangefinder, seen as V-REP's ray sensors.

The ray starts `offset` metres along the site's +z and is `range` metres long. It meets what a camera sees (the geom
groups of `VISIBLE_GROUPS`), but nothing of the sensor's own body. V-REP computes all sensors in each pass; here a
sensor is computed from its first read on, in the sensing phase; the first time when it is read.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from ..errors import CommandError
from ..scene import frames
from ..scene.annotations import Annotation
from ..scene.objects import ObjectKind, SceneObject
from ..scene.poses import Vector, conjugate, rotate
from .visibility import VISIBLE_GROUPS

if TYPE_CHECKING:
    from ..simulation import Simulation

DEFAULT_RANGE = 10.0
"""Metres, for a rangefinder that says no range (annotation or the sensor's cutoff)."""

_GROUPS = np.array([group in VISIBLE_GROUPS for group in range(mujoco.mjNGROUP)], np.uint8)


@dataclass(frozen=True, slots=True)
class Detection:
    """The nearest thing on the ray, in the sensor's frame."""

    point: Vector
    """Metres from the sensor's origin."""
    normal: Vector
    """Unit, outward from the surface."""
    handle: int
    """Object of the surface, -1 for an unnamed geom of the world."""


class ProximitySensors:
    """What all proximity sensors of the scene detected last."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self.enabled = True
        """Boolean parameter 9: whether the sensing phase handles sensors."""
        self._results: dict[int, Detection | None] = {}
        self._read: set[int] = set()
        self._has_sensed = False
        sim.on_sensing.append(self._sense)
        sim.on_start.append(self._forget)
        sim.on_stop.append(self._forget)
        sim.on_load.append(self._forget)
        sim.on_close.append(self._forget)

    def read(self, handle: int) -> Detection | None:
        """The result of the last handling; None when nothing is in the way.

        Raises:
            UnknownHandle, WrongKind.
            CommandError: not handled since the simulation started.
        """
        item = self._sim.scene.get_kind(handle, ObjectKind.PROXIMITY_SENSOR)
        if handle not in self._results:
            self._results[handle] = self._first(item)
            self._read.add(handle)
        return self._results[handle]

    def handle(self, handle: int) -> Detection | None:
        """Compute a sensor now, explicitly handled or not; what `sim.handleProximitySensor` does."""
        item = self._sim.scene.get_kind(handle, ObjectKind.PROXIMITY_SENSOR)
        self._results[handle] = self._detect(item)
        return self._results[handle]

    def _first(self, item: SceneObject) -> Detection | None:
        if _is_explicit(item):
            raise CommandError(
                f"proximity sensor '{item.name}' is handled explicitly, and no script has handled it in this run"
            )
        if not self._has_sensed:
            raise CommandError(
                f"proximity sensor '{item.name}' has not been handled yet; it is in each pass of a running simulation"
            )
        return self._detect(item)

    def _sense(self) -> None:
        if not self.enabled:
            return
        self._has_sensed = True
        for handle in self._read:
            item = self._sim.scene.objects.get(handle)
            if item is not None and not _is_explicit(item):
                self._results[handle] = self._detect(item)

    def _forget(self) -> None:
        self._results.clear()
        self._read.clear()
        self._has_sensed = False

    def _detect(self, item: SceneObject) -> Detection | None:
        sim = self._sim
        position, quat = frames.get_pose(sim, item.handle)
        axis = np.array(rotate(quat, (0.0, 0.0, 1.0)))
        note: Annotation = item.annotations.get("proximity", {})
        offset, reach = float(note.get("offset", 0.0)), self._range(item)
        geom = np.full(1, -1, np.int32)
        normal = np.zeros(3)
        distance = mujoco.mj_ray(
            sim.model, sim.data, np.array(position) + offset * axis, axis, _GROUPS, 1, item.body, geom, normal
        )
        if not 0.0 <= distance <= reach:
            return None
        return Detection(
            point=(0.0, 0.0, offset + distance),
            normal=rotate(conjugate(quat), normal.tolist()),
            handle=sim.scene.owner_of_geom(int(geom[0]), sim.model),
        )

    def _range(self, item: SceneObject) -> float:
        """The annotation's, else the rangefinder's cutoff, else 10 m."""
        note: Annotation = item.annotations.get("proximity", {})
        if "range" in note:
            return float(note["range"])
        cutoff = float(self._sim.model.sensor_cutoff[item.sensors[0]])
        return cutoff if 0.0 < cutoff < math.inf else DEFAULT_RANGE


def _is_explicit(item: SceneObject) -> bool:
    return bool(item.annotations.get("proximity", {}).get("explicit", False))
