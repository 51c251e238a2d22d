"""Collisions, distances and collections."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..errors import CommandError, NotHandledYet
from .registry import handler

if TYPE_CHECKING:
    from simx_server.world.simulation import Simulation

NOT_HANDLED = 1e37
"""Metres: what a distance object reads before it was handled; V-REP gave a number above 1e36."""


@handler("simxCheckCollision")
def check_collision(sim: Simulation, entity1: int, entity2: int) -> bool:
    """Whether two objects or collections meet now; entity 2 may be -2, all others.

    Differs: convex shapes are solid, so one that lies wholly within another collides with it.
    """
    meter = sim.meters.collisions
    return meter.check(entity1, entity2) if meter.enabled else False


@handler("simxCheckDistance")
def check_distance(sim: Simulation, entity1: int, entity2: int) -> float:
    """Metres, 0 where they meet.

    Differs: with distance handling switched off it is 0, where V-REP left it undefined; so it did when there is
    nothing to measure, which is an error here.

    Raises:
        CommandError: there is nothing to measure, as with an empty collection.
    """
    if not sim.meters.distances.enabled:
        return 0.0
    found = sim.meters.distances.check(entity1, entity2)
    if found is None:
        raise CommandError(f"there is nothing to measure between the entities {entity1} and {entity2}")
    return found


@handler("simxReadCollision")
def read_collision(sim: Simulation, collision_object: int) -> bool:
    """Raises CommandError when it was not handled in the last pass, as before the first one and when switched off."""
    found = sim.meters.collisions.read(collision_object)
    if found is None:
        raise NotHandledYet(
            f"collision object {collision_object} has not been handled yet; it is in each pass of a running "
            "simulation, or by its script when it is handled explicitly",
            is_coming=sim.is_before_first_pass,
        )
    return found


@handler("simxReadDistance")
def read_distance(sim: Simulation, distance_object: int) -> float:
    """Metres; a number above 1e36 when it was not handled in the last pass, or measured nothing."""
    found = sim.meters.distances.read(distance_object)
    return NOT_HANDLED if found is None else found


@handler("simxGetCollisionHandle")
def get_collision_handle(sim: Simulation, name: str) -> int:
    """Of a collision object that the scene registers."""
    return sim.meters.collisions.find(name)


@handler("simxGetDistanceHandle")
def get_distance_handle(sim: Simulation, name: str) -> int:
    """Of a distance object that the scene registers."""
    return sim.meters.distances.find(name)


@handler("simxGetCollectionHandle")
def get_collection_handle(sim: Simulation, name: str) -> int:
    """Of a collection of the scene; else the integer signal of that name, as since CoppeliaSim 4.2.

    Raises:
        CommandError: neither is there.
    """
    handle = sim.collections.find(name.removesuffix("#"))
    if handle is None:
        handle = sim.signals.get_integer(name)
    if handle is None:
        known = ", ".join(sim.collections.names()) or "none"
        raise CommandError(
            f"no collection and no integer signal named '{name}'; collections of this scene: {known}"
        )
    return handle
