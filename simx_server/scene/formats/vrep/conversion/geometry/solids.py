"""Convex solids that collide in place of a mesh: MuJoCo's geoms are convex.

* A convex mesh collides itself.
* A flat one, and a plane or a disc, collides as a thin slab behind its surface.
* Any other is cut into its unconnected parts. One that is closed and not convex is decomposed, when the library for
  that is installed; one that is open and has a few flat sides collides as a slab behind each of them.
* What remains collides as its convex hull.
"""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.scene.formats.vrep.conversion.geometry.decomposition import decompose
from simx_server.scene.formats.vrep.conversion.geometry.topology import (
    Faces,
    Points,
    area_vectors,
    connected,
    flat_regions,
    is_closed,
    is_convex,
    normals_of,
    sound,
    thickness,
    welded,
)
from simx_server.scene.formats.vrep.objects import Leaf

_FLAT = 1e-4
"""Thickness, in sizes of a mesh, up to which it is flat."""

_PLAIN = (1e-3, 1e3, 1e-2)
"""Sizes in metres between which, and a thickness in sizes from which on, points surely have a hull."""

_FULL = 0.9
"""Part of its convex hull's volume from which on a mesh collides as the hull: V-REP's bevels and grooves."""

SLAB = 0.002
"""Thickness in metres of the slab that collides in place of a surface."""

MOST_PARTS = 256
"""Most convex solids of one leaf; a mesh with more unconnected parts collides as its hull."""

MOST_SLABS = 32
"""Most slabs of one open part; one with more flat regions collides as its hull."""


def is_flat(points: Points) -> bool:
    """Return whether points lie in a plane, or nearly so: that of three of them that lie far apart."""
    away = points - points[0]
    squares = np.einsum("ij,ij->i", away, away)
    along = away[squares.argmax()]
    across = np.cross(away, along)
    normal = across[np.einsum("ij,ij->i", across, across).argmax()]
    length = float(np.linalg.norm(normal))
    size = float(np.sqrt(squares.max()))
    return length <= _FLAT * size * size or float(np.ptp(away @ normal)) <= _FLAT * size * length


def slab(points: Points, faces: Faces) -> Points:
    """Return the points of a solid with a flat mesh as its front: below it, seen from where its faces look."""
    points, faces = _compact(points, faces)
    middle, across, _ = thickness(points)
    if (normals_of(points, faces) @ across).sum() < 0:
        across = -across
    flat = points - np.outer((points - middle) @ across, across)
    return np.concatenate([flat, flat - SLAB * across]).astype(np.float32)


def solids_of(leaf: Leaf) -> tuple[list[Points], bool]:
    """Return the points of the convex solids that collide in place of a mesh that is not convex.

    Returns:
        (n, 3) points of each, in the leaf's frame; whether they fill it exactly enough. If not, they are hulls.
    """
    faces = leaf.triangles[sound(leaf.vertices, leaf.triangles)]
    number = connected(leaf.vertices, faces)
    parts = [faces[number == each] for each in range(int(number.max(initial=-1)) + 1)]
    if len(parts) > MOST_PARTS:
        return [_used(leaf.vertices, faces)], False
    found: list[Points] = []
    is_exact = True
    for part in parts:
        points = _used(leaf.vertices, part)
        if is_flat(points):
            found.append(slab(leaf.vertices, part))
        elif is_convex(leaf.vertices, part) or _fills_its_hull(leaf.vertices, part):
            found.append(points)
        elif (several := _pieces(leaf.vertices, part)) is not None:
            found += several
        else:
            is_exact = False
            found.append(points)
    return found, is_exact


def _pieces(points: Points, faces: Faces) -> list[Points] | None:
    """Return the points of convex solids that collide in place of a part that is not convex; None: none are known."""
    if is_closed(points, faces):
        return decompose(*_compact(*welded(points, faces)))
    regions = flat_regions(points, faces, MOST_SLABS)
    return None if regions is None else [slab(points, region) for region in regions]


def has_hull(points: Points) -> bool:
    """Return whether MuJoCo finds the convex hull of points. Only those of an odd form are tried."""
    size = float(np.ptp(points, axis=0).max())
    is_plain = _PLAIN[0] < size < _PLAIN[1] and thickness(points)[2] > _PLAIN[2] * size
    return is_plain or _hull_volume(points) < math.inf


def _fills_its_hull(points: Points, faces: Faces) -> bool:
    """Return whether a closed mesh fills nearly all of its convex hull."""
    if not is_closed(points, faces):
        return False
    starts = points[faces[:, 0]] - points.mean(axis=0)
    volume = abs(float(np.einsum("ij,ij->", starts, area_vectors(points, faces)))) / 3
    return volume >= _FULL * _hull_volume(_used(points, faces))


def _hull_volume(points: Points) -> float:
    """Return the volume of the convex hull of points, m^3; infinity where MuJoCo finds none."""
    spec: Any = mujoco.MjSpec()
    mesh = spec.add_mesh(name="mesh", inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX)
    scale = 1.0 / float(np.ptp(points, axis=0).max())
    mesh.uservert = (points * scale).ravel()
    body = spec.worldbody.add_body()
    body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname="mesh", density=1.0)
    try:  # MuJoCo refuses points in a line or a plane; its library for hulls, some others
        return float(spec.compile().body_mass[1]) / scale**3
    except ValueError:
        return math.inf


def _compact(points: Points, faces: Faces) -> tuple[Points, Faces]:
    """Return a mesh without the points that no face has."""
    used, place = np.unique(faces, return_inverse=True)
    return points[used], place.reshape(-1, 3).astype(np.int32)


def _used(points: Points, faces: NDArray[np.int32]) -> Points:
    return points[np.unique(faces)]
