"""Candidates for the nearest point of a triangle within a volume, in closed form.

All functions return points (n, m, 3) of the planes of n triangles. Points that do not exist are nan; the points are
not checked to lie within the volume, and only those of edges surely lie within their triangle.
"""

from __future__ import annotations

import numpy as np

from .seen import Triangles, cross
from .volume import Array, Sweep, Volume


def edge_points(volume: Volume, triangles: Triangles) -> Array:
    """Return (n, 3 m, 3): nearest points and ends of the edges, and where they cross the volume's surfaces."""
    corners, edges, along = triangles.corners, triangles.edges, triangles.along
    count = len(corners)
    crossings = volume.crossings(corners.reshape(-1, 3), edges.reshape(-1, 3)).reshape(count, 3, -1)
    crossings = np.where((crossings >= 0.0) & (crossings <= 1.0), crossings, np.nan)
    where = np.concatenate([along[..., np.newaxis], np.zeros((count, 3, 1)), crossings], axis=2)
    points = corners[:, :, np.newaxis] + where[..., np.newaxis] * edges[:, :, np.newaxis]
    return points.reshape(count, -1, 3)


def face_points(volume: Volume, triangles: Triangles) -> Array:
    """Return (n, m, 3) from the lines in which planes cut the volume's faces: nearest points and crossings."""
    normals, distances = volume.faces[:, :3], volume.faces[:, 3]
    heights, count = triangles.heights[:, np.newaxis], len(triangles.heights)
    cosines = triangles.normals @ normals.T
    sines2 = 1.0 - cosines * cosines
    sines2[sines2 < 1e-14] = np.nan  # parallel
    own = ((heights - distances * cosines) / sines2)[..., np.newaxis]
    other = ((distances - heights * cosines) / sines2)[..., np.newaxis]
    closest = own * triangles.normals[:, np.newaxis] + other * normals
    directions = cross(triangles.normals[:, np.newaxis], normals)
    where = volume.crossings(closest.reshape(-1, 3), directions.reshape(-1, 3))
    where = where.reshape(count, len(normals), -1, 1)
    points = closest[:, :, np.newaxis] + where * directions[:, :, np.newaxis]
    return np.concatenate([closest, points.reshape(count, -1, 3)], axis=1)


def circle_points(triangles: Triangles, height: float, radius: float, angles: Array) -> Array:
    """Return (n, m, 3): the circle in which each plane cuts a sphere; at angle 0 its point nearest to the origin.

    Angles are (m,), or (n, m) with separate ones for each plane.
    """
    centre = np.array([0.0, 0.0, height])
    away = triangles.heights - triangles.normals @ centre
    middle = centre + away[:, np.newaxis] * triangles.normals
    with np.errstate(invalid="ignore"):
        extent = np.sqrt(radius * radius - away * away)
    towards = triangles.heights[:, np.newaxis] * triangles.normals - middle
    length = np.sqrt(np.einsum("ni,ni->n", towards, towards))
    any_direction = triangles.corners[:, 1] - triangles.corners[:, 0]
    towards = np.where(length[:, np.newaxis] > 1e-9, towards, any_direction)
    towards /= np.sqrt(np.einsum("ni,ni->n", towards, towards))[:, np.newaxis]
    across = cross(triangles.normals, towards)
    along, aside = np.cos(angles)[..., np.newaxis], np.sin(angles)[..., np.newaxis]
    ring = along * towards[:, np.newaxis] + aside * across[:, np.newaxis]
    return middle[:, np.newaxis] + extent[:, np.newaxis, np.newaxis] * ring


def line_points(triangles: Triangles, sweep: Sweep, angles: Array) -> Array:
    """Return (n, m, 3): where lines of a sweep cross each triangle's plane; angles are (m,), or (n, m) per plane."""
    starts, ends = sweep.lines(angles)
    directions = ends - starts
    normals = triangles.normals[:, np.newaxis]
    with np.errstate(divide="ignore", invalid="ignore"):
        where = (triangles.heights[:, np.newaxis] - (normals * starts).sum(axis=2)) / (
            normals * directions
        ).sum(axis=2)
    where = np.where((where >= 0.0) & (where <= 1.0), where, np.nan)
    return starts + where[..., np.newaxis] * directions
