"""Collision and distance between objects, on request or registered in the scene and read by a handle.

`simx:collision:NAME` and `simx:distance:NAME` register V-REP's collision and distance objects. They are handled in
each simulation step, unless a script handles them explicitly; as with proximity sensors, an unread one costs
nothing.

Objects that are not collidable or measurable (`simx:shape`, `simx:dummy`, or by a model's property) are left out of
collections and of "all others". If a caller names a single object, it is measured in any case; a registered one is not.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from simx_client.protocol import constants as c
from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import CommandError
from simx_server.scene.abilities import ability
from simx_server.scene.collection import ALL, Collections
from simx_server.scene.formats.annotations import Annotation
from simx_server.scene.objects import ObjectKind
from simx_server.scene.registered import Registry
from simx_server.sensors.instant import Instant, Instants
from simx_server.simulation.part import Part

from .measuring import distance
from .meeting import Pair, colliding_pair

if TYPE_CHECKING:
    from simx_server.scene.saved import Saved
    from simx_server.simulation.simulation import Simulation

_R = TypeVar("_R")

_WITH_FORM = (ObjectKind.SHAPE, ObjectKind.OCTREE, ObjectKind.POINT_CLOUD)

FIRST_COLLISION = 2_010_000
FIRST_DISTANCE = 2_020_000


@dataclass(frozen=True)
class _Registered:
    first: int
    second: int
    explicit: bool


class Meter(Generic[_R]):
    """One kind of measurement: the registered objects and their last results."""

    def __init__(
        self,
        sim: Simulation,
        collections: Collections,
        instants: Instants,
        kind: str,
        first_handle: int,
        measure: Callable[[Instant, Collection[int], Collection[int]], _R],
        nothing: _R,
        measurable: tuple[ObjectKind, ...],
        left_out: int,
        own_key: str,
    ) -> None:
        """Make one kind of measurement.

        Args:
            sim: the simulation.
            collections: the scene's collections.
            instants: makes the instants to measure.
            kind: the kind of registered object.
            first_handle: handle of the first registered object.
            measure: measures two sets of objects.
            nothing: the result while handling is switched off.
            measurable: kinds of objects that can be measured.
            left_out: the bit of a model's property that excludes it from measuring.
            own_key: the key of a shape's annotation that does the same.
        """
        self.enabled = True
        """Boolean parameter 2 or 3; it belongs to the scene."""
        self._sim = sim
        self._collections = collections
        self._instants = instants
        self._kind = kind
        self._measure = measure
        self._nothing = nothing
        self._measurable = measurable
        self._left_out = left_out
        self._own_key = own_key
        self._registry = Registry(sim, kind, first_handle, self._register, self._is_alive)
        self._results: dict[int, _R] = {}
        self._by_hand: dict[int, _R] = {}
        self._instant: Instant | None = None
        self._handled: frozenset[int] = frozenset()
        """The objects that were registered at that instant."""

    def check(self, first: int, second: int) -> _R:
        """Measure two entities as they are now. The second may be all others (`sim_handle_all`).

        Raises:
            UnknownHandle: an entity does not exist.
            CommandError: an entity cannot be measured.
        """
        return self._between(self._instants.now(), first, second, whatever_they_are=True)

    def find(self, name: str) -> int:
        """Return the handle of a registered object.

        Raises:
            CommandError: the name is unknown; the text lists the registered ones.
        """
        return self._registry.handle_of(name, f"{self._kind} object")

    def names(self) -> list[str]:
        return [name for name, _ in self._registry.all().values()]

    def saving(self, saved: Saved) -> None:
        """Annotate the registered objects whose entities are saved."""
        notes: dict[str, Annotation] = {}
        for name, each in self._registry.all().values():
            first, second = (
                self._collections.saved_name(saved, entity) for entity in (each.first, each.second)
            )
            if first is not None and second is not None:
                notes[name] = {"entity1": first, "entity2": second, "explicit": each.explicit}
        saved.registered[self._kind] = notes
        saved.settings[f"{self._kind}s"] = self.enabled

    def read(self, handle: int) -> _R | None:
        """Return the result of the last handling; None when there was none in this run.

        Raises:
            CommandError: the handle is unknown.
        """
        registered = self._get(handle)
        if handle in self._by_hand:
            return self._by_hand[handle]
        if handle in self._results:
            return self._results[handle]
        if registered.explicit or self._instant is None or handle not in self._handled:
            return None
        self._results[handle] = self._of(self._instant, registered)
        return self._results[handle]

    def handle(self, handle: int) -> _R:
        """Measure now, explicitly handled or not; when switched off, forget the last result.

        Raises:
            CommandError: the handle is unknown, or an entity cannot be measured.
        """
        registered = self._get(handle)
        self._results.pop(handle, None)
        self._by_hand.pop(handle, None)
        if not self.enabled:
            return self._nothing
        found = self._by_hand[handle] = self._of(self._instants.now(), registered)
        return found

    def reset(self, handle: int) -> None:
        """Forget the result until the next handling.

        Raises:
            CommandError: the handle is unknown.
        """
        self._get(handle)
        self._results.pop(handle, None)
        self._by_hand.pop(handle, None)
        self._handled -= {handle}

    def handles(self, *, explicit_too: bool) -> list[int]:
        """Return the handles of all registered objects, or of those that simulation steps handle."""
        return [h for h, (_, each) in self._registry.all().items() if explicit_too or not each.explicit]

    def _get(self, handle: int) -> _Registered:
        registered = self._registry.get(handle)
        if registered is None:
            known = ", ".join(f"{h} '{name}'" for h, (name, _) in self._registry.all().items()) or "none"
            raise CommandError(f"no {self._kind} object with handle {handle}; those of this scene: {known}")
        return registered

    def _of(self, instant: Instant, registered: _Registered) -> _R:
        return self._between(instant, registered.first, registered.second, whatever_they_are=False)

    def _between(self, instant: Instant, first: int, second: int, *, whatever_they_are: bool) -> _R:
        return self._measure(instant, *self.entities(first, second, whatever_they_are=whatever_they_are))

    def entities(
        self, first: int, second: int, *, whatever_they_are: bool = True
    ) -> tuple[list[int], list[int]]:
        """Return the handles of the objects of two entities. `whatever_they_are`: see `_members`.

        Raises:
            UnknownHandle: an entity does not exist.
            CommandError: an entity cannot be measured.
        """
        if first == ALL:
            raise CommandError(
                "the first entity is an object or a collection; only the second may be all (-2)"
            )
        mine = self._members(first, whatever_they_are)
        theirs = self._members(second, whatever_they_are)
        if second == ALL:  # all others: the first entity's objects are left out
            own = frozenset(mine)
            theirs = [handle for handle in theirs if handle not in own]
        return mine, theirs

    def _members(self, entity: int, whatever_they_are: bool) -> list[int]:
        """Return the objects to measure.

        `whatever_they_are`: include a single object that is excluded from measuring.
        """
        scene = self._sim.scene
        handles = self._collections.entity(entity)
        if entity in scene.objects:
            scene.get_kind(entity, *self._measurable)
            if whatever_they_are:
                return handles
        if self._collections.overrides(entity):
            return [handle for handle in handles if scene.objects[handle].kind in self._measurable]
        return [
            handle
            for handle in handles
            if scene.objects[handle].kind in self._measurable
            and ability(scene.objects[handle], self._own_key)
            and not scene.overridden(handle) & self._left_out
        ]

    @property
    def has_work(self) -> bool:
        """Return whether objects of this kind are registered."""
        return bool(self._registry)

    def sense(self) -> None:
        """Note the instant of a simulation step. Earlier results end with it, also while handling is switched off."""
        registered = self._registry.all()
        self._results.clear()
        for handle in list(self._by_hand):
            if handle not in registered or not registered[handle][1].explicit:
                del self._by_hand[handle]
        self._handled = frozenset(registered)
        self._instant = self._instants.now() if self.enabled and registered else None

    def forget(self) -> None:
        self._results.clear()
        self._by_hand.clear()
        self._instant = None

    def change_scene(self) -> None:
        self._registry.forget()
        self.forget()
        self.enabled = bool(self._sim.scene.annotations.scene.get(f"{self._kind}s", True))

    def _register(self, _name: str, note: Annotation) -> _Registered:
        named = self._collections.named
        first, second = named(str(note["entity1"])), named(str(note.get("entity2", "all")))
        return _Registered(first, second, bool(note.get("explicit", False)))

    def _is_alive(self, registered: _Registered) -> bool:
        """Return whether its entities still exist; as in V-REP, it is removed with them."""
        scene, collections = self._sim.scene, self._collections
        return all(
            entity == ALL or entity in scene.objects or entity in collections
            for entity in (registered.first, registered.second)
        )


class Meters(Part):
    """Both kinds; attached after the collections, whose names they need."""

    def __init__(self, sim: Simulation, collections: Collections, instants: Instants) -> None:
        self.collisions: Meter[Pair] = Meter(
            sim,
            collections,
            instants,
            "collision",
            FIRST_COLLISION,
            colliding_pair,
            (),
            _WITH_FORM,
            c.sim_modelproperty_not_collidable,
            "collidable",
        )
        self.distances: Meter[float | None] = Meter(
            sim,
            collections,
            instants,
            "distance",
            FIRST_DISTANCE,
            distance,
            None,
            (*_WITH_FORM, ObjectKind.DUMMY),
            c.sim_modelproperty_not_measurable,
            "measurable",
        )

    def run_started(self) -> None:
        self._forget()

    def run_stopped(self) -> None:
        self._forget()

    def scene_changed(self) -> None:
        self.collisions.change_scene()
        self.distances.change_scene()

    def saving(self, saved: Saved) -> None:
        self.collisions.saving(saved)
        self.distances.saving(saved)

    def remember(self) -> object:
        return self.collisions.enabled, self.distances.enabled

    def recall(self, memory: Any) -> None:
        self.collisions.enabled, self.distances.enabled = memory
        self.sense()

    def registered_names(self) -> Mapping[str, list[str]]:
        return {"collision": self.collisions.names(), "distance": self.distances.names()}

    @property
    def has_work(self) -> bool:
        """Return whether collision or distance objects are registered."""
        return self.collisions.has_work or self.distances.has_work

    def sense(self) -> None:
        """Note the instant that results of this simulation step are computed from."""
        self.collisions.sense()
        self.distances.sense()

    def _forget(self) -> None:
        self.collisions.forget()
        self.distances.forget()
