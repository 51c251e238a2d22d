"""Images of all directions, made of the images of six sensors: which pixel of which sensor each pixel shows."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

FRONT, TOP, BACK, BOTTOM, LEFT, RIGHT = range(6)
"""The sensors in V-REP's order."""

_AXES = {
    FRONT: ((0, -1, 0), (0, 0, 1)),
    TOP: ((0, -1, 0), (-1, 0, 0)),
    BACK: ((0, -1, 0), (0, 0, -1)),
    BOTTOM: ((0, -1, 0), (1, 0, 0)),
    LEFT: ((1, 0, 0), (0, 0, 1)),
    RIGHT: ((-1, 0, 0), (0, 0, 1)),
}
"""Directions of the columns and rows of each sensor's image; x is to the front, y to the left, z up."""


@dataclass(frozen=True, eq=False)
class SphericalMap:
    """The pixels that an image of all directions shows, rows bottom first."""

    sensor: NDArray[np.int8]
    """(height, width) sensor."""
    row: NDArray[np.int32]
    column: NDArray[np.int32]
    """(height, width) pixel of that sensor."""
    lengthening: NDArray[np.float32]
    """(height, width) factor from the depth of a pixel, along the view of its sensor, to what V-REP shows."""


@lru_cache(maxsize=4)
def spherical_map(width: int, height: int, side: int, across: float, up: float) -> SphericalMap:
    """Return the map, with V-REP's directions: columns run from the right to the left of the front.

    Args:
        width: of the image in pixels.
        height: of the image.
        side: width and height of the sensors' images.
        across: angle from the first to the last column, radians.
        up: angle from the first to the last row.
    """
    around = np.linspace(-across / 2, across / 2, width) if width > 1 else np.zeros(1)
    raised = np.linspace(-up / 2, up / 2, height) if height > 1 else np.zeros(1)
    azimuth, elevation = np.meshgrid(around, raised)
    x, y = np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation)
    directions = np.stack([x, y, np.sin(elevation)], axis=-1)
    sizes = np.abs(directions)
    directions /= sizes.max(axis=-1, keepdims=True)
    axis = sizes.argmax(axis=-1)  # of equal ones the first
    ahead = np.take_along_axis(directions, axis[..., np.newaxis], axis=-1)[..., 0] >= 0
    sensor = np.choose(
        axis, [np.where(ahead, FRONT, BACK), np.where(ahead, LEFT, RIGHT), np.where(ahead, TOP, BOTTOM)]
    )
    columns, rows = (np.array([_AXES[each][part] for each in range(6)], float) for part in (0, 1))
    right = np.einsum("hwi,hwi->hw", directions, columns[sensor])
    above = np.einsum("hwi,hwi->hw", directions, rows[sensor])
    column, row = (
        np.clip(((each + 1) / 2 * side - 0.5).astype(np.int32), 0, side - 1) for each in (right, above)
    )
    lengthening = np.sqrt(1 + right * right) * np.sqrt(1 + above * above)
    return SphericalMap(sensor.astype(np.int8), row, column, lengthening.astype(np.float32))
