"""Records of new graphs. Their streams come from scripts and clients, which add them again."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..field import Field, Fields, Writing

if TYPE_CHECKING:
    from simx_server.scene.formats.vrep.writing.object_records import ObjectRecords

_SIZE, _CAPACITY = 0.1, 1000
"""Of V-REP's new graphs: metres, and points of a stream."""


def _put(records: ObjectRecords, value: tuple[float, int], _writing: Writing) -> None:
    size, capacity = value
    records.own.put_numbers("Ghg", size)
    records.own.put_numbers("Gbv", capacity, 0)


GRAPHS: Fields = {"size and capacity": Field(lambda _world, _handle: (_SIZE, _CAPACITY), _put)}
"""Those of a graph in the file stay: the server does not change them."""
