"""Vertices, triangles and normals: the file's pools, which leaves refer to, and how they are packed."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from simx_server.scene.formats.vrep.chunks import Chunks, Place

Vertices = NDArray[np.float32]
Triangles = NDArray[np.int32]

EXTRA_OFFSETS = np.array([31, 8191, 2097151, 536870911], np.int64)
"""Subtracted from a packed difference that has 0 to 3 extra bytes."""
LOOKED_AT = 60
"""Triangles of a mesh whose normals are compared with its vertices."""
BLOCK = 1 << 16
"""Packed bytes unpacked at a time."""
DOUBLINGS = 6
"""A stride is 2**DOUBLINGS differences."""


@dataclass
class Pools:
    """The meshes of a file: each is decoded once, and shared by the leaves that refer to it."""

    chunks: Chunks | None = None
    vertices: list[Vertices] = field(default_factory=list[Vertices])
    triangles: list[Triangles] = field(default_factory=list[Triangles])
    highest: list[int] = field(default_factory=list[int])
    """Highest index in each of `triangles`, found once: a file may have very many leaves that share a large mesh."""
    normals: list[Vertices] = field(default_factory=list[Vertices])


def read_pools(chunks: Chunks) -> Pools:
    """Decode the pools of a file."""
    pools = Pools(chunks)
    for place in chunks.all_places("Ver"):
        pools.vertices.append(vertices_of(chunks, "Ver", place))
    for tag in ("In2", "Ind"):
        for place in chunks.all_places(tag):
            triangles = triangles_of(chunks, tag, place)
            pools.triangles.append(triangles)
            pools.highest.append(int(triangles.max(initial=-1)))
    for tag in ("No2", "Nor"):
        for place in chunks.all_places(tag):
            pools.normals.append(normals_of(chunks, tag, place))
    return pools


def vertices_of(chunks: Chunks, tag: str, place: Place) -> Vertices:
    """Return (n, 3) points."""
    values = _floats(chunks, place)
    if not np.isfinite(values).all():
        raise chunks.error(tag, "has a coordinate that is not finite")
    return values[: values.size // 3 * 3].reshape(-1, 3)


def triangles_of(chunks: Chunks, tag: str, place: Place) -> Triangles:
    """Return (n, 3) indices of packed (In2) or plain (Ind) ones."""
    values = _unpacked(chunks, tag, place) if tag == "In2" else _ints(chunks, place)
    if values.min(initial=0) < 0:
        raise chunks.error(tag, "has an index below 0")
    return values[: values.size // 3 * 3].reshape(-1, 3)


def normals_of(chunks: Chunks, tag: str, place: Place) -> Vertices:
    """Return (triangles, 3, 3) normals of length 1, of packed (No2) or plain (Nor) ones."""
    if tag == "No2":
        start, end = place
        words = np.frombuffer(chunks.body.data, "<u2", (end - start) // 2, start)
        values = np.empty((words.size, 3), np.float32)
        for axis in range(3):
            values[:, axis] = words >> 5 * axis & 31
        values -= 15.0
    else:
        values = _floats(chunks, place)
        values = values[: values.size // 3 * 3].reshape(-1, 3)
    values = values[: len(values) // 3 * 3]
    with np.errstate(all="ignore"):  # damaged ones become zeros
        lengths = np.sqrt(np.einsum("ij,ij->i", values, values))
        good = np.isfinite(lengths) & (lengths > 0)
        values /= np.where(good, lengths, 1.0)[:, None]
    values[~good] = 0.0
    return values.reshape(-1, 3, 3)


def agree(vertices: Vertices, triangles: Triangles, normals: Vertices) -> bool:
    """Return whether normals point to the outer side of most triangles, of which some are looked at.

    In groups of primitives that V-REP 3 saved, they are given in another frame.
    """
    some = slice(None, None, max(1, len(triangles) // LOOKED_AT))
    a, b, c = (vertices[triangles[some, corner]].astype(np.float64) for corner in range(3))
    with np.errstate(all="ignore"):  # of a triangle without area, nothing is compared
        flat = np.cross(b - a, c - a)
        flat /= np.linalg.norm(flat, axis=1, keepdims=True)
    solid = np.isfinite(flat).all(axis=1)
    outward = np.einsum("ijk,ik->ij", normals[some][solid], flat[solid]) > 0.5
    return not solid.any() or float(np.count_nonzero(outward)) > 0.75 * outward.size


def _floats(chunks: Chunks, place: Place) -> Vertices:
    start, end = place
    return np.frombuffer(chunks.body.data, "<f4", (end - start) // 4, start).astype(np.float32)


def _ints(chunks: Chunks, place: Place) -> Triangles:
    start, end = place
    return np.frombuffer(chunks.body.data, "<i4", (end - start) // 4, start).astype(np.int32)


def _unpacked(chunks: Chunks, tag: str, place: Place) -> Triangles:
    """Return indices that were written as differences of one to four bytes.

    The two highest bits of a difference's first byte tell how many bytes follow.
    """
    start, end = place
    (count,) = chunks.whole(tag, start, end, "i")
    octets = np.frombuffer(chunks.body.data, np.uint8, end - start - 4, start + 4)
    if not 0 <= count <= octets.size:
        raise chunks.error(tag, f"promises {count} indices in {octets.size} bytes")
    indices = np.empty(count, np.int32)
    done, first, last = 0, 0, 0
    while done < count and first < octets.size:
        block = octets[first : first + BLOCK]
        begins, beyond = _begins(block)
        begins = begins[: count - done]
        if first + int(begins[-1]) + 1 + int(block[begins[-1]] >> 6) > octets.size:
            break
        differences = _differences(octets[first : first + BLOCK + 3], begins)
        values = last + np.cumsum(differences)
        if not 0 <= values.min() <= values.max() < 1 << 31:
            raise chunks.error(tag, "has an index that is not between 0 and 2147483647")
        indices[done : done + values.size] = values
        done, first, last = done + values.size, first + beyond, int(values[-1])
    if done < count:
        raise chunks.error(tag, f"has fewer than the {count} indices that it promises")
    return indices


def _begins(octets: NDArray[np.uint8]) -> tuple[NDArray[np.intp], int]:
    """Return where differences start, and where the first one after these bytes does.

    All bytes are looked at once: each tells where the next difference would start if one started there. Following this
    a few times gives long strides, which a plain loop walks.
    """
    size = octets.size
    following = np.arange(size + 4, dtype=np.intp)
    following[:size] += 1 + (octets >> 6)
    stride = following
    for _ in range(DOUBLINGS):
        stride = stride[stride]
    lanes: list[int] = []
    at = 0
    while at < size:
        lanes.append(at)
        at = stride.item(at)
    begins = np.empty((len(lanes), 1 << DOUBLINGS), np.intp)
    begins[:, 0] = lanes
    for step in range(1, 1 << DOUBLINGS):
        begins[:, step] = following[begins[:, step - 1]]
    found = begins.reshape(-1)
    return found[found < size], at


def _differences(octets: NDArray[np.uint8], begins: NDArray[np.intp]) -> NDArray[np.int64]:
    padded = np.concatenate((octets, np.zeros(3, np.uint8)))
    extra = octets[begins] >> 6
    values = (octets[begins] & 63).astype(np.int64)
    for byte, shift in ((1, 6), (2, 14), (3, 22)):
        values |= np.where(extra >= byte, padded[begins + byte].astype(np.int64) << shift, 0)
    return values - EXTRA_OFFSETS[extra]
