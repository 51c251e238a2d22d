"""Collisions, distances and collections."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_server.service.calls.registry import handler

from ..errors import CommandError, NotHandledYet

if TYPE_CHECKING:
    from simx_server.world.world import World

NOT_HANDLED = 1e37
"""Value in metres of a distance object that was not handled yet; V-REP returned a number above 1e36."""


@handler("simxCheckCollision")
def check_collision(world: World, entity1: int, entity2: int) -> bool:
    """Accept -2 as entity 2 for all other objects.

    Differs: convex shapes are solid, so a shape wholly within another one collides with it.
    """
    meter = world.meters.collisions
    return meter.enabled and bool(meter.check(entity1, entity2))


@handler("simxCheckDistance")
def check_distance(world: World, entity1: int, entity2: int) -> float:
    """Return metres, 0 when the two collide.

    Differs: with distance handling switched off the result is 0, where V-REP left it undefined. V-REP also left it
    undefined when there is nothing to measure, which is an error here.

    Raises:
        CommandError: there is nothing to measure, for example in an empty collection.
    """
    if not world.meters.distances.enabled:
        return 0.0
    found = world.meters.distances.check(entity1, entity2)
    if found is None:
        raise CommandError(f"there is nothing to measure between the entities {entity1} and {entity2}")
    return found


@handler("simxReadCollision")
def read_collision(world: World, collision_object: int) -> bool:
    """Raises CommandError when it was not handled in the last simulation step, as before the first one.

    The same error occurs when collision handling is switched off.
    """
    found = world.meters.collisions.read(collision_object)
    if found is None:
        raise NotHandledYet(
            f"collision object {collision_object} has not been handled yet; it is in each pass of a running "
            "simulation, or by its script when it is handled explicitly",
            is_coming=world.simulation.is_before_first_step,
        )
    return bool(found)


@handler("simxReadDistance")
def read_distance(world: World, distance_object: int) -> float:
    """Return metres; more than 1e36 if it was not handled in the last simulation step or measured nothing."""
    found = world.meters.distances.read(distance_object)
    return NOT_HANDLED if found is None else found


@handler("simxGetCollisionHandle")
def get_collision_handle(world: World, name: str) -> int:
    """Search the collision objects that the scene registers."""
    return world.meters.collisions.find(name)


@handler("simxGetDistanceHandle")
def get_distance_handle(world: World, name: str) -> int:
    """Search the distance objects that the scene registers."""
    return world.meters.distances.find(name)


@handler("simxGetCollectionHandle")
def get_collection_handle(world: World, name: str) -> int:
    """Search the collections of the scene, then the integer signals for this name, as CoppeliaSim does since 4.2.

    Raises:
        CommandError: the scene has neither.
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
