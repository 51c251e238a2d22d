"""Which triangles of a mesh are sound, which of its parts are closed, and which way a closed part faces.

MuJoCo draws the front of a triangle alone; V-REP draws both sides unless a shape culls back faces. So an open part is
drawn twice, once from each side. A closed part needs only its outside.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float32]
"""(n, 3), metres."""
Faces = NDArray[np.int32]
"""(n, 3), indices of points."""
Mask = NDArray[np.bool_]

_SLIVER = 1e-10
"""Area of a triangle, in squared sizes of its mesh, up to which it is left out."""


def area_vectors(points: Points | NDArray[np.float64], faces: Faces) -> NDArray[np.float64]:
    """Return (n, 3) the normals of faces by the right-hand rule, as long as their areas."""
    corners = points.T.astype(np.float64)[:, faces.T]
    (ax, ay, az), (bx, by, bz) = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=1) / 2


def sound(points: Points, faces: Faces) -> Mask:
    """Return (n,): which faces have an area and corners that exist."""
    if not len(points) or not len(faces):
        return np.zeros(len(faces), bool)
    valid = np.ones(len(faces), bool)
    if faces.min() < 0 or faces.max() >= len(points):
        valid = np.logical_and(faces.min(axis=1) >= 0, faces.max(axis=1) < len(points))
        faces = np.where(valid[:, np.newaxis], faces, 0)
    extent = float(np.ptp(points, axis=0).max())
    return valid & (_lengths(area_vectors(points, faces)) > _SLIVER * extent * extent)


def normals_of(points: Points, faces: Faces) -> NDArray[np.float64]:
    """Return (n, 3) unit normals of faces that have an area, by the right-hand rule."""
    vectors = area_vectors(points, faces)
    return vectors / _lengths(vectors)[:, np.newaxis]


def both_sides(points: Points, faces: Faces) -> tuple[Faces, NDArray[np.intp]]:
    """Return the faces to draw so that the mesh is seen from everywhere.

    Faces of open parts come twice, the second time reversed; closed parts are turned so that they face outwards.

    Returns:
        (m, 3) faces; (m,) the face of the mesh that each one shows.
    """
    welded = faces
    if not _is_closed(welded, len(points)):
        welded = _weld(points)[faces]
    part = _parts(welded, len(points))
    is_open = np.zeros(len(points), bool)
    is_open[part[_unpaired(welded, len(points))]] = True
    starts = points[faces[:, 0]] - points.mean(axis=0)
    volumes = np.einsum("ij,ij->i", starts, area_vectors(points, faces))
    inside_out = np.bincount(part, volumes, len(points)) < 0
    turned = inside_out[part] & ~is_open[part]
    shown = np.where(turned[:, np.newaxis], faces[:, ::-1], faces) if turned.any() else faces
    twice = np.flatnonzero(is_open[part])
    return np.concatenate([shown, faces[twice, ::-1]]), np.concatenate([np.arange(len(faces)), twice])


def connected(points: Points, faces: Faces) -> NDArray[np.int64]:
    """Return (n,): for each face the number of its part, from 0; faces that share a corner are in one part."""
    if not len(faces):
        return np.zeros(0, np.int64)
    welded = _weld(points)[faces]
    _, number = np.unique(_parts(welded, int(welded.max()) + 1), return_inverse=True)
    return number.reshape(-1)


def welded(points: Points, faces: Faces) -> tuple[Points, Faces]:
    """Return a mesh in which no two points lie at the same place."""
    _, first, number = np.unique(_weld(points), return_index=True, return_inverse=True)
    return points[first], number.reshape(-1)[faces].astype(np.int32)


def is_closed(points: Points, faces: Faces) -> bool:
    """Return whether the mesh has no border: at each edge as many faces have one direction as the other."""
    there, back = _edges(_weld(points)[faces], len(points))
    return len(faces) > 0 and np.array_equal(np.sort(there), np.sort(back))


def volume_of(points: Points | NDArray[np.float64], faces: Faces) -> float:
    """Return the volume in a closed mesh, m^3; negative where it faces inwards."""
    starts = points[faces[:, 0]] - points.mean(axis=0)
    return float(np.einsum("ij,ij->", starts, area_vectors(points, faces))) / 3


_FIRST_FACES = 64
"""Faces that are looked at first."""


def is_convex(points: Points, faces: Faces, tolerance: float = 1e-4) -> bool:
    """Return whether no point lies in front of a face, up to a part of the mesh's size; border or not."""
    if not len(faces):
        return False
    corners = points[faces].astype(np.float64)
    normals = normals_of(points, faces)
    offsets = np.einsum("ij,ij->i", normals, corners[:, 0])
    limit = tolerance * float(np.ptp(points, axis=0).max())
    used = points[np.unique(faces)].astype(np.float64)
    inside = normals @ used.mean(axis=0) - offsets
    outward = np.where(inside > 0, -1.0, 1.0)
    # Most meshes that are not convex show it at their first faces.
    at_once, most = _FIRST_FACES, max(_FIRST_FACES, 4_000_000 // max(1, len(used)))  # limits the memory
    first = 0
    while first < len(faces):
        some = slice(first, first + at_once)
        heights = (normals[some] @ used.T - offsets[some, np.newaxis]) * outward[some, np.newaxis]
        if heights.max() > limit:
            return False
        first, at_once = first + at_once, most
    return True


def thickness(points: Points) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    """Return the middle of points, the direction (unit) in which they spread least, and how far they spread there."""
    middle = points.mean(axis=0, dtype=np.float64)
    away = points - middle
    _, axes = np.linalg.eigh(away.T @ away)
    heights = away @ axes[:, 0]
    return middle, axes[:, 0], float(np.ptp(heights))


def _lengths(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.sqrt(np.einsum("ij,ij->i", vectors, vectors))


def _weld(points: Points) -> NDArray[np.int64]:
    """Return (n,): for each point a number that points at the same place share."""
    order = np.lexsort(points.T)
    ordered = points[order]
    is_new = np.ones(len(points), bool)
    is_new[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    numbers = np.empty(len(points), np.int64)
    numbers[order] = np.cumsum(is_new) - 1
    return numbers


def _edges(faces: NDArray[Any], size: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return (3 n,) a number for each edge of the faces in its direction, and that of the opposite direction."""
    starts = faces.astype(np.int64)
    ends = starts[:, [1, 2, 0]]
    return (starts * size + ends).ravel(), (ends * size + starts).ravel()


def _is_closed(faces: NDArray[Any], size: int) -> bool:
    there, back = _edges(faces, size)
    there.sort()
    back.sort()
    return np.array_equal(there, back) and not (there[1:] == there[:-1]).any()


def _unpaired(faces: NDArray[Any], size: int) -> NDArray[np.intp]:
    """Return faces at whose edges no neighbour of the same orientation lies, or more than one."""
    there, back = _edges(faces, size)
    known = np.sort(there)
    if np.array_equal(known, np.sort(back)) and not (known[1:] == known[:-1]).any():
        return np.zeros(0, np.intp)
    opposite = np.searchsorted(known, back, "right") - np.searchsorted(known, back)
    same = np.searchsorted(known, there, "right") - np.searchsorted(known, there)
    return np.flatnonzero(~((opposite == 1) & (same == 1)).reshape(-1, 3).all(axis=1))


def _parts(faces: NDArray[Any], size: int) -> NDArray[np.int64]:
    """Return (n,): for each face a number that all faces share that hang together by corners."""
    label = np.arange(size)
    while True:
        of_faces = label[faces]
        least = of_faces.min(axis=1)
        before = label.copy()
        np.minimum.at(label, of_faces, least[:, np.newaxis])
        while not np.array_equal(label, further := label[label]):
            label = further
        if np.array_equal(label, before):
            return label[faces[:, 0]]
