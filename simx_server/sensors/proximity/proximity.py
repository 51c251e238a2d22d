"""Proximity sensors: sites with a rangefinder or a `simx:proximity` annotation.

They look along the site's +z (see `volume.py`) at everything that a camera sees too (the geom groups of
`VISIBLE_GROUPS`), except the shape that carries them, and at dummies that are declared detectable. V-REP computes all
sensors in each simulation step; here a sensor is computed when it is read, from the instant of the last sensing phase.
Sensors with equal optics that were read with it before are computed together with it, because a program that reads a
ring of sensors once will do so again.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from simx_server.errors import NotHandledYet
from simx_server.scene.collection import ALL
from simx_server.scene.editing import renaming
from simx_server.scene.objects import ObjectKind, SceneObject
from simx_server.sensors.instant import Instant
from simx_server.simulation.part import Part

from .detection import Detection
from .given import detect_given
from .looking import Targets, along, look, note_of, turn_of
from .optics import Optics, optics
from .volume import TYPES

if TYPE_CHECKING:
    from simx_server.scene.collection import Collections
    from simx_server.scene.saved import Saved
    from simx_server.sensors.instant import Instants
    from simx_server.simulation.simulation import Simulation

__all__ = ["DEFAULT_RANGE", "Detection", "ProximitySensors"]

DEFAULT_RANGE = 10.0
"""Range in metres of a rangefinder without a range (annotation or the sensor's cutoff)."""


_LENGTHS = (
    *("offset", "range", "radius", "radius_far", "size_x", "size_y", "size_x_far", "size_y_far"),
    *("height", "min_distance"),
)
"""Lengths in the annotation of a sensor."""


class ProximitySensors(Part):
    """The last results of all proximity sensors of the scene."""

    def __init__(self, sim: Simulation, collections: Collections, instants: Instants) -> None:
        self._sim = sim
        self._collections = collections
        self._instants = instants
        self.enabled = True
        """Boolean parameter 9: whether the sensing phase handles sensors; it belongs to the scene."""
        self._optics: dict[int, Optics] = {}
        self._kinds: dict[tuple[frozenset[tuple[str, str | float]], float], Optics] = {}
        """Optics by annotation and default range: equal sensors share their optics."""
        self._entities: dict[int, int] = {}
        self._results: dict[int, Detection | None] = {}
        self._asked: dict[int, None] = {}
        self._asked_before = self._asked
        """Sensors that were read since the last simulation step, and in the last one before in which any was."""
        self._handled_by_hand: dict[int, Detection | None] = {}
        self._throws: Counter[int] = Counter()
        """Number of readings of sensors with random rays in this run."""
        self._reset: set[int] = set()
        """Sensors whose result was cleared on request since the last simulation step."""
        self._explicit: dict[int, bool] = {}
        """Sensors for which a script changed whether they are handled explicitly."""
        self._explicit_before_run = self._explicit
        self._instant: Instant | None = None
        """The instant of the last simulation step in which sensors were handled."""

    def run_started(self) -> None:
        self._begin_run()

    def run_stopped(self) -> None:
        self._end_run()

    def scene_changed(self) -> None:
        self._forget_all()

    def remember(self) -> object:
        return self.enabled, self._explicit, dict(self._entities), Counter(self._throws)

    def recall(self, memory: Any) -> None:
        self.enabled, self._explicit, entities, throws = memory
        self._entities, self._throws = dict(entities), Counter(throws)
        self._optics.clear()  # annotations were restored
        if self.has_work:
            self.sense()

    def saving(self, saved: Saved) -> None:
        for handle in self._sim.scene.of_kind(ObjectKind.PROXIMITY_SENSOR):
            if handle in saved.names:
                entity = self._collections.saved_name(saved, self._entity(self._sim.scene.objects[handle]))
                saved.put(handle, "proximity", entity=None if entity == "all" else entity)
                if handle in self._explicit:
                    saved.put(handle, "proximity", explicit=self._explicit[handle])
        saved.settings["proximity"] = self.enabled

    def read(self, handle: int) -> Detection | None:
        """Return the result of the last handling; None when nothing is in the volume.

        Raises:
            UnknownHandle, WrongKind: the handle is not a proximity sensor's.
            CommandError: not handled since the simulation started.
        """
        item = self._sim.scene.get_kind(handle, ObjectKind.PROXIMITY_SENSOR)
        if handle in self._handled_by_hand:
            return self._handled_by_hand[handle]
        if self.is_explicit(handle):
            raise NotHandledYet(
                f"proximity sensor '{item.name}' is handled explicitly, and no script has handled it in this run",
                is_coming=self._sim.is_before_first_step,
            )
        self._asked[handle] = None
        if handle not in self._results:
            instant = self._instant
            if instant is None or handle not in instant.scene.objects or handle in self._reset:
                raise NotHandledYet(
                    f"proximity sensor '{item.name}' has not been handled yet; it is in each pass of a running "
                    "simulation",
                    is_coming=self.enabled and self._sim.is_before_first_step,
                )
            together = self._alike(instant, handle)
            self._results.update(zip(together, self._detect(instant, together), strict=True))
        return self._results[handle]

    def peek(self, handle: int) -> tuple[bool, Detection | None]:
        """Return whether the present result is known, and the result; computes it unless that changes later ones.

        Raises:
            UnknownHandle, WrongKind: the handle is not a proximity sensor's.
        """
        item = self._sim.scene.get_kind(handle, ObjectKind.PROXIMITY_SENSOR)
        for results in (self._handled_by_hand, self._results):
            if handle in results:
                return True, results[handle]
        if self._instant is None or self.is_explicit(handle) or self._look(item).throw is not None:
            return False, None
        if handle not in self._instant.scene.objects or handle in self._reset:
            return False, None
        (found,) = self._detect(self._instant, [handle])
        self._results[handle] = found
        return True, found

    def handle(self, handle: int) -> Detection | None:
        """Compute a sensor now, explicitly handled or not, as `sim.handleProximitySensor` does.

        While handling is switched off, clear the last result instead.
        """
        self._sim.scene.get_kind(handle, ObjectKind.PROXIMITY_SENSOR)
        self._handled_by_hand.pop(handle, None)
        self._reset.discard(handle)
        if not self.enabled:
            self._results.pop(handle, None)
            return None
        instant = self._instants.present()
        item = instant.scene.objects[handle]
        looks = self._look(item)
        found = self._handled_by_hand[handle] = self._detect_alone(instant, item, looks, self._entity(item))
        return found

    def reset(self, handle: int) -> None:
        """Clear a sensor's result until it is handled again.

        Raises:
            UnknownHandle, WrongKind: the handle is not a proximity sensor's.
        """
        self._sim.scene.get_kind(handle, ObjectKind.PROXIMITY_SENSOR)
        self._results.pop(handle, None)
        self._handled_by_hand.pop(handle, None)
        self._reset.add(handle)

    def check(
        self, handle: int, entity: int, *, farthest: float = math.inf, **looks: str | float
    ) -> Detection | None:
        """Return what a sensor would detect of one entity now; results of handling do not change.

        Args:
            handle: the sensor.
            entity: an object, which is detected even if it is not detectable, or a collection.
            farthest: distance from the sensor's origin in metres beyond which nothing is detected.
            looks: fields of Optics (faces, least_cosine) that replace the sensor's own.

        Raises:
            UnknownHandle, WrongKind, CommandError: a handle or a value is wrong.
        """
        item = self._sim.scene.get_kind(handle, ObjectKind.PROXIMITY_SENSOR)
        instant = self._instants.present()
        own = self._look(item)
        other = {name: value for name, value in looks.items() if value != getattr(own, name)}
        looks_now = replace(own, **other) if other else own  # type: ignore[arg-type]
        return _within(farthest, self._detect_alone(instant, item, looks_now, entity, whatever_it_is=True))

    def check_given(
        self,
        handle: int,
        items: NDArray[np.float64],
        *,
        farthest: float = math.inf,
        **looks: str | float,
    ) -> Detection | None:
        """Return what a sensor would detect of given points, segments or triangles; its handle is `NO_OBJECT`.

        Args:
            handle: the sensor. One with random rays searches its whole volume.
            items: (n, k, 3) n items with k = 1, 2 or 3 corners each, in the world, metres.
            farthest: as in `check`.
            looks: as in `check`.

        Raises:
            UnknownHandle, WrongKind: the handle is not a proximity sensor's.
        """
        item = self._sim.scene.get_kind(handle, ObjectKind.PROXIMITY_SENSOR)
        instant = self._instants.present()
        looks_now = replace(self._look(item), throw=None, **looks)  # type: ignore[arg-type]
        places = (items - instant.site_xpos[item.id]) @ turn_of(instant, item)
        return _within(farthest, detect_given(looks_now, places))

    def is_explicit(self, handle: int) -> bool:
        """Return whether simulation steps skip a sensor, for a script to handle it.

        Raises:
            UnknownHandle, WrongKind: the handle is not a proximity sensor's.
        """
        item = self._sim.scene.get_kind(handle, ObjectKind.PROXIMITY_SENSOR)
        return self._explicit.get(handle, bool(note_of(item).get("explicit", False)))

    def set_explicit(self, handle: int, explicit: bool) -> None:
        """Set whether a sensor is handled explicitly; in a running simulation, until the stop.

        Raises:
            UnknownHandle, WrongKind: the handle is not a proximity sensor's.
        """
        self.reset(handle)
        self._explicit = {**self._explicit, handle: explicit}

    def volume_type(self, handle: int) -> int:
        """Return `sim_proximitysensor_*_subtype`.

        Raises:
            UnknownHandle, WrongKind: the handle is not a proximity sensor's.
        """
        return TYPES[self._look(self._sim.scene.get_kind(handle, ObjectKind.PROXIMITY_SENSOR)).kind]

    def reach(self, handle: int) -> float:
        """Return the length of the detection volume in metres.

        Raises:
            UnknownHandle, WrongKind: the handle is not a proximity sensor's.
        """
        return self._look(self._sim.scene.get_kind(handle, ObjectKind.PROXIMITY_SENSOR)).reach

    def box(self, handle: int) -> NDArray[np.float64]:
        """Return (2, 3) least and greatest x, y, z in metres of the detection volume, in the sensor's frame.

        Raises:
            UnknownHandle, WrongKind: the handle is not a proximity sensor's.
        """
        return self._look(self._sim.scene.get_kind(handle, ObjectKind.PROXIMITY_SENSOR)).volume.box

    def entity(self, handle: int) -> int:
        """Return the object or collection that a sensor detects, -1 for everything.

        Raises:
            UnknownHandle, WrongKind: the handle is not a proximity sensor's.
        """
        item = self._sim.scene.get_kind(handle, ObjectKind.PROXIMITY_SENSOR)
        entity = self._entity(item)
        return -1 if entity == ALL else entity

    def set_entity(self, handle: int, entity: int) -> None:
        """Set what to detect from the next handling on; -1 for everything.

        Raises:
            CommandError: the entity does not exist or cannot be detected.
        """
        self._sim.scene.get_kind(handle, ObjectKind.PROXIMITY_SENSOR)
        if entity != -1:
            self._collections.entity(entity)
        self._entities[handle] = ALL if entity == -1 else entity

    @property
    def has_work(self) -> bool:
        """Return whether the scene has proximity sensors."""
        return bool(self._sim.scene.of_kind(ObjectKind.PROXIMITY_SENSOR))

    def sense(self) -> None:
        """Note the instant of a simulation step. Earlier results end with it, also while handling is switched off."""
        self._instant = self._instants.now() if self.enabled else None
        if self._asked:
            self._asked_before, self._asked = self._asked, {}
        if self._results:
            self._results.clear()
        if self._reset:
            self._reset.clear()
        if self._handled_by_hand:
            objects, by_hand = self._sim.scene.objects, self._handled_by_hand
            for handle in [one for one in by_hand if one not in objects or not self.is_explicit(one)]:
                del by_hand[handle]

    def _begin_run(self) -> None:
        self._forget()
        self._explicit_before_run = self._explicit

    def _end_run(self) -> None:
        self._forget()
        self._optics.clear()  # the stop restores annotations
        self._explicit = self._explicit_before_run

    def _forget(self) -> None:
        self._results.clear()
        self._handled_by_hand.clear()
        self._throws.clear()
        self._reset.clear()
        self._asked_before = self._asked = {}
        self._instant = None

    def _forget_all(self) -> None:
        self._forget()
        self.enabled = bool(self._sim.scene.annotations.scene.get("proximity", True))
        self._explicit = self._explicit_before_run = {}
        self._optics.clear()
        self._kinds.clear()
        self._entities.clear()

    def _alike(self, instant: Instant, handle: int) -> list[int]:
        """Return the sensor and those to compute with it: read with it before, and without a result yet."""
        objects, known = instant.scene.objects, self._results.keys() | self._reset
        looks = self._look(objects[handle])
        others = [one for one in self._asked_before if one != handle and one in objects and one not in known]
        return [handle, *(one for one in others if self._look(objects[one]) is looks)]

    def _detect(self, instant: Instant, handles: list[int]) -> list[Detection | None]:
        """Return the results of sensors with equal optics."""
        items = [instant.scene.objects[handle] for handle in handles]
        looks = self._look(items[0])
        targets = [self._targets(instant, self._entity(item), looks) for item in items]
        return look(instant, items, looks, targets, self._dice)

    def _detect_alone(
        self,
        instant: Instant,
        item: SceneObject,
        looks: Optics,
        entity: int,
        *,
        whatever_it_is: bool = False,
    ) -> Detection | None:
        """Return the result of one sensor; see `_targets`."""
        if looks.kind == "ray" and entity == ALL:  # as scripts ask it from a turning scanner, again and again
            return along(instant, item, looks, instant.detectable(looks.detects))
        targets = self._targets(instant, entity, looks, whatever_it_is=whatever_it_is)
        return look(instant, [item], looks, [targets], self._dice)[0]

    def _targets(
        self, instant: Instant, entity: int, looks: Optics, *, whatever_it_is: bool = False
    ) -> Targets:
        """Return what a sensor is to detect of an entity.

        `whatever_it_is`: include a single object that is not detectable. Raises UnknownHandle, CommandError.
        """
        if entity == ALL:
            return Targets(instant.detectable(looks.detects), instant.detectable_points(looks.detects))
        members, around = self._collections.entity(entity), instant.surroundings
        is_object = entity in self._sim.scene.objects
        if (is_object and whatever_it_is) or self._collections.overrides(entity):
            return Targets(around.owned_by(members), around.points_of(members))
        geoms = around.owned_by(members) & instant.detectable(looks.detects)
        return Targets(geoms, instant.detectable_points(looks.detects).among(members, instant.scene))

    def _dice(self, handle: int) -> np.random.Generator:
        """Return the randomness of a sensor's next reading: the same in each run with the same readings."""
        self._throws[handle] += 1
        return np.random.default_rng((self._sim.step_count, handle, self._throws[handle]))

    def object_scaled(self, handle: int, factor: float) -> None:
        if self._sim.scene.get(handle).kind == ObjectKind.PROXIMITY_SENSOR:
            renaming.scale_annotation(self._sim, handle, "proximity", dict.fromkeys(_LENGTHS, 1), factor)
            self.look_again(handle)

    def look_again(self, handle: int) -> None:
        """Read the annotation of a sensor again before the next detection: it has changed."""
        self._optics.pop(handle, None)

    def _look(self, item: SceneObject) -> Optics:
        known = self._optics.get(item.handle)
        if known is None:
            note, default = note_of(item), self._default_range(item)
            kind = frozenset(note.items()), default
            known = self._kinds.get(kind) or self._kinds.setdefault(kind, optics(note, default))
            self._optics[item.handle] = known
        return known

    def _entity(self, item: SceneObject) -> int:
        if item.handle not in self._entities:
            self._entities[item.handle] = self._collections.named(str(note_of(item).get("entity", "all")))
        entity = self._entities[item.handle]
        if entity == ALL:
            return ALL
        gone = entity not in self._sim.scene.objects and entity not in self._collections
        # The entity of a restricted sensor may be removed; then it detects everything, as in V-REP.
        return ALL if gone else entity

    def _default_range(self, item: SceneObject) -> float:
        """Return the rangefinder's cutoff, else 10 m."""
        if not item.sensors:
            return DEFAULT_RANGE
        cutoff = float(self._sim.model.sensor_cutoff[item.sensors[0]])
        return cutoff if 0.0 < cutoff < math.inf else DEFAULT_RANGE


def _within(farthest: float, found: Detection | None) -> Detection | None:
    return found if found is not None and math.hypot(*found.point) <= farthest else None
