"""Meshes of a spec: each different one once, however many leaves have it."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from typing import Any, cast

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.scene.assets.filing import give_points
from simx_server.scene.formats.vrep.conversion.context import Conversion
from simx_server.scene.formats.vrep.conversion.unique_names import UniqueNames
from simx_server.scene.formats.vrep.objects import Leaf, TextureUse

from .corners import Surface, surface
from .texture_mapping import coordinates_of
from .topology import (
    Faces,
    Points,
    area_vectors,
    both_sides,
    sound,
)

_FEWEST_POINTS = 4
"""MuJoCo takes no mesh with fewer points."""

_LEAST_WIDTH = 1e-6
"""Width of a mesh, in parts of its length, below which it is a line."""

LEAST_EXTENT = 1e-6
"""Size in metres below which a leaf is too small for MuJoCo, and for any camera."""


@dataclass
class Meshes:
    """The meshes that a conversion has added to its spec."""

    spec: Any
    by_content: dict[bytes, str] = field(default_factory=dict[bytes, str])
    names: UniqueNames = field(default_factory=lambda: UniqueNames("{}_{}", first=1))

    @classmethod
    def of(cls, conversion: Conversion) -> Meshes:
        """Return the meshes of a conversion."""
        return conversion.part(cls, lambda: cls(conversion.spec))

    def look_of(self, leaf: Leaf, name: str, texture: TextureUse | None) -> str | None:
        """Return the mesh that draws a leaf; None for one without a visible triangle.

        Args:
            name: name of a new mesh, made unique.
            texture: how the leaf is textured, if it is.
        """
        key = _digest(leaf.vertices, leaf.triangles, leaf.normals, leaf.culls_backfaces, texture)
        if key not in self.by_content:
            made = _drawn(leaf, texture)
            if made is None:
                return None
            self.by_content[key] = self.add(made, name)
        return self.by_content[key]

    def solid(self, points: Points, name: str) -> str:
        """Return the mesh whose convex hull collides: that of (n, 3) points, which do not lie in a plane."""
        key = _digest(points)
        if key not in self.by_content:
            faces = np.zeros((0, 3), np.int32)
            self.by_content[key] = self.add(Surface(points, faces), name)
        return self.by_content[key]

    def add(self, made: Surface, name: str) -> str:
        """Add a mesh under a name like this one, which is returned."""
        unique = self.names.take(name)
        mesh = self.spec.add_mesh(name=unique)
        # The inertia of a hollow mesh exists for open and flat ones, too; bodies have their own.
        mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
        missing = max(0, _FEWEST_POINTS - len(made.points))
        # Normals and texture coordinates belong to the points, so they need no further faces.
        points, normals, texture = (
            _padded(each, missing) for each in (made.points, made.normals, made.texture)
        )
        assert points is not None
        give_points(self.spec, mesh, points, made.faces, coordinates=texture, normals=normals)
        return unique


def _drawn(leaf: Leaf, texture: TextureUse | None) -> Surface | None:
    is_sound = sound(leaf.vertices, leaf.triangles)
    chosen = slice(None) if is_sound.all() else np.flatnonzero(is_sound)
    faces = leaf.triangles[chosen]
    if not len(faces) or not _is_visible(leaf.vertices, faces):
        return None
    normals = None if leaf.normals is None else leaf.normals[chosen]
    coordinates = None if texture is None else coordinates_of(leaf, texture)[chosen]
    if not leaf.culls_backfaces:
        before = faces
        faces, source = both_sides(leaf.vertices, before)
        # A reversed face has its corners in the reverse order.
        is_reversed = faces[:, 0] != before[source, 0]
        normals, coordinates = (_of_corners(each, source, is_reversed) for each in (normals, coordinates))
    return surface(leaf.vertices, faces, normals, coordinates)


def _is_visible(points: Points, faces: Faces) -> bool:
    """Return whether a mesh is large enough, and more than a line."""
    extent = float(np.ptp(points[faces.ravel()], axis=0).max())
    area = float(np.linalg.norm(area_vectors(points, faces), axis=1).sum())
    return extent >= LEAST_EXTENT and area >= _LEAST_WIDTH * extent * extent


def _of_corners(
    values: NDArray[np.float32] | None, source: NDArray[np.intp], is_reversed: NDArray[np.bool_]
) -> NDArray[np.float32] | None:
    if values is None:
        return None
    taken = values[source]
    return np.where(is_reversed[:, np.newaxis, np.newaxis], taken[:, ::-1], taken)


def _padded(rows: NDArray[np.float32] | None, missing: int) -> NDArray[np.float32] | None:
    """Return rows of a mesh, the last one as often as MuJoCo wants more of them."""
    return (
        rows if rows is None or not missing else np.concatenate([rows, np.repeat(rows[-1:], missing, axis=0)])
    )


def _digest(*contents: object) -> bytes:
    """Return a key of arrays and of things that are compared by their text."""
    key = hashlib.blake2b(digest_size=16)
    for each in contents:
        if isinstance(each, TextureUse):
            key.update(repr((each.mode, each.scale, each.frame)).encode())
            each = each.coordinates
        if isinstance(each, np.ndarray):
            array = cast("NDArray[Any]", each)
            key.update(f"{array.dtype.str}{array.shape}".encode())
            key.update(np.ascontiguousarray(array).data)
        else:
            key.update(repr(each).encode())
    return key.digest()
