"""Proximity sensors: sites with a rangefinder or a `simx:proximity` annotation.

They look along the site's +z (see `volume.py`) at what a camera sees too (the geom groups of `VISIBLE_GROUPS`), but not
at the shape that carries them. V-REP computes all sensors in each pass; here a sensor is computed when it is read,
from where everything was in the sensing phase of the last pass.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..errors import CommandError
from ..scene.annotations import Annotation
from ..scene.collection import ALL
from ..scene.objects import ObjectKind, SceneObject
from .detection import Detection, detect
from .instant import Instant
from .optics import Optics, optics
from .volume import TYPES

if TYPE_CHECKING:
    from ..simulation import Simulation

__all__ = ["DEFAULT_RANGE", "Detection", "ProximitySensors"]

DEFAULT_RANGE = 10.0
"""Metres, for a rangefinder that says no range (annotation or the sensor's cutoff)."""


class ProximitySensors:
    """What all proximity sensors of the scene detected last."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self.enabled = True
        """Boolean parameter 9: whether the sensing phase handles sensors; it belongs to the scene."""
        self._optics: dict[int, Optics] = {}
        self._entities: dict[int, int] = {}
        self._results: dict[int, Detection | None] = {}
        self._handled_by_hand: dict[int, Detection | None] = {}
        self._reset: set[int] = set()
        """Sensors whose result was forgotten on demand since the last pass."""
        self._explicit: dict[int, bool] = {}
        """Where a script changed whether a sensor is handled explicitly."""
        self._explicit_before_run = self._explicit
        self._instant: Instant | None = None
        """That of the last pass in which sensors were handled."""
        sim.on_sensing.append(self._sense)
        sim.on_start.append(self._begin_run)
        sim.on_stop.append(self._end_run)
        sim.on_load.append(self._forget_all)
        sim.on_close.append(self._forget_all)

    def read(self, handle: int) -> Detection | None:
        """The result of the last handling; None when nothing is in the volume.

        Raises:
            UnknownHandle, WrongKind.
            CommandError: not handled since the simulation started.
        """
        item = self._sim.scene.get_kind(handle, ObjectKind.PROXIMITY_SENSOR)
        if handle in self._handled_by_hand:
            return self._handled_by_hand[handle]
        if self.is_explicit(handle):
            raise CommandError(
                f"proximity sensor '{item.name}' is handled explicitly, and no script has handled it in this run"
            )
        if handle not in self._results:
            instant = self._instant
            if instant is None or handle not in instant.scene.objects or handle in self._reset:
                raise CommandError(
                    f"proximity sensor '{item.name}' has not been handled yet; it is in each pass of a running "
                    "simulation"
                )
            self._results[handle] = self._detect(instant, handle)
        return self._results[handle]

    def handle(self, handle: int) -> Detection | None:
        """Compute a sensor now, explicitly handled or not; what `sim.handleProximitySensor` does.

        While handling is switched off it forgets the last result instead.
        """
        self._sim.scene.get_kind(handle, ObjectKind.PROXIMITY_SENSOR)
        self._handled_by_hand.pop(handle, None)
        self._reset.discard(handle)
        if not self.enabled:
            self._results.pop(handle, None)
            return None
        found = self._handled_by_hand[handle] = self._detect(self._sim.instants.now(), handle)
        return found

    def reset(self, handle: int) -> None:
        """Forget what a sensor detected, until it is handled again. Raises UnknownHandle, WrongKind."""
        self._sim.scene.get_kind(handle, ObjectKind.PROXIMITY_SENSOR)
        self._results.pop(handle, None)
        self._handled_by_hand.pop(handle, None)
        self._reset.add(handle)

    def check(self, handle: int, entity: int, **looks: str | float) -> Detection | None:
        """What a sensor would detect of one entity now; results of handling stay as they are.

        `looks`: fields of Optics (faces, least_cosine, least_distance) to use in place of the sensor's own. An object
        or collection is detected even if it is not detectable. Raises UnknownHandle, WrongKind, CommandError.
        """
        item = self._sim.scene.get_kind(handle, ObjectKind.PROXIMITY_SENSOR)
        members = self._sim.collections.entity(entity)
        instant = self._sim.instants.now()
        wanted = instant.detectable if entity == ALL else np.isin(instant.surroundings.owners, members)
        return self._look_at(instant, item, replace(self._look(item), **looks), wanted)  # type: ignore[arg-type]

    def is_explicit(self, handle: int) -> bool:
        """Whether passes leave a sensor alone, for a script to handle it. Raises UnknownHandle, WrongKind."""
        item = self._sim.scene.get_kind(handle, ObjectKind.PROXIMITY_SENSOR)
        return self._explicit.get(handle, bool(_note(item).get("explicit", False)))

    def set_explicit(self, handle: int, explicit: bool) -> None:
        """Until the stop, if the simulation runs. Raises UnknownHandle, WrongKind."""
        self.reset(handle)
        self._explicit = {**self._explicit, handle: explicit}

    def volume_type(self, handle: int) -> int:
        """`sim_proximitysensor_*_subtype`. Raises UnknownHandle, WrongKind."""
        return TYPES[self._look(self._sim.scene.get_kind(handle, ObjectKind.PROXIMITY_SENSOR)).kind]

    def entity(self, handle: int) -> int:
        """The object or collection a sensor detects, -1 for everything. Raises UnknownHandle, WrongKind."""
        item = self._sim.scene.get_kind(handle, ObjectKind.PROXIMITY_SENSOR)
        entity = self._entity(item)
        return -1 if entity == ALL else entity

    def set_entity(self, handle: int, entity: int) -> None:
        """What to detect from the next handling on; -1 for everything. Raises CommandError."""
        self._sim.scene.get_kind(handle, ObjectKind.PROXIMITY_SENSOR)
        if entity != -1:
            self._sim.collections.entity(entity)
        self._entities[handle] = ALL if entity == -1 else entity

    def _sense(self) -> None:
        """Results of the last pass end with it, also while handling is switched off."""
        if not self._sim.scene.of_kind(ObjectKind.PROXIMITY_SENSOR):
            return
        self._instant = self._sim.instants.now() if self.enabled else None
        self._results.clear()
        self._reset.clear()
        for handle in list(self._handled_by_hand):
            if handle not in self._sim.scene.objects or not self.is_explicit(handle):
                del self._handled_by_hand[handle]

    def _begin_run(self) -> None:
        self._forget()
        self._explicit_before_run = self._explicit

    def _end_run(self) -> None:
        self._forget()
        self._explicit = self._explicit_before_run

    def _forget(self) -> None:
        self._results.clear()
        self._handled_by_hand.clear()
        self._reset.clear()
        self._instant = None

    def _forget_all(self) -> None:
        self._forget()
        self.enabled = True
        self._explicit = self._explicit_before_run = {}
        self._optics.clear()
        self._entities.clear()

    def _detect(self, instant: Instant, handle: int) -> Detection | None:
        item = instant.scene.objects[handle]
        wanted = instant.detectable
        entity = self._entity(item)
        if entity != ALL:
            wanted = wanted & np.isin(instant.surroundings.owners, self._sim.collections.entity(entity))
        return self._look_at(instant, item, self._look(item), wanted)

    def _look_at(
        self, instant: Instant, item: SceneObject, looks: Optics, wanted: NDArray[np.bool_]
    ) -> Detection | None:
        """`wanted`: (ngeom,); what carries the sensor is left out."""
        carrier = instant.scene.owner_of_body(item.body, instant.model)
        if carrier != -1:
            wanted = wanted & (instant.surroundings.owners != carrier)
        rotation = instant.site_xmat[item.id].reshape(3, 3)
        return detect(instant, looks, instant.site_xpos[item.id], rotation, wanted)

    def _look(self, item: SceneObject) -> Optics:
        known = self._optics.get(item.handle)
        if known is None:
            known = self._optics[item.handle] = optics(_note(item), self._default_range(item))
        return known

    def _entity(self, item: SceneObject) -> int:
        if item.handle not in self._entities:
            self._entities[item.handle] = self._sim.collections.named(str(_note(item).get("entity", "all")))
        entity = self._entities[item.handle]
        gone = entity not in self._sim.scene.objects and entity not in self._sim.collections
        # What a sensor was restricted to may be removed; then it detects everything, as in V-REP.
        return ALL if gone else entity

    def _default_range(self, item: SceneObject) -> float:
        """The rangefinder's cutoff, else 10 m."""
        if not item.sensors:
            return DEFAULT_RANGE
        cutoff = float(self._sim.model.sensor_cutoff[item.sensors[0]])
        return cutoff if 0.0 < cutoff < math.inf else DEFAULT_RANGE


def _note(item: SceneObject) -> Annotation:
    return item.annotations.get("proximity", {})
