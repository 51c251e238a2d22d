"""Proximity sensors: sites with a rangefinder or a `simx:proximity` annotation.

They look along the site's +z (see `volume.py`) at what a camera sees too (the geom groups of `VISIBLE_GROUPS`), but not
at the shape that carries them. V-REP computes all sensors in each pass; here a sensor is computed when it is read,
from where everything was in the sensing phase of the last pass, together with those that look alike and were read with
it before: who reads a ring of sensors once will do so again.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from simx_server.errors import CommandError, NotHandledYet
from simx_server.scene.collection import ALL
from simx_server.scene.formats.annotations import Annotation
from simx_server.scene.objects import ObjectKind, SceneObject
from simx_server.sensors.instant import Instant
from simx_server.world.part import Part

from .detection import Detection, detect_all
from .optics import Optics, optics
from .volume import TYPES

if TYPE_CHECKING:
    from simx_server.scene.collection import Collections
    from simx_server.sensors.instant import Instants
    from simx_server.world.simulation import Simulation

__all__ = ["DEFAULT_RANGE", "Detection", "ProximitySensors"]

DEFAULT_RANGE = 10.0
"""Metres, for a rangefinder that says no range (annotation or the sensor's cutoff)."""


class ProximitySensors(Part):
    """What all proximity sensors of the scene detected last."""

    def __init__(self, sim: Simulation, collections: Collections, instants: Instants) -> None:
        self._sim = sim
        self._collections = collections
        self._instants = instants
        self.enabled = True
        """Boolean parameter 9: whether the sensing phase handles sensors; it belongs to the scene."""
        self._optics: dict[int, Optics] = {}
        self._kinds: dict[tuple[frozenset[tuple[str, str | float]], float], Optics] = {}
        """By annotation and default range: sensors that look alike share their optics."""
        self._entities: dict[int, int] = {}
        self._results: dict[int, Detection | None] = {}
        self._asked: dict[int, None] = {}
        self._asked_before = self._asked
        """Sensors that were read since the last pass; and in the last one before in which any was."""
        self._handled_by_hand: dict[int, Detection | None] = {}
        self._reset: set[int] = set()
        """Sensors whose result was forgotten on demand since the last pass."""
        self._explicit: dict[int, bool] = {}
        """Where a script changed whether a sensor is handled explicitly."""
        self._explicit_before_run = self._explicit
        self._instant: Instant | None = None
        """That of the last pass in which sensors were handled."""

    def run_started(self) -> None:
        self._begin_run()

    def run_stopped(self) -> None:
        self._end_run()

    def scene_changed(self) -> None:
        self._forget_all()

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
        self._asked[handle] = None
        if handle not in self._results:
            instant = self._instant
            if instant is None or handle not in instant.scene.objects or handle in self._reset:
                raise NotHandledYet(
                    f"proximity sensor '{item.name}' has not been handled yet; it is in each pass of a running "
                    "simulation",
                    is_coming=self.enabled and self._sim.is_before_first_pass,
                )
            together = self._alike(instant, handle)
            self._results.update(zip(together, self._detect(instant, together), strict=True))
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
        (found,) = self._detect(self._instants.now(), [handle])
        self._handled_by_hand[handle] = found
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
        members = self._collections.entity(entity)
        instant = self._instants.now()
        wanted = instant.detectable if entity == ALL else np.isin(instant.surroundings.owners, members)
        looks_now = replace(self._look(item), **looks)  # type: ignore[arg-type]
        return self._look_at(instant, [item], looks_now, wanted[np.newaxis].copy())[0]

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
            self._collections.entity(entity)
        self._entities[handle] = ALL if entity == -1 else entity

    def sense(self) -> None:
        """Results of the last pass end with it, also while handling is switched off."""
        if not self._sim.scene.of_kind(ObjectKind.PROXIMITY_SENSOR):
            return
        self._instant = self._instants.now() if self.enabled else None
        self._results.clear()
        if self._asked:
            self._asked_before, self._asked = self._asked, {}
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
        self._asked_before = self._asked = {}
        self._instant = None

    def _forget_all(self) -> None:
        self._forget()
        self.enabled = True
        self._explicit = self._explicit_before_run = {}
        self._optics.clear()
        self._kinds.clear()
        self._entities.clear()

    def _alike(self, instant: Instant, handle: int) -> list[int]:
        """The sensor, and those to compute with it: they were read with it before, and have no result yet."""
        objects, known = instant.scene.objects, self._results.keys() | self._reset
        looks = self._look(objects[handle])
        others = [one for one in self._asked_before if one != handle and one in objects and one not in known]
        return [handle, *(one for one in others if self._look(objects[one]) is looks)]

    def _detect(self, instant: Instant, handles: list[int]) -> list[Detection | None]:
        """Of sensors that look alike."""
        items = [instant.scene.objects[handle] for handle in handles]
        wanted = np.repeat(instant.detectable[np.newaxis], len(items), axis=0)
        for row, item in enumerate(items):
            entity = self._entity(item)
            if entity != ALL:
                wanted[row] &= np.isin(instant.surroundings.owners, self._collections.entity(entity))
        return self._look_at(instant, items, self._look(items[0]), wanted)

    def _look_at(
        self, instant: Instant, items: list[SceneObject], looks: Optics, wanted: NDArray[np.bool_]
    ) -> list[Detection | None]:
        """`wanted`: (s, ngeom); what carries a sensor is left out."""
        carriers = [instant.scene.owner_of_body(item.body, instant.model) for item in items]
        for row, carrier in enumerate(carriers):
            if carrier != -1:
                wanted[row] &= instant.surroundings.owners != carrier
        sites = [item.id for item in items]
        rotations = instant.site_xmat[sites].reshape(-1, 3, 3)
        return detect_all(instant, looks, instant.site_xpos[sites], rotations, wanted)

    def _look(self, item: SceneObject) -> Optics:
        known = self._optics.get(item.handle)
        if known is None:
            note, default = _note(item), self._default_range(item)
            kind = frozenset(note.items()), default
            known = self._kinds.get(kind) or self._kinds.setdefault(kind, optics(note, default))
            self._optics[item.handle] = known
        return known

    def _entity(self, item: SceneObject) -> int:
        if item.handle not in self._entities:
            self._entities[item.handle] = self._collections.named(str(_note(item).get("entity", "all")))
        entity = self._entities[item.handle]
        gone = entity not in self._sim.scene.objects and entity not in self._collections
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
