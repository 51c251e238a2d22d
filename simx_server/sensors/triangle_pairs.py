"""The least distance between two sets of triangles: exact for surfaces of any shape, hollow or not."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .nearest import cross
from .triangles import Array

_PAIRS_AT_ONCE = 4096
_ROWS_AT_ONCE = 1_000_000
"""Bounds the table of lower bounds, which has a number for every pair of triangles."""

_NEXT = [1, 2, 0]


def least_distance(first: Array, second: Array, limit: float) -> float:
    """Metres between triangles (n, 3, 3) and (m, 3, 3), 0 where they meet; `limit` if none are closer than that."""
    best = limit
    centres, others = first.mean(axis=1), second.mean(axis=1)
    radii, other_radii = _radii(first, centres), _radii(second, others)
    step = max(1, _ROWS_AT_ONCE // max(1, len(second)))
    for start in range(0, len(first), step):
        rows = slice(start, start + step)
        away = centres[rows, np.newaxis] - others
        between = np.sqrt(np.einsum("nmi,nmi->nm", away, away))
        # The centres are points of the triangles.
        best = min(best, float(between.min(initial=math.inf)))
        lower = between - radii[rows, np.newaxis] - other_radii
        near, far = np.nonzero(lower <= best)
        order = np.argsort(lower[near, far])
        near, far = near[order] + start, far[order]
        bounds = lower.ravel()[(near - start) * len(second) + far]
        for chunk in range(0, len(near), _PAIRS_AT_ONCE):
            if bounds[chunk] > best or best <= 0.0:
                break
            some = slice(chunk, chunk + _PAIRS_AT_ONCE)
            best = min(best, _pairs(first[near[some]], second[far[some]]))
    return best


def _pairs(first: Array, second: Array) -> float:
    """Least distance of triangles pair by pair, (n, 3, 3) each."""
    edges, others = first[:, _NEXT] - first, second[:, _NEXT] - second
    best = min(_face_distance(first, second), _face_distance(second, first))
    if _pierced(first, edges, second) or _pierced(second, others, first):
        return 0.0
    return min(best, _edge_distance(first, edges, second, others))


def _edge_distance(first: Array, edges: Array, second: Array, others: Array) -> float:
    """Between any edge of one and any of the other. Segments as p + s u and q + t v, s and t within 0..1."""
    p, u = first[:, :, np.newaxis], edges[:, :, np.newaxis]
    q, v = second[:, np.newaxis], others[:, np.newaxis]
    r = p - q
    a, e = _dot(u, u), _dot(v, v)
    b, c, f = _dot(u, v), _dot(u, r), _dot(v, r)
    denominator = a * e - b * b
    with np.errstate(divide="ignore", invalid="ignore"):
        s = np.where(denominator > 1e-14 * a * e, np.clip((b * f - c * e) / denominator, 0.0, 1.0), 0.0)
        t = np.clip((b * s + f) / e, 0.0, 1.0)
        s = np.clip((b * t - c) / a, 0.0, 1.0)
    away = r + s[..., np.newaxis] * u - t[..., np.newaxis] * v
    return math.sqrt(max(0.0, float(np.nanmin(_dot(away, away), initial=math.inf))))


def _face_distance(corners: Array, faces: Array) -> float:
    """From corners of one to the inside of the other."""
    normal = cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0])
    length = np.sqrt(_dot(normal, normal))
    with np.errstate(divide="ignore", invalid="ignore"):
        normal = normal / length[:, np.newaxis]
    heights = np.einsum("nki,ni->nk", corners - faces[:, :1], normal)
    feet = corners - heights[..., np.newaxis] * normal[:, np.newaxis]
    held = _held(feet, faces, normal)
    return float(np.abs(heights[held]).min(initial=math.inf))


def _pierced(corners: Array, edges: Array, faces: Array) -> bool:
    """Whether any edge goes through the other triangle of its pair."""
    normal = cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0])
    heights = np.einsum("nki,ni->nk", corners - faces[:, :1], normal)
    ends = heights[:, _NEXT]
    crosses = heights * ends < 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        where = np.where(crosses, heights / (heights - ends), 0.0)
    points = corners + where[..., np.newaxis] * edges
    return bool((crosses & _held(points, faces, normal)).any())


def _held(points: Array, faces: Array, normal: Array) -> NDArray[np.bool_]:
    """(n, k): whether points (n, k, 3) of each triangle's plane lie within it."""
    inward = cross(normal[:, np.newaxis], faces[:, _NEXT] - faces)
    offset = points[:, :, np.newaxis] - faces[:, np.newaxis]
    return np.all(np.einsum("nkei,nei->nke", offset, inward) >= 0.0, axis=2)


def _dot(a: Array, b: Array) -> Array:
    return (a * b).sum(axis=-1)


def _radii(corners: Array, centres: Array) -> Array:
    away = corners - centres[:, np.newaxis]
    return np.sqrt(np.einsum("nei,nei->ne", away, away).max(axis=1, initial=0.0))
