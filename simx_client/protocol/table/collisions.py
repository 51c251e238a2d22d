"""Collisions, distances and collections."""

from __future__ import annotations

from ..kinds import BOOL, FLOAT
from .command import Command, Effect
from .meanings import (
    COLLECTION_NAME,
    COLLISION_HANDLE,
    COLLISION_NAME,
    DISTANCE_HANDLE,
    DISTANCE_NAME,
    FOUND_HANDLE,
    OBJECT_HANDLE,
    Meaning,
)

COLLISIONS = (
    Command(
        name="simxCheckCollision",
        takes={
            "entity1": OBJECT_HANDLE.but("handle of an object or collection"),
            "entity2": OBJECT_HANDLE.but(
                "handle of an object or collection, -2 for all others", sample="base"
            ),
        },
        gives={"collisionState": Meaning(BOOL, "whether they collide")},
        doc="Compute now whether two objects or collections collide.",
        effect=Effect.READS,
        key=("entity1", "entity2"),
        legacy_id=0x200F,
        twin="sim.checkCollision",
    ),
    Command(
        name="simxReadCollision",
        takes={"collisionObjectHandle": COLLISION_HANDLE},
        gives={"collisionState": Meaning(BOOL, "whether they collide")},
        doc="Return the result of a registered collision object.",
        effect=Effect.READS,
        key=("collisionObjectHandle",),
        legacy_id=0x1026,
    ),
    Command(
        name="simxGetCollisionHandle",
        takes={"collisionObjectName": COLLISION_NAME},
        gives={"handle": FOUND_HANDLE},
        doc="Return the handle of a registered collision object.",
        effect=Effect.READS,
        key=("collisionObjectName",),
        legacy_id=0x300A,
    ),
    Command(
        name="simxCheckDistance",
        takes={
            "entity1": OBJECT_HANDLE.but("handle of an object or collection"),
            "entity2": OBJECT_HANDLE.but(
                "handle of an object or collection, -2 for all others", sample="base"
            ),
        },
        gives={"minimumDistance": Meaning(FLOAT, "m")},
        doc="Compute now the distance between two objects or collections.",
        effect=Effect.READS,
        key=("entity1", "entity2"),
        legacy_id=0x2010,
        twin="sim.checkDistance",
    ),
    Command(
        name="simxReadDistance",
        takes={"distanceObjectHandle": DISTANCE_HANDLE},
        gives={"minimumDistance": Meaning(FLOAT, "m")},
        doc="Return the result of a registered distance object.",
        effect=Effect.READS,
        key=("distanceObjectHandle",),
        legacy_id=0x1027,
    ),
    Command(
        name="simxGetDistanceHandle",
        takes={"distanceObjectName": DISTANCE_NAME},
        gives={"handle": FOUND_HANDLE},
        doc="Return the handle of a registered distance object.",
        effect=Effect.READS,
        key=("distanceObjectName",),
        legacy_id=0x300B,
    ),
    Command(
        name="simxGetCollectionHandle",
        takes={"collectionName": COLLECTION_NAME},
        gives={"handle": FOUND_HANDLE},
        doc="Return the handle of a collection.",
        effect=Effect.READS,
        key=("collectionName",),
        legacy_id=0x3019,
    ),
)
