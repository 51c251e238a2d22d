"""A mesh as parts, one for each material."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from simx_server.scene.formats.annotations import SceneError

MOST_TRIANGLES = 1_000_000
"""Of one mesh file."""

Rgba = tuple[float, float, float, float]


@dataclass(frozen=True)
class Look:
    """Colour and image of the triangles of one material."""

    color: Rgba | None = None
    """0..1; None: the file does not say."""
    highlights: float | None = None
    """Brightness 0..1; None: the file does not say."""
    image: str = ""
    """Name of the image file on the triangles, as the mesh file writes it; empty: none."""


@dataclass(frozen=True)
class Part:
    """The triangles of one material."""

    points: NDArray[np.float64]
    """(n, 3) in metres."""
    faces: NDArray[np.int64]
    """(m, 3) indices of points."""
    look: Look = Look()
    coordinates: NDArray[np.float32] | None = None
    """(m, 3, 2) u and v of an image at the corners, v upwards; None: the file does not say."""


def merged(parts: Iterable[Part], name: str) -> list[Part]:
    """Return parts of different looks only, without triangles that have no area.

    Args:
        parts: the pieces of a file, in its order.
        name: the file's name in errors.

    Raises:
        SceneError: the file has no triangles, or too many; a corner has no point, or a point is not finite.
    """
    groups: dict[tuple[Look, bool], list[Part]] = {}
    count = 0
    for part in parts:
        count += len(part.faces)
        if count > MOST_TRIANGLES:
            raise SceneError(f"'{name}' has more than {MOST_TRIANGLES} triangles; make it coarser")
        cleaned = _cleaned(part, name)
        if len(cleaned.faces):
            groups.setdefault((cleaned.look, cleaned.coordinates is None), []).append(cleaned)
    if not groups:
        raise SceneError(f"'{name}' has no triangles")
    return [_joined(group) for group in groups.values()]


def as_one(parts: Sequence[Part]) -> Part:
    """Return all triangles as one part, without a look."""
    return _joined([replace(part, look=Look(), coordinates=None) for part in parts])


def _cleaned(part: Part, name: str) -> Part:
    points, faces = part.points, part.faces
    if faces.size and not 0 <= faces.min() <= faces.max() < len(points):
        raise SceneError(f"'{name}' is damaged: a corner of a triangle is none of its {len(points)} points")
    used = np.unique(faces)
    if not np.isfinite(points[used]).all():
        raise SceneError(f"'{name}' is damaged: a point is not finite")
    corners = points[faces]
    sides = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    kept = np.any(sides != 0.0, axis=1)
    return replace(
        part, faces=faces[kept], coordinates=None if part.coordinates is None else part.coordinates[kept]
    )


def _joined(parts: Sequence[Part]) -> Part:
    """Return parts of the same look as one, with each point once."""
    starts = np.cumsum([0, *(len(part.points) for part in parts)])
    points = np.concatenate([part.points for part in parts])
    faces = np.concatenate([part.faces + start for part, start in zip(parts, starts[:-1], strict=True)])
    used, index = np.unique(points[faces.ravel()], axis=0, return_inverse=True)
    if len(used) < 4:  # MuJoCo takes four points at least
        used = np.vstack([used, np.repeat(used.mean(axis=0, keepdims=True), 4 - len(used), axis=0)])
    coordinates = [part.coordinates for part in parts]
    known = [each for each in coordinates if each is not None]
    return Part(
        used,
        index.reshape(-1, 3).astype(np.int64),
        parts[0].look,
        np.concatenate(known) if len(known) == len(parts) else None,
    )
