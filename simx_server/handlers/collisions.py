"""Collisions, distances and collections."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..errors import CommandError, NotHandledYet
from .registry import handler

if TYPE_CHECKING:
    from simx_server.world.world import World

NOT_HANDLED = 1e37
"""Metres: what a distance object reads before it was handled; V-REP gave a number above 1e36."""


@handler("simxCheckCollision")
def check_collision(world: World, entity1: int, entity2: int) -> bool:
    """Whether two objects or collections meet now; entity 2 may be -2, all others.

    Differs: convex shapes are solid, so one that lies wholly within another collides with it.
    """
    meter = world.meters.collisions
    return meter.check(entity1, entity2) if meter.enabled else False


@handler("simxCheckDistance")
def check_distance(world: World, entity1: int, entity2: int) -> float:
    """Metres, 0 where they meet.

    Differs: with distance handling switched off it is 0, where V-REP left it undefined; so it did when there is
    nothing to measure, which is an error here.

    Raises:
        CommandError: there is nothing to measure, as with an empty collection.
    """
    if not world.meters.distances.enabled:
        return 0.0
    found = world.meters.distances.check(entity1, entity2)
    if found is None:
        raise CommandError(f"there is nothing to measure between the entities {entity1} and {entity2}")
    return found


@handler("simxReadCollision")
def read_collision(world: World, collision_object: int) -> bool:
    """Raises CommandError when it was not handled in the last pass, as before the first one and when switched off."""
    sim = world.simulation
    found = world.meters.collisions.read(collision_object)
    if found is None:
        raise NotHandledYet(
            f"collision object {collision_object} has not been handled yet; it is in each pass of a running "
            "simulation, or by its script when it is handled explicitly",
            is_coming=sim.is_before_first_pass,
        )
    return found


@handler("simxReadDistance")
def read_distance(world: World, distance_object: int) -> float:
    """Metres; a number above 1e36 when it was not handled in the last pass, or measured nothing."""
    found = world.meters.distances.read(distance_object)
    return NOT_HANDLED if found is None else found


@handler("simxGetCollisionHandle")
def get_collision_handle(world: World, name: str) -> int:
    """Of a collision object that the scene registers."""
    return world.meters.collisions.find(name)


@handler("simxGetDistanceHandle")
def get_distance_handle(world: World, name: str) -> int:
    """Of a distance object that the scene registers."""
    return world.meters.distances.find(name)


@handler("simxGetCollectionHandle")
def get_collection_handle(world: World, name: str) -> int:
    """Of a collection of the scene; else the integer signal of that name, as since CoppeliaSim 4.2.

    Raises:
        CommandError: neither is there.
    """
    handle = world.collections.find(name.removesuffix("#"))
    if handle is None:
        handle = world.signals.get_integer(name)
    if handle is None:
        known = ", ".join(world.collections.names()) or "none"
        raise CommandError(
            f"no collection and no integer signal named '{name}'; collections of this scene: {known}"
        )
    return handle
