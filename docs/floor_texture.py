"""Draws scenes/parts/floor_tiles.png, the floor of the shipped scenes: ``python docs/floor_texture.py``.

One metre of a floor of half-metre tiles in two greys, with stains as of concrete. The stains are noise of waves that
fit into the metre, so they go on without a seam where the texture is repeated. The picture is the same each time.
"""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

FILE = Path(__file__).parents[1] / "scenes" / "parts" / "floor_tiles.png"
SIZE = 512
"""Pixels along the metre."""

LIGHT, DARK = (0.900, 0.890, 0.857), (0.826, 0.812, 0.774)
"""Mean colours of the tiles: red, green, blue from 0 to 1."""

DEVIATION = 2.9
"""Standard deviation of the stains in grey levels of the texture; the scene's light leaves 2.5 of them."""

LONGEST, SHORTEST = 2, 60
"""Waves along the metre of the widest stain and of the finest grain."""


def stains() -> NDArray[np.float64]:
    """(SIZE, SIZE) grey levels with mean 0; large stains are stronger than small ones, dark ones than light ones."""
    random = np.random.default_rng(2019)
    waves = np.hypot(*np.meshgrid(*[np.fft.fftfreq(SIZE, 1 / SIZE)] * 2))
    strength = np.where((waves >= LONGEST) & (waves <= SHORTEST), np.maximum(waves, 1.0) ** -1.4, 0.0)
    noise = np.fft.ifft2(np.fft.fft2(random.standard_normal((SIZE, SIZE))) * strength).real
    noise /= noise.std()
    noise -= 0.2 * noise**2
    noise -= noise.mean()
    return DEVIATION * noise / noise.std()


def texture() -> NDArray[np.uint8]:
    """(SIZE, SIZE, 3) red, green, blue; the first and the last quadrant are light tiles."""
    row, column = np.indices((SIZE, SIZE)) * 2 // SIZE
    tiles = np.where(((row + column) % 2 == 0)[:, :, None], LIGHT, DARK) * 255
    return np.clip(np.rint(tiles + stains()[:, :, None]), 0, 255).astype(np.uint8)


if __name__ == "__main__":
    cv2.imwrite(str(FILE), texture()[:, :, ::-1], [cv2.IMWRITE_PNG_COMPRESSION, 9])
    print(f"{FILE}: {FILE.stat().st_size // 1024} kB")
