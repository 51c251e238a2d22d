"""Entities of sensors: everything, an object or a collection."""

from __future__ import annotations

from simx_server.scene.formats.vrep.conversion.context import Conversion
from simx_server.scene.formats.vrep.objects import VrepObject


def entity_name(conversion: Conversion, sensor: VrepObject, entity: int) -> str | None:
    """Return the word for `entity=` of a sensor's annotation; None for everything.

    A number that the file does not define means everything, as in V-REP after the entity was removed.
    """
    word = conversion.entity(entity)
    if word is None:
        conversion.report.approximate(
            "sensors are restricted to an object or collection that is not in the file; they see everything",
            conversion.name(sensor),
        )
    return None if word == "all" else word
