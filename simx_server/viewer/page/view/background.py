"""The background of the 3-D view: the colours of the scene's skybox, or a light sky for a scene without one."""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

from .materials import pixels_of

_SKY, _HORIZON = np.array([0.72, 0.80, 0.88]), np.array([0.93, 0.95, 0.97])
"""RGB 0..1 above and below, for scenes without a skybox."""

_HEIGHT = 128
_SIDES = (4, 5, 0, 1)
"""Of a skybox's six images, one below another, those around the viewer; the third is the one above."""
_ABOVE = 2

_HIGH = 0.0
"""Place of the background's upper edge in an image of the skybox, 0 its upper edge (45 degrees), 0.5 the horizon."""


def background(model: mujoco.MjModel) -> NDArray[np.uint8]:
    """Return an image of the sky, (height, 2, 3): one colour for each row, since a browser's camera turns before it."""
    found = np.flatnonzero(model.tex_type == int(mujoco.mjtTexture.mjTEXTURE_SKYBOX.value))
    colours = _plain() if not found.size else _of_skybox(pixels_of(model, int(found[0])))
    return np.repeat((255 * colours).round().astype(np.uint8)[:, None], 2, axis=1)


def _plain() -> NDArray[np.float64]:
    down = np.linspace(0.0, 1.0, _HEIGHT)[:, None] ** 0.7
    return (1 - down) * _SKY + down * _HORIZON


def _of_skybox(pixels: NDArray[np.uint8]) -> NDArray[np.float64]:
    """Return the mean colours of the skybox from some height down to the horizon, (height, 3), 0..1."""
    size = pixels.shape[1]
    images = [pixels[first : first + size] for first in range(0, pixels.shape[0], size)]
    around = [images[side] for side in _SIDES if side < len(images)] or images
    rows: NDArray[np.float64] = np.mean(np.stack(around), axis=(0, 2)) / 255
    if len(images) > _ABOVE:
        above = images[_ABOVE].mean(axis=(0, 1)) / 255
        if np.linalg.norm(rows[-1] - above) < np.linalg.norm(rows[0] - above):
            rows = rows[::-1]
    places = np.linspace(_HIGH, 0.5, _HEIGHT) * (size - 1)
    numbers = np.arange(size, dtype=float)
    parts: list[NDArray[np.float64]] = [np.interp(places, numbers, rows[:, part]) for part in range(3)]
    return np.column_stack(parts)
