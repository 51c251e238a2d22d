"""Collections, collision and distance objects of a V-REP file."""

from __future__ import annotations

from simx_server.scene.formats.texts.graph_streams import plain_name
from simx_server.scene.formats.texts.values import write_steps
from simx_server.scene.formats.vrep.conversion.context import Conversion, collection_name
from simx_server.scene.formats.vrep.objects import Collection, Pair

_ALL = 5
KINDS = {0: "object", 1: "tree", 2: "below", 3: "chain", 4: "above", _ALL: "all"}
"""Kinds of entries of a collection, with the file's numbers."""


def add_registered(conversion: Conversion) -> None:
    """Annotate the collections, collision objects and distance objects."""
    for collection in conversion.file.collections:
        _add_collection(conversion, collection)
    for kind, pairs in (("collision", conversion.file.collisions), ("distance", conversion.file.distances)):
        for pair in pairs:
            _add_pair(conversion, kind, pair)


def _add_collection(conversion: Conversion, collection: Collection) -> None:
    name_here = collection_name(collection)
    steps: list[tuple[bool, str, str]] = []
    for item, number, additive in collection.entries:
        kind = KINDS.get(number)
        name = "" if kind == "all" else conversion.names.get(item)
        if kind is None or name is None:
            what = f"entries of kind {number}" if kind is None else "entries whose object is not in the file"
            conversion.report.leave_out(f"collections have no {what}", name_here)
        else:
            steps.append((not additive, kind, name))
    # A collection without entries is registered too.
    conversion.annotate(
        "collection",
        name_here,
        all=None if steps else False,
        steps=write_steps(steps) or None,
        overrides=collection.overrides or None,
    )


def is_usable(conversion: Conversion, pair: Pair) -> bool:
    """Return whether a collision or distance object has a name, and entities that are in the file."""
    first, second = conversion.entity(pair.entity1), conversion.entity(pair.entity2)
    return bool(pair.name) and first not in (None, "all") and second is not None


def name_of(pair: Pair) -> str:
    """Return the name under which a collision or distance object is registered: a graph's annotation can have it."""
    return plain_name(pair.name)


def _add_pair(conversion: Conversion, kind: str, pair: Pair) -> None:
    first, second = conversion.entity(pair.entity1), conversion.entity(pair.entity2)
    if not is_usable(conversion, pair):
        conversion.report.leave_out(f"{kind} objects without an object to measure", pair.name)
        return
    conversion.annotate(
        kind, name_of(pair), entity1=first, entity2=second, explicit=True if pair.is_explicit else None
    )
