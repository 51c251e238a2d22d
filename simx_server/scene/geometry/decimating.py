"""Coarser meshes, by the library fast-simplification, which is an extra."""

from __future__ import annotations

import importlib
import importlib.util
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from simx_client.protocol.cli.installing import extra_line
from simx_server.errors import CommandError

MOST_TRIANGLES = 200_000
"""Of a mesh; each takes about 5 us."""


@cache
def is_available() -> bool:
    """Return whether the library is installed."""
    return importlib.util.find_spec("fast_simplification") is not None


def decimated(
    points: NDArray[np.float64], faces: NDArray[np.int64], share: float
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return a mesh with a share of the triangles of another one, which looks alike.

    Equal points count as one; edges that only one triangle has stay, so a mesh with many of them keeps more triangles.

    Args:
        points: (n, 3).
        faces: (m, 3) indices of points.
        share: above 0, up to 1.

    Raises:
        CommandError: the mesh or the share is not valid, nothing would be left, or the library is not installed.
    """
    if not 0.0 < share <= 1.0:
        raise CommandError(f"the share of triangles that stay is above 0, up to 1, not {share:g}")
    if not 0 < len(faces) <= MOST_TRIANGLES:
        raise CommandError(f"a mesh has 1 to {MOST_TRIANGLES} triangles, not {len(faces)}")
    if faces.min() < 0 or faces.max() >= len(points):
        raise CommandError(f"a triangle's corners are indices from 0 to {len(points) - 1} here")
    if not is_available():
        raise CommandError(
            f"a coarser mesh needs a library that is not installed: {extra_line('decimation')}"
        )
    library: Any = importlib.import_module("fast_simplification")
    ids, place = np.unique(faces, return_inverse=True)
    used, number = np.unique(points[ids], axis=0, return_inverse=True)
    corners = number.reshape(-1)[place].reshape(-1, 3).astype(np.int32)
    corners = corners[(corners != np.roll(corners, 1, axis=1)).all(axis=1)]
    if not len(corners):
        raise CommandError("the mesh has no triangle with three different corners")
    found, left = library.simplify(used, corners, 1.0 - share)
    if not len(left):
        raise CommandError(f"nothing would be left of {len(corners)} triangles; let a greater share stay")
    return np.asarray(found, np.float64), np.asarray(left, np.int64)
