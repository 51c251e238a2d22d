"""Convex solids that collide in place of a mesh: MuJoCo's geoms are convex.

A mesh is cut into its unconnected parts. A convex one collides itself, a flat one as thin solids behind its surface.
Any other one that

* is closed and consists of boxes, or is an outline with a height: as these boxes or columns, which fill it exactly
* is static: as thin solids behind its surface
* is closed and moves: as convex parts by a library, when that is installed
* moves, and has few flat sides: as thin solids behind them; else as its convex hull
"""

from __future__ import annotations

import math
import sys
from typing import Any, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.scene.formats.vrep.conversion.geometry.topology import (
    Faces,
    Points,
    area_vectors,
    connected,
    is_closed,
    is_convex,
    normals_of,
    sound,
    thickness,
    volume_of,
    welded,
)
from simx_server.scene.formats.vrep.objects import Leaf

from .boxes import as_boxes
from .decomposition import Budget, decompose
from .extrusions import as_columns
from .facets import facets_of
from .prisms import DEEPEST, SHEET, prisms
from .simplifying import simplified

_FLAT = 1e-4
"""Thickness, in sizes of a mesh, up to which it is flat."""

_PLAIN = (1e-3, 1e3, 1e-2)
"""Sizes in metres between which, and a thickness in sizes from which on, points surely have a hull."""

_FULL = 0.9
"""Part of its convex hull's volume from which on a moving mesh collides as the hull: V-REP's bevels and grooves."""

_NEARLY_ALL = 0.999
"""The same of a static one, whose grooves cost little."""

MOST_STATIC = 2000
"""Most convex solids of one static leaf; a mesh that needs more is simplified."""

_MOST_FACES = 40_000
"""Most faces of a static leaf that is tried without being simplified."""

MOST_MOVING = 32
"""Most convex solids of one moving part, unless no better ones are known."""

MOST_PARTS = 256
"""Most unconnected parts of one moving leaf, and most solids of one of them; one with more collides as its hull."""


class Form(NamedTuple):
    """The solids that collide in place of a mesh."""

    solids: list[Points]
    """(n, 3) points of each convex solid, in the leaf's frame."""
    is_exact: bool
    """Whether they fill it exactly enough; if not, some are hulls."""
    moved: float = 0.0
    """Metres by which the surface was moved at most, to simplify it."""


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


def solids_of(leaf: Leaf, *, moves: bool, label: str = "", budget: Budget | None = None) -> Form:
    """Return the convex solids that collide in place of a mesh that is flat, or not convex.

    Args:
        moves: something moves the mesh. Solids of a static one cost little, so it may have many.
        label: what messages call the mesh.
        budget: the work for the meshes of its file.
    """
    faces = leaf.triangles[sound(leaf.vertices, leaf.triangles)]
    number = connected(leaf.vertices, faces)
    count = int(number.max(initial=-1)) + 1
    if moves:
        if count > MOST_PARTS:
            return Form([_used(leaf.vertices, faces)], is_exact=False)
        found = [_moving(leaf.vertices, faces[number == each], label, budget) for each in range(count)]
        return Form([one for each in found for one in each.solids], all(each.is_exact for each in found))
    solids: list[Points] = []
    for each in range(count if count <= MOST_STATIC and len(faces) <= _MOST_FACES else 0):
        solids += _static(leaf.vertices, faces[number == each])
        if len(solids) > MOST_STATIC:
            break
    if 0 < len(solids) <= MOST_STATIC:
        return Form(solids, is_exact=True)
    points, fewer, moved = simplified(leaf.vertices, faces, MOST_STATIC)
    return Form(_behind(points, fewer, deepest=max(moved, SHEET)), is_exact=True, moved=moved)


def _static(points: Points, faces: Faces) -> list[Points]:
    """Return the solids of a part that nothing moves: exactly its form."""
    plain = _plain(points, faces, _NEARLY_ALL)
    if plain is not None:
        return plain
    if not is_closed(points, faces):
        return _behind(points, faces)
    body = _outwards(points, faces)
    return as_boxes(*body) or as_columns(*body) or _behind(*body)


def _moving(points: Points, faces: Faces, label: str, budget: Budget | None) -> Form:
    """Return the solids of a part that moves: few, for each meets many others."""
    plain = _plain(points, faces, _FULL)
    if plain is not None:
        return Form(plain, is_exact=True)
    exact: list[Points] | None = None
    if is_closed(points, faces):
        body = _outwards(points, faces)
        exact = as_boxes(*body) or as_columns(*body)
        if exact is not None and len(exact) <= MOST_MOVING:
            return Form(exact, is_exact=True)
        parts = decompose(*body, label, budget=budget)
        if parts is not None:
            return Form(parts, is_exact=True)
    if exact is None and len(faces) <= MOST_PARTS:
        exact = _behind(points, faces, most=MOST_MOVING)
    if exact and len(exact) <= MOST_PARTS:
        return Form(exact, is_exact=True)
    return Form([_used(points, faces)], is_exact=False)


def _plain(points: Points, faces: Faces, share: float) -> list[Points] | None:
    """Return the solids of a part that is flat, or convex; None for any other.

    Args:
        share: part of its convex hull from which on it counts as convex.
    """
    used = _used(points, faces)
    if is_flat(used):
        return _sheets(points, faces)
    if is_convex(points, faces) or _fills_its_hull(points, faces, share):
        return [used]
    return None


def _sheets(points: Points, faces: Faces) -> list[Points]:
    """Return solids with a flat mesh as their front: below it, seen from where most of its faces look."""
    points, faces = welded(*_compact(points, faces))
    middle, across, _ = thickness(points)
    looking = normals_of(points, faces) @ across
    if (looking * np.linalg.norm(area_vectors(points, faces), axis=1)).sum() < 0:
        across, looking = -across, -looking
    faces = np.where(looking[:, np.newaxis] < 0, faces[:, ::-1], faces)
    _, once = np.unique(np.sort(faces, axis=1), axis=0, return_index=True)
    flat = (points - np.outer((points - middle) @ across, across)).astype(np.float32)
    faces = faces[np.sort(once)]
    return prisms(facets_of(flat, faces[sound(flat, faces)]), flat, faces, is_closed=False)


def _behind(points: Points, faces: Faces, most: int = sys.maxsize, deepest: float = DEEPEST) -> list[Points]:
    """Return solids behind each facet of a surface; none where there are more."""
    facets = facets_of(points, faces)
    if len(facets) > most:
        return []
    return prisms(facets, points, faces, is_closed=is_closed(points, faces), deepest=deepest)


def _outwards(points: Points, faces: Faces) -> tuple[Points, Faces]:
    """Return a closed part alone, with faces that look outwards."""
    points, faces = welded(*_compact(points, faces))
    return points, faces if volume_of(points, faces) > 0 else np.ascontiguousarray(faces[:, ::-1])


def has_hull(points: Points) -> bool:
    """Return whether MuJoCo finds the convex hull of points. Only those of an odd form are tried."""
    size = float(np.ptp(points, axis=0).max())
    is_plain = _PLAIN[0] < size < _PLAIN[1] and thickness(points)[2] > _PLAIN[2] * size
    return is_plain or _hull_volume(points) < math.inf


def _fills_its_hull(points: Points, faces: Faces, share: float) -> bool:
    """Return whether a closed mesh fills this share of its convex hull."""
    if not is_closed(points, faces):
        return False
    return abs(volume_of(points, faces)) >= share * _hull_volume(_used(points, faces))


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
