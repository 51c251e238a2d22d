"""Collision and distance between objects: asked for directly, or registered in the scene and read by a handle.

`simx:collision:NAME` and `simx:distance:NAME` register what V-REP called collision and distance objects. They are
handled in each pass, unless explicitly by a script; as with proximity sensors, one that nobody reads costs nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import TYPE_CHECKING, Generic, TypeVar

from simx_client.protocol import constants as c

from ..errors import CommandError
from ..scene.collection import ALL
from ..scene.objects import ObjectKind
from .instant import Instant
from .measuring import distance, is_colliding

if TYPE_CHECKING:
    from ..simulation import Simulation

_R = TypeVar("_R")

FIRST_COLLISION = 2_010_000
FIRST_DISTANCE = 2_020_000


@dataclass(frozen=True)
class _Registered:
    name: str
    first: int
    second: int
    explicit: bool


class Meter(Generic[_R]):
    """One kind of measuring: what is registered for it, and what was found last."""

    def __init__(
        self,
        sim: Simulation,
        kind: str,
        first_handle: int,
        measure: Callable[[Instant, Collection[int], Collection[int]], _R],
        measurable: tuple[ObjectKind, ...],
        left_out: int,
    ) -> None:
        self.enabled = True
        """Boolean parameter 2 or 3."""
        self._sim = sim
        self._kind = kind
        self._first_handle = first_handle
        self._measure = measure
        self._measurable = measurable
        self._left_out = left_out
        self._registered: dict[int, _Registered] = {}
        self._results: dict[int, _R] = {}
        self._by_hand: dict[int, _R] = {}
        self._instant: Instant | None = None
        sim.on_sensing.append(self._sense)
        sim.on_start.append(self._forget)
        sim.on_stop.append(self._forget)
        sim.on_load.append(self._load)
        sim.on_close.append(self._close)

    def check(self, first: int, second: int) -> _R:
        """Measure two entities as they are now. The second may be all others (`sim_handle_all`).

        Raises UnknownHandle, CommandError for what cannot be measured.
        """
        return self._between(self._sim.instants.now(), first, second)

    def find(self, name: str) -> int:
        """The handle of a registered one. Raises CommandError that lists them."""
        wanted = name.removesuffix("#")
        for handle, registered in self._registered.items():
            if registered.name == wanted:
                return handle
        known = ", ".join(r.name for r in self._registered.values()) or "none"
        raise CommandError(
            f"no {self._kind} object named '{name}'; those of this scene: {known}; "
            f"a scene registers one with a text simx:{self._kind}:NAME"
        )

    def read(self, handle: int) -> _R | None:
        """The result of the last handling; None when there was none in this run. Raises CommandError."""
        registered = self._get(handle)
        if handle in self._by_hand:
            return self._by_hand[handle]
        if handle in self._results:
            return self._results[handle]
        if registered.explicit or self._instant is None:
            return None
        self._results[handle] = self._of(self._instant, registered)
        return self._results[handle]

    def handle(self, handle: int) -> _R:
        """Measure now, explicitly handled or not. Raises CommandError."""
        found = self._by_hand[handle] = self._of(self._sim.instants.now(), self._get(handle))
        return found

    def _get(self, handle: int) -> _Registered:
        registered = self._registered.get(handle)
        if registered is None:
            known = ", ".join(f"{h} '{r.name}'" for h, r in self._registered.items()) or "none"
            raise CommandError(f"no {self._kind} object with handle {handle}; those of this scene: {known}")
        return registered

    def _of(self, instant: Instant, registered: _Registered) -> _R:
        return self._between(instant, registered.first, registered.second)

    def _between(self, instant: Instant, first: int, second: int) -> _R:
        if first == ALL:
            raise CommandError(
                "the first entity is an object or a collection; only the second may be all (-2)"
            )
        return self._measure(instant, self._members(first), self._members(second))

    def _members(self, entity: int) -> list[int]:
        """The objects to measure: of several, without those that a model excludes; a single one is always measured."""
        scene = self._sim.scene
        handles = self._sim.collections.entity(entity)
        if entity in scene.objects:
            scene.get_kind(entity, *self._measurable)
            return handles
        return [
            handle
            for handle in handles
            if scene.objects[handle].kind in self._measurable
            and not scene.overridden(handle) & self._left_out
        ]

    def _sense(self) -> None:
        if self.enabled and self._registered:
            self._instant = self._sim.instants.now()
            self._results.clear()
            for handle in list(self._by_hand):
                if not self._registered[handle].explicit:
                    del self._by_hand[handle]

    def _forget(self) -> None:
        self._results.clear()
        self._by_hand.clear()
        self._instant = None

    def _close(self) -> None:
        self._forget()
        self._registered.clear()

    def _load(self) -> None:
        self._close()
        named = self._sim.collections.named
        for name, note in self._sim.scene.annotations.registered.get(self._kind, {}).items():
            self._registered[self._first_handle + len(self._registered)] = _Registered(
                name,
                named(str(note["entity1"])),
                named(str(note.get("entity2", "all"))),
                bool(note.get("explicit", False)),
            )


class Meters:
    """Both kinds; attached after the collections, whose names they need."""

    def __init__(self, sim: Simulation) -> None:
        self.collisions: Meter[bool] = Meter(
            sim,
            "collision",
            FIRST_COLLISION,
            is_colliding,
            (ObjectKind.SHAPE,),
            c.sim_modelproperty_not_collidable,
        )
        self.distances: Meter[float | None] = Meter(
            sim,
            "distance",
            FIRST_DISTANCE,
            distance,
            (ObjectKind.SHAPE, ObjectKind.DUMMY),
            c.sim_modelproperty_not_measurable,
        )
