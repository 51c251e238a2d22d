"""Normals for the browser: without them it shows each face of a mesh flat."""

from __future__ import annotations

from typing import Any

import numpy as np
import trimesh
import trimesh.visual
from numpy.typing import NDArray

SHARP = float(np.cos(np.radians(40.0)))
"""Cosine of the angle between two faces from which their edge is shown."""

_MOST_FACES = 100_000
"""Faces of a mesh that is smoothed; that many take half a second."""

_MOST_PAIRS = 20_000_000
"""Pairs of corners in one place, in a mesh that is smoothed: 1 GB of memory."""

_STEPS = 64
"""Steps per unit in which normals are told apart, and merged otherwise."""

_PLACES = 7
"""Decimals of the coordinates, in sizes of the mesh, by which places are told apart."""


def smoothed(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """Return a mesh whose faces share normals except at sharp edges.

    A corner gets the mean normal of the faces around it that are turned by less than the sharp angle, weighted by
    their angles. Corners that differ in their normal become separate points.
    """
    faces = np.asarray(mesh.faces)
    if not 0 < len(faces) <= _MOST_FACES:
        return mesh
    points = np.asarray(mesh.vertices)
    scale = float(np.ptp(points, axis=0).max()) or 1.0
    _, places = np.unique(np.round(points / scale, _PLACES), axis=0, return_inverse=True)
    places = places.reshape(-1)[faces].ravel()
    if int((np.bincount(places).astype(np.int64) ** 2).sum()) > _MOST_PAIRS:
        return mesh
    normals = _corner_normals(points, faces, places)
    key = np.column_stack((faces.ravel(), np.round(normals * _STEPS).astype(np.int64)))
    _, first, inverse = np.unique(key, axis=0, return_index=True, return_inverse=True)
    kept = faces.ravel()[first]
    return trimesh.Trimesh(
        vertices=points[kept],
        faces=inverse.reshape(-1, 3),
        vertex_normals=normals[first],
        visual=_visual(mesh, kept),
        process=False,
    )


def _corner_normals(
    points: NDArray[np.float64], faces: NDArray[np.int64], places: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Return (3 faces, 3) unit normals; `places` (3 faces,): the number of each corner's place."""
    corners = points[faces]
    ahead, back = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
    units = np.repeat(_unit(np.cross(ahead[:, 0], back[:, 0])), 3, axis=0)
    cosines = np.einsum("mci,mci->mc", _unit(ahead), _unit(back))
    weighted = units * np.arccos(np.clip(cosines, -1.0, 1.0)).reshape(-1, 1)
    one, other = _pairs(places)
    near = np.einsum("ij,ij->i", units[one], units[other]) > SHARP
    one, other = one[near], other[near]
    sums = np.zeros((len(places), 3))
    np.add.at(sums, one, weighted[other])
    found = _unit(sums)
    return np.where(found.any(axis=1, keepdims=True), found, units)


def _pairs(places: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return all ordered pairs of corners in one place, those of a corner with itself among them."""
    order = np.argsort(places, kind="stable")
    counts = np.bincount(places)
    of_corner = counts[places[order]]
    group_starts = np.repeat(np.cumsum(counts) - counts, counts)
    within = np.arange(int(of_corner.sum())) - np.repeat(np.cumsum(of_corner) - of_corner, of_corner)
    return np.repeat(order, of_corner), order[np.repeat(group_starts, of_corner) + within]


def _unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return vectors (..., 3) with the length 1; those without a length stay 0."""
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.where(lengths > 0, vectors / np.where(lengths > 0, lengths, 1.0), 0.0)


def _visual(
    mesh: trimesh.Trimesh, kept: NDArray[np.int64]
) -> trimesh.visual.ColorVisuals | trimesh.visual.TextureVisuals:
    """Return the looks of a mesh whose points are these points of another, and whose faces are the same."""
    visual: Any = mesh.visual  # trimesh declares little of it
    if visual.kind == "texture":
        uv = None if visual.uv is None else visual.uv[kept]
        return trimesh.visual.TextureVisuals(uv=uv, material=visual.material)
    if visual.kind == "vertex":
        return trimesh.visual.ColorVisuals(vertex_colors=visual.vertex_colors[kept])
    return trimesh.visual.ColorVisuals(face_colors=visual.face_colors)
