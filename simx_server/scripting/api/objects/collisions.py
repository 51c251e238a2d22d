"""Collisions, distances, contacts and collections: 1 or 0, metres, newtons."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import islice
from typing import ClassVar

from simx_client.protocol import constants as c
from simx_server.errors import CommandError
from simx_server.handlers import collisions
from simx_server.scripting.api.base import ApiPart
from simx_server.scripting.interpreter import Constant
from simx_server.sensors.contacts import contacts
from simx_server.sensors.distance.measuring import colliding_pair, nearest
from simx_server.sensors.distance.meters import Meter

_KINDS = {
    c.sim_handle_single: ("objects", "objects"),
    c.sim_handle_all: ("all", "all"),
    c.sim_handle_tree: ("tree", "below"),
    c.sim_handle_chain: ("chain", "above"),
}
"""What is meant by an object of a collection, with and without the object itself."""

_TAKEN_OUT, _WITHOUT_BASE = 1, 2
"""Bits of the options of an item of a collection."""

_EXTENDED = 0x400000
"""sim.handleflag_extended, which asked for the normal of a contact; it is always given."""


class CollisionFunctions(ApiPart):
    """Between objects, collections, and registered pairs."""

    CONSTANTS: ClassVar[Mapping[str, Constant]] = {
        "handleflag_extended": _EXTENDED,
    }

    def checkCollision(self, first: int, second: int) -> tuple[int, list[int]] | int:
        """1 when they meet now, and as in CoppeliaSim 4 one pair of objects that do; else 0.

        The second may be sim.handle_all, everything else.
        """
        meter = self._world.meters.collisions
        if not meter.enabled:
            return 0
        entities = meter.entities(self._self(first), self._self(second))
        pair = colliding_pair(self._world.instants.now(), *entities)
        return 0 if pair is None else (1, list(pair))

    def readCollision(self, handle: int) -> int:
        """-1 when it was not handled yet. Partly: which objects collide is not told."""
        found = self._world.meters.collisions.read(handle)
        return -1 if found is None else int(found)

    def handleCollision(self, handle: int) -> int:
        """Measure now; of sim.handle_all and sim.handle_all_except_explicit the number of collisions."""
        meter = self._world.meters.collisions
        return sum(meter.handle(each) for each in _meant(meter, handle))

    def resetCollision(self, handle: int) -> int:
        """Forget what was found, until the next handling."""
        for each in _meant(self._world.meters.collisions, handle):
            self._world.meters.collisions.reset(each)
        return 1

    def checkDistance(
        self, first: int, second: int, threshold: float = 0.0
    ) -> tuple[int, list[float], list[int]] | int:
        """1, {x1, y1, z1, x2, y2, z2, distance} in the world, and as in CoppeliaSim 4 the two objects; else 0.

        `threshold`: metres above which it is 0; none if it is not above 0.
        """
        meter = self._world.meters.distances
        if not meter.enabled:
            return 0
        entities = meter.entities(self._self(first), self._self(second))
        found = nearest(self._world.instants.now(), *entities)
        if found is None or 0.0 < threshold < found.distance:
            return 0
        return 1, [*found.first.tolist(), *found.second.tolist(), found.distance], list(found.objects)

    def readDistance(self, handle: int) -> tuple[int, float]:
        """1 and metres; 0 and 0 when it was not handled yet."""
        found = self._world.meters.distances.read(handle)
        return (0, 0.0) if found is None else (1, found)

    def handleDistance(self, handle: int) -> tuple[int, float]:
        """Measure now: 1 and metres, or 0 and 0; of sim.handle_all and its like the least."""
        meter = self._world.meters.distances
        found = [away for each in _meant(meter, handle) if (away := meter.handle(each)) is not None]
        return (1, min(found)) if found else (0, 0.0)

    def resetDistance(self, handle: int) -> int:
        """Forget what was found, until the next handling."""
        for each in _meant(self._world.meters.distances, handle):
            self._world.meters.distances.reset(each)
        return 1

    def getCollisionHandle(self, name: str) -> int:
        """Of a collision object that the scene registers."""
        return collisions.get_collision_handle(self._world, name)

    def getDistanceHandle(self, name: str) -> int:
        """Of a distance object that the scene registers."""
        return collisions.get_distance_handle(self._world, name)

    def getContactInfo(
        self, _dynamic_pass: int, handle: int, index: int
    ) -> tuple[list[int], list[float], list[float], list[float]] | None:
        """The two objects, the point, the force of the second on the first, the normal; nil after the last contact.

        `handle`: an object, which is then the first of the two, or sim.handle_all. `index` counts from 0.
        Partly: of the physics steps of a pass only the last one is told of.
        """
        wanted = None if handle == c.sim_handle_all else self._sim.scene.get(self._self(handle)).handle
        index -= _EXTENDED if index >= _EXTENDED else 0
        found = next(islice(contacts(self._sim, wanted), max(0, index), None), None)
        if found is None:
            return None
        return list(found.objects), list(found.point), list(found.force), list(found.normal)

    def getCollectionHandle(self, name: str) -> int:
        """Of the scene's collections, and those that scripts made."""
        return collisions.get_collection_handle(self._world, name)

    def getCollectionName(self, collection: int) -> str:
        """Raises for an unknown handle."""
        return self._world.collections.name(collection)

    def createCollection(self, name: int | str = 0, _options: int = 0) -> int:
        """A new, empty collection, gone after the stop; CoppeliaSim 4 gives it no name.

        Partly: the options (members count also if they are not collidable and so on) are ignored.
        """
        if isinstance(name, int):
            taken = (f"Collection{number}" for number in range(1, 10_000))
            name = next(each for each in taken if self._world.collections.find(each) is None)
        return self._world.collections.create(name)

    def addObjectToCollection(self, collection: int, handle: int, what: int, options: int = 0) -> int:
        """`what`: sim.handle_single, tree, chain or all; bit 0 of `options` takes out, bit 1 leaves out the object."""
        if what not in _KINDS:
            raise CommandError(
                "what is added is sim.handle_single, sim.handle_tree, sim.handle_chain or sim.handle_all"
            )
        kind = _KINDS[what][1 if options & _WITHOUT_BASE and what != c.sim_handle_single else 0]
        taken_out = bool(options & _TAKEN_OUT)
        self._world.collections.change(collection, kind, self._self(handle), taken_out=taken_out)
        return 1

    def addItemToCollection(self, collection: int, what: int, handle: int, options: int = 0) -> int:
        """CoppeliaSim 4's form of sim.addObjectToCollection."""
        return self.addObjectToCollection(collection, handle, what, options)

    def emptyCollection(self, collection: int) -> int:
        """Take everything out."""
        self._world.collections.empty(collection)
        return 1

    def removeCollection(self, collection: int) -> int:
        """It is back after the stop if the scene registers it."""
        self._world.collections.remove(collection)
        return 1

    destroyCollection = removeCollection

    def getCollectionObjects(self, collection: int) -> list[int]:
        """Handles of what is in it now."""
        return self._world.collections.members(collection)


def _meant(meter: Meter[bool] | Meter[float | None], handle: int) -> list[int]:
    if handle in (c.sim_handle_all, c.sim_handle_all_except_explicit):
        return meter.handles(explicit_too=handle == c.sim_handle_all)
    return [handle]
