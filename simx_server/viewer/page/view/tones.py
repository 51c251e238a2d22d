"""Colours and strengths of light with which a browser shows what MuJoCo draws.

MuJoCo multiplies light with the numbers of a screen's colours. three.js computes physical amounts, and viser's canvas
then maps them to a screen by a film's curve (ACES), which darkens and fades colours. The inverse of that curve gives
the amounts: a surface in full light has the colour that the scene's cameras see, and so have grey ones in half light.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageFilter

_EXPOSURE = 1 / 0.6
_INTO_FILM = np.array([[0.59719, 0.35458, 0.04823], [0.076, 0.90834, 0.01566], [0.0284, 0.13383, 0.83777]])
_OUT_OF_FILM = np.array(
    [[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]]
)
"""The curve, as three.js has it: a matrix, (x² + a x - b) / (c x² + d x + e) for each part, another matrix."""
_A, _B, _C, _D, _E = 0.0245786, 0.000090537, 0.983729, 0.4329510, 0.238081

_DIMMED = 0.12
"""Share of its light that white lacks on the screen, and dark colours less: the curve never reaches white itself."""

_GREY = 0.65
_LUT = 17
"""Colours along an edge of the cube in which those of an image are looked up."""


def linear(screen: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return physical amounts for numbers of a screen's colours (sRGB), 0..1."""
    return np.where(screen <= 0.04045, screen / 12.92, ((screen + 0.055) / 1.055) ** 2.4)


def screen(amounts: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return numbers of a screen's colours (sRGB) for physical amounts, 0..1."""
    return np.where(
        amounts <= 0.0031308, amounts * 12.92, 1.055 * np.maximum(amounts, 0) ** (1 / 2.4) - 0.055
    )


def before_film(shown: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the light (..., 3) that the film's curve turns into these physical amounts of a screen, below 0.9."""
    y = np.clip(shown @ np.linalg.inv(_OUT_OF_FILM).T, 0.0, 0.9)
    p, q, r = 1 - _C * y, _A - _D * y, -(_B + _E * y)
    x = (-q + np.sqrt(q * q - 4 * p * r)) / (2 * p)
    return np.maximum(x @ np.linalg.inv(_INTO_FILM).T / _EXPOSURE, 0.0)


FULL = float(before_film(np.full(3, 1 - _DIMMED)).mean())
"""Full light: in it a white surface is as bright as the film's curve allows."""


def albedo(rgb: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the material's physical colour (..., 3), 0..1, for one of MuJoCo's, 0..1."""
    shown = linear(np.clip(rgb, 0.0, 1.0))
    return np.minimum(before_film(shown * (1 - _DIMMED * shown.max(axis=-1, keepdims=True))) / FULL, 1.0)


def light(strength: float) -> float:
    """Return the physical strength of a light of MuJoCo's, 1 for full light."""
    grey = linear(np.array([_GREY * min(strength, 1 / _GREY), _GREY]))
    there, full = before_film(np.repeat(grey[:, None], 3, axis=1))[:, 0]
    return FULL * float(there / full)


def paper(image: Image.Image) -> Image.Image:
    """Return an image whose colours are those of a material in a browser, without transparency."""
    table = ImageFilter.Color3DLUT.generate(_LUT, _as_texture)
    return image.convert("RGB").filter(table)


def _as_texture(red: float, green: float, blue: float) -> tuple[float, float, float]:
    """Return the number of a texture, which a browser takes as a screen's, for a colour of MuJoCo's."""
    r, g, b = screen(albedo(np.array([red, green, blue]))).tolist()
    return r, g, b
