"""The pools of meshes of a file, to which new ones are added."""

from __future__ import annotations

import struct
from collections import defaultdict
from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from simx_server.scene.formats.vrep.chunks import Body, sections
from simx_server.scene.formats.vrep.decoding.meshes import EXTRA_OFFSETS, Pools, read_pools

from .record_lists import RecordList

FIRST_UNPACKED = 24
"""Version of the format from which indices and normals are not packed."""

_POOL_OF = {"Ver": "Vev", "In2": "Inv", "Ind": "Inv", "No2": "Nov", "Nor": "Nov", "Ved": "Vvd"}
"""The pool in which a record is: the tag with which leaves refer to it."""


POOLS = ("Vev", "Inv", "Nov", "Vvd")
"""Tags with which leaves refer to the pools."""


class MeshPools:
    """The record `VIN`: vertices, indices, normals and edges of all leaves, by their places."""

    def __init__(self, records: RecordList) -> None:
        self.records = records
        self._counts = dict.fromkeys(_POOL_OF.values(), 0)
        for tag, _ in records:
            if tag in _POOL_OF:
                self._counts[_POOL_OF[tag]] += 1

    def add(
        self, vertices: NDArray[np.float64], triangles: NDArray[np.int64], normals: NDArray[np.float64]
    ) -> dict[str, int]:
        """Add a mesh; return its place in each pool, by the tag with which a leaf refers to it.

        Args:
            vertices: (n, 3) metres.
            triangles: (m, 3) indices of vertices.
            normals: (m, 3) one for each triangle.
        """
        edges = bytes((3 * len(triangles) + 7) // 8)  # none is drawn
        return {
            "Vev": self._add("Ver", vertices.astype("<f4").tobytes()),
            "Inv": self._add(*self._indices(triangles)),
            "Nov": self._add(*self._normals(np.repeat(normals, 3, axis=0))),
            "Vvd": self._add("Ved", edges),
        }

    def bring(self, other: MeshPools, pool: str, place: int) -> int:
        """Add one record of other pools; return its place, -1 if they have none there.

        Args:
            other: the pools of another file.
            pool: the tag with which leaves refer to records of this kind.
            place: where it is in the other pool.

        Raises:
            SceneError: they are damaged.
        """
        records = other.by_pool.get(pool, [])
        if not 0 <= place < len(records):
            return -1
        if pool in ("Inv", "Nov") and _is_packed(self.records) != _is_packed(other.records):
            if pool == "Inv":
                return self._add(*self._indices(other.decoded.triangles[place]))
            return self._add(*self._normals(other.decoded.normals[place].reshape(-1, 3)))
        return self._add(*records[place])

    @cached_property
    def by_pool(self) -> Mapping[str, list[tuple[str, bytes]]]:
        """Return the records as they were read, by the tags with which leaves refer to them."""
        found = defaultdict[str, list[tuple[str, bytes]]](list)
        for tag, payload in self.records:
            if tag in _POOL_OF:
                found[_POOL_OF[tag]].append((tag, payload))
        return dict(found)

    @cached_property
    def decoded(self) -> Pools:
        """Return the meshes as they were read. Raises SceneError."""
        data = bytes(self.records)
        (chunks,) = sections(Body(memoryview(data), ""), ["VIN"], 0, len(data))
        return read_pools(chunks)

    def _indices(self, triangles: NDArray[Any]) -> tuple[str, bytes]:
        """Return tag and payload of indices, in the form of the file's version."""
        if _is_packed(self.records):
            return "In2", packed_indices(triangles)
        return "Ind", triangles.astype("<i4").tobytes()

    def _normals(self, normals: NDArray[Any]) -> tuple[str, bytes]:
        if _is_packed(self.records):
            return "No2", packed_normals(normals)
        return "Nor", normals.astype("<f4").tobytes()

    def _add(self, tag: str, payload: bytes) -> int:
        """Add one record; return its place in its pool."""
        self.records.add(tag, payload)
        self._counts[_POOL_OF[tag]] += 1
        return self._counts[_POOL_OF[tag]] - 1


def _is_packed(records: RecordList) -> bool:
    return records.serialization < FIRST_UNPACKED


def packed_indices(triangles: NDArray[Any]) -> bytes:
    """Return indices as differences of one to four bytes, as `decoding/meshes.py` unpacks them."""
    found, last = bytearray(struct.pack("<i", triangles.size)), 0
    for index in triangles.ravel().tolist():
        difference, last = index - last, index
        for extra, offset in enumerate(EXTRA_OFFSETS.tolist()):
            value = difference + offset
            if 0 <= value < 1 << (6 + 8 * extra):
                found.append(value & 63 | extra << 6)
                found += (value >> 6).to_bytes(extra, "little")
                break
    return bytes(found)


def packed_normals(normals: NDArray[Any]) -> bytes:
    """Return normals as 16 bits each."""
    levels = np.clip(np.round(normals * 15), -15, 15).astype(np.int64) + 15
    return (levels[:, 0] | levels[:, 1] << 5 | levels[:, 2] << 10).astype("<u2").tobytes()
