"""Collisions and distances: 1 or 0, and metres."""

from __future__ import annotations

from ...handlers import collisions
from .base import ApiPart


class CollisionFunctions(ApiPart):
    """Between objects, collections, and registered pairs."""

    def checkCollision(self, first: int, second: int) -> int:
        return int(collisions.check_collision(self._sim, self._self(first), self._self(second)))

    def readCollision(self, handle: int) -> int:
        return int(collisions.read_collision(self._sim, handle))

    def handleCollision(self, handle: int) -> int:
        return int(self._sim.meters.collisions.handle(handle))

    def readDistance(self, handle: int) -> tuple[int, float]:
        found = self._sim.meters.distances.read(handle)
        return (0, 0.0) if found is None else (1, found)

    def handleDistance(self, handle: int) -> tuple[int, float]:
        found = self._sim.meters.distances.handle(handle)
        return (0, 0.0) if found is None else (1, found)

    def getCollisionHandle(self, name: str) -> int:
        return collisions.get_collision_handle(self._sim, name)

    def getDistanceHandle(self, name: str) -> int:
        return collisions.get_distance_handle(self._sim, name)

    def getCollectionHandle(self, name: str) -> int:
        return collisions.get_collection_handle(self._sim, name)
