"""Collisions, distances, contacts and collections: 1 or 0, metres, newtons."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, Final

from simx_client.protocol import constants as c
from simx_server.errors import CommandError, Unsupported, WrongKind
from simx_server.handlers import collisions
from simx_server.scripting.interpreter import Constant
from simx_server.sensors.distance.intersections import intersections
from simx_server.sensors.distance.measuring import nearest
from simx_server.sensors.distance.meeting import Pair
from simx_server.sensors.distance.meters import Meter
from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.effects import reads

_KINDS = {
    c.sim_handle_single: ("objects", "objects"),
    c.sim_handle_all: ("all", "all"),
    c.sim_handle_tree: ("tree", "below"),
    c.sim_handle_chain: ("chain", "above"),
}
"""Items that an object adds to a collection, with and without the object itself."""

_TAKEN_OUT, _WITHOUT_BASE = 1, 2
"""Bits of the options of an item of a collection."""

_NO_PAIR: Final[tuple[int, int]] = (-1, -1)
"""Stands for the handles of two objects where there are none."""

_EXTENDED = 0x400000
"""sim.handleflag_extended, which requested the normal of a contact; it is always returned."""


class CollisionFunctions(ApiPart, effect="changes"):
    """Functions for measurements between objects, collections, and registered pairs."""

    CONSTANTS: ClassVar[Mapping[str, Constant]] = {
        "handleflag_extended": _EXTENDED,
    }

    @reads
    def checkCollision(self, first: int, second: int = c.sim_handle_all) -> tuple[int, list[int]]:
        """Return 1 and one pair of colliding objects if the two collide now; else 0 and {-1, -1}.

        The second may be sim.handle_all, which means everything else. The pair is a result of CoppeliaSim 4 only.
        """
        meter = self._world.meters.collisions
        if not meter.enabled:
            return 0, list(_NO_PAIR)
        try:
            pair = meter.check(self._self(first), self._self(second))
        except WrongKind as problem:  # in V-REP a dummy collides with nothing
            raise Unsupported(str(problem), (0, list(_NO_PAIR))) from None
        return int(bool(pair)), list(pair or _NO_PAIR)

    @reads
    def checkCollisionEx(self, first: int, second: int) -> tuple[int, list[float]]:
        """Return in how many segments the surfaces of two entities cut each other now, and x, y, z of both ends of
        each, in the world, metres.

        The second entity may be sim.handle_all. An object that lies wholly within another one cuts nothing.
        """
        meter = self._world.meters.collisions
        if not meter.enabled:
            return 0, []
        entities = meter.entities(self._self(first), self._self(second))
        found = intersections(self._world.instants.now(), *entities)
        return len(found), found.ravel().tolist()

    @reads
    def readCollision(self, handle: int) -> tuple[int, list[int]] | int:
        """Return the last result: 1 and the two objects, or 0; -1 before the first handling."""
        found = self._world.meters.collisions.read(handle)
        if found is None:
            return -1
        return (1, list(found)) if found else 0

    def handleCollision(self, handle: int) -> tuple[int, list[int]] | int:
        """Measure now and return 1 and the two objects, or 0; for sim.handle_all and sim.handle_all_except_explicit
        the number of collisions.
        """
        meter = self._world.meters.collisions
        found = [pair for each in _meant(meter, handle) if (pair := meter.handle(each))]
        return (1, list(found[0])) if found and handle >= 0 else len(found)

    def resetCollision(self, handle: int) -> int:
        """Delete the result until the next handling."""
        for each in _meant(self._world.meters.collisions, handle):
            self._world.meters.collisions.reset(each)
        return 1

    @reads
    def checkDistance(
        self, first: int, second: int = c.sim_handle_all, threshold: float = 0.0
    ) -> tuple[int, list[float], list[int]]:
        """Return 1, {x1, y1, z1, x2, y2, z2, distance} in the world frame, and the two objects; else 0, seven zeros
        and {-1, -1}. The objects are a result of CoppeliaSim 4 only.

        `threshold`: distances above it (metres) return 0; 0 or less means no threshold.
        """
        meter = self._world.meters.distances
        nothing: tuple[int, list[float], list[int]] = (0, [0.0] * 7, list(_NO_PAIR))
        if not meter.enabled:
            return nothing
        try:
            entities = meter.entities(self._self(first), self._self(second))
        except WrongKind as problem:
            raise Unsupported(str(problem), nothing) from None
        found = nearest(self._world.instants.now(), *entities)
        if found is None or 0.0 < threshold < found.distance:
            return nothing
        return 1, [*found.first.tolist(), *found.second.tolist(), found.distance], list(found.objects)

    @reads
    def readDistance(self, handle: int) -> tuple[int, float]:
        """Return 1 and the last distance in metres; 0 and 0 before the first handling."""
        found = self._world.meters.distances.read(handle)
        return (0, 0.0) if found is None else (1, found)

    def handleDistance(self, handle: int) -> tuple[int, float]:
        """Measure now and return 1 and metres, or 0 and 0; for sim.handle_all and the like the least distance."""
        meter = self._world.meters.distances
        found = [away for each in _meant(meter, handle) if (away := meter.handle(each)) is not None]
        return (1, min(found)) if found else (0, 0.0)

    def resetDistance(self, handle: int) -> int:
        """Delete the result until the next handling."""
        for each in _meant(self._world.meters.distances, handle):
            self._world.meters.distances.reset(each)
        return 1

    @reads
    def getCollisionHandle(self, name: str) -> int:
        """Return the handle of a collision object that the scene registers."""
        return collisions.get_collision_handle(self._world, self._adjusted(name))

    @reads
    def getDistanceHandle(self, name: str) -> int:
        """Return the handle of a distance object that the scene registers."""
        return collisions.get_distance_handle(self._world, self._adjusted(name))

    @reads
    def getContactInfo(
        self, dynamic_pass: int, handle: int, index: int
    ) -> tuple[list[int], list[float], list[float], list[float]] | None:
        """Return the two objects, the point, the force of the second on the first, and the normal; nil after the last
        contact.

        `dynamic_pass`: a physics step of the last simulation step, from 0, or sim.handle_all. Each physics step is kept
        from the first call on; before it they all have the contacts of the last one. `handle`: an object, which is then
        the first of the two, or sim.handle_all. `index` starts at 0.
        """
        wanted = None if handle == c.sim_handle_all else self._sim.scene.get(self._self(handle)).handle
        index -= _EXTENDED if index >= _EXTENDED else 0
        step = None if dynamic_pass == c.sim_handle_all else max(0, dynamic_pass)
        there = self._world.contacts.find(step, wanted)
        index = max(0, index)
        if index >= len(there):
            return None
        found = there[index]
        return list(found.objects), list(found.point), list(found.force), list(found.normal)

    @reads
    def getCollectionHandle(self, name: str) -> int:
        """Return the handle of a collection of the scene or of one that scripts made."""
        return collisions.get_collection_handle(self._world, self._adjusted(name))

    @reads
    def getCollectionName(self, collection: int) -> str:
        """Return the name of a collection. An unknown handle is an error."""
        return self._world.collections.name(collection)

    def createCollection(self, name: int | str = 0, options: int = 0) -> int:
        """Create an empty collection that lasts until the stop and return its handle; CoppeliaSim 4 passes only the
        options.

        Options: 1 its objects are measured and detected although they are not collidable, measurable or detectable.

        Partly: objects that images do not show stay hidden in any case.
        """
        if isinstance(name, int):
            options = name
        if isinstance(name, int) or not name:
            taken = (f"Collection{number}" for number in range(1, 10_000))
            name = next(each for each in taken if self._world.collections.find(each) is None)
        return self._world.collections.create(name, overrides=bool(options & 1))

    def setCollectionName(self, collection: int, name: str) -> int:
        """Rename a collection until the stop; return 1."""
        self._world.collections.rename(collection, name)
        return 1

    def addObjectToCollection(self, collection: int, handle: int, what: int, options: int = 0) -> int:
        """Add or remove items; `what`: sim.handle_single, tree, chain or all; bit 0 of `options` removes, bit 1
        excludes the object itself.
        """
        if what not in _KINDS:
            raise CommandError(
                "what is added is sim.handle_single, sim.handle_tree, sim.handle_chain or sim.handle_all"
            )
        kind = _KINDS[what][1 if options & _WITHOUT_BASE and what != c.sim_handle_single else 0]
        taken_out = bool(options & _TAKEN_OUT)
        self._world.collections.change(collection, kind, self._self(handle), taken_out=taken_out)
        return 1

    def addItemToCollection(self, collection: int, what: int, handle: int, options: int = 0) -> int:
        """Add or remove items: CoppeliaSim 4's form of sim.addObjectToCollection."""
        return self.addObjectToCollection(collection, handle, what, options)

    def addToCollection(
        self, collection: int, handle: int, what: int = c.sim_handle_single, options: int = 0
    ) -> int:
        """Add or remove items: CoppeliaSim 4.8's form of sim.addObjectToCollection, by default one object."""
        return self.addObjectToCollection(collection, handle, what, options)

    def createCollectionEx(self, options: int = 0) -> int:
        return self.createCollection(options)

    def emptyCollection(self, collection: int) -> int:
        """Remove all items."""
        self._world.collections.empty(collection)
        return 1

    def removeCollection(self, collection: int) -> int:
        """Remove a collection; one that the scene registers returns at the stop."""
        self._world.collections.remove(collection)
        return 1

    destroyCollection = removeCollection

    @reads
    def getCollectionObjects(self, collection: int) -> list[int]:
        """Return the handles of the objects that are in the collection now."""
        return self._world.collections.members(collection)


def _meant(meter: Meter[Pair] | Meter[float | None], handle: int) -> list[int]:
    if handle in (c.sim_handle_all, c.sim_handle_all_except_explicit):
        return meter.handles(explicit_too=handle == c.sim_handle_all)
    return [handle]
