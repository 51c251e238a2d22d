"""Image filters: those of V-REP's vision sensors and of its vision plugin, on NumPy arrays.

An image is (height, width, 3) float64, rows bottom first, colours 0..1. Every function returns a new array. Cuts
and selections return a mask, (height, width), of the pixels that stay.
"""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.float64]
Mask = NDArray[np.bool_]

_SCALE = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]])
"""Black, blue, red, yellow: V-REP's colours of rising intensity, evenly spaced."""

SHARPEN = np.full((3, 3), -1 / 9) + np.diag([0.0, 2.0, 0.0])
EDGES = np.full((3, 3), -3.0) + np.diag([0.0, 27.0, 0.0])
"""24 in the middle and -3 around it: zero in uniform areas."""


def intensity(image: Image) -> NDArray[np.float64]:
    """Return (height, width): the mean of the three colours."""
    return (image[..., 0] + image[..., 1] + image[..., 2]) / 3.0


def as_grey(values: NDArray[np.float64]) -> Image:
    """Return an image whose three colours are these (height, width) values."""
    return np.repeat(values[..., np.newaxis], 3, axis=2)


def flipped_horizontally(image: Image) -> Image:
    """Return the image with left and right swapped."""
    return image[:, ::-1].copy()


def flipped_vertically(image: Image) -> Image:
    """Return the image with top and bottom swapped."""
    return image[::-1].copy()


def normalised(image: Image) -> Image:
    """Return the image stretched so that the minimum is 0 and the maximum 1; a uniform image stays."""
    least, greatest = float(image.min()), float(image.max())
    return image.copy() if greatest == least else (image - least) / (greatest - least)


def intensity_scaled(image: Image, start: float, end: float, grey: bool) -> Image:
    """Return the image with intensity 0..1 mapped to `start`..`end`, in grey or in the colours of V-REP's scale."""
    level = start + (end - start) * intensity(image)
    if grey:
        return as_grey(level)
    marks = np.linspace(0.0, 1.0, len(_SCALE))
    colours: list[Image] = [np.interp(level, marks, colour) for colour in _SCALE.T]
    return np.stack(colours, axis=2)


def hsl_from_rgb(image: Image) -> Image:
    """Return hue, saturation, lightness, each 0..1."""
    found = cv2.cvtColor(image.astype(np.float32), cv2.COLOR_RGB2HLS).astype(np.float64)
    return np.stack([found[..., 0] / 360.0, found[..., 2], found[..., 1]], axis=2)


def rgb_from_hsl(image: Image) -> Image:
    """Return red, green, blue, each 0..1."""
    turned = np.stack([image[..., 0] * 360.0, image[..., 2], image[..., 1]], axis=2).astype(np.float32)
    return cv2.cvtColor(turned, cv2.COLOR_HLS2RGB).astype(np.float64)


def is_coloured(image: Image, colour: list[float], tolerance: list[float], rgb: bool) -> Mask:
    """Return where every component is within its tolerance, in RGB or in HSL; the hue wraps at 1."""
    away = np.abs((image if rgb else hsl_from_rgb(image)) - np.array(colour))
    if not rgb:
        away[..., 0] = np.minimum(away[..., 0], np.abs(1.0 - away[..., 0]))
    return np.all(away <= np.array(tolerance) + 1e-6, axis=2)


def scaled_and_offset(
    image: Image, before: list[float], scale: list[float], after: list[float], rgb: bool
) -> Image:
    """Return (value + before) * scale + after for each component of RGB or HSL, kept within 0..1."""
    values = image if rgb else hsl_from_rgb(image)
    values = np.clip((values + np.array(before)) * np.array(scale) + np.array(after), 0.0, 1.0)
    return values if rgb else rgb_from_hsl(values)


def with_fewer_colours(image: Image, distance: float) -> Image:
    """Replace every pixel by the first colour, in reading order, that is nearer than `distance` in RGB."""
    pixels = image.reshape(-1, 3).copy()
    waiting = np.arange(len(pixels))
    while len(waiting):
        first, away = pixels[waiting[0]].copy(), pixels[waiting] - pixels[waiting[0]]
        near = np.einsum("ij,ij->i", away, away) < distance * distance
        near[0] = True  # whatever the distance
        pixels[waiting[near]] = first
        waiting = waiting[~near]
    return pixels.reshape(image.shape)


def convolved(image: Image, kernel: NDArray[np.float64]) -> Image:
    """Replace each pixel by the weighted sum of its neighbours; at the rim the sum is scaled up for missing ones."""
    total = cv2.filter2D(image, -1, kernel, borderType=cv2.BORDER_CONSTANT)
    present = cv2.filter2D(np.ones(image.shape[:2]), -1, np.ones_like(kernel), borderType=cv2.BORDER_CONSTANT)
    return total * (kernel.size / present)[..., np.newaxis]


def convolved_often(image: Image, numbers: NDArray[np.float64], passes: int) -> Image:
    """Replace each pixel by the weighted sum of its neighbours, several times; the result is kept within 0..1.

    `numbers`: the weights of a square, row by row.
    """
    side = math.isqrt(len(numbers))
    kernel = numbers.reshape(side, side)
    for _ in range(passes):
        image = convolved(image, kernel)
    return np.clip(image, 0.0, 1.0)


def sharpened(image: Image) -> Image:
    """Return the image with twice each pixel, less the mean around it."""
    return np.clip(convolved(image, SHARPEN), 0.0, 1.0)


def edges(image: Image, threshold: float) -> Image:
    """Return white pixels where a pixel is brighter than its neighbours by `threshold`, else black.

    24 times the pixel counts against 3 times each of its neighbours.
    """
    return as_grey((intensity(convolved(image, EDGES)) > threshold).astype(float))


def blur_kernel(side: int) -> NDArray[np.float64]:
    """Return a Gaussian with a standard deviation of 2 pixels and sum 1: V-REP's default matrix."""
    reach = np.arange(side) - side // 2
    weights = np.exp(-(reach[:, np.newaxis] ** 2 + reach**2) / 8.0)
    return weights / weights.sum()


def within_circle(shape: tuple[int, ...], radius: float) -> Mask:
    """Return a circle around the middle; `radius` 1 touches the nearer sides."""
    across, up = _from_middle(shape)
    return across**2 + up**2 <= (radius * min(shape[:2]) / 2) ** 2


def within_rectangle(shape: tuple[int, ...], width: float, height: float) -> Mask:
    """Return a rectangle around the middle; its sizes are shares of the image."""
    across, up = _from_middle(shape)
    return (np.abs(across) <= width * shape[1] / 2) & (np.abs(up) <= height * shape[0] / 2)


def shifted(image: Image, across: float, up: float, wrap: bool) -> Image:
    """Move the image by shares of width and height; with `wrap` it continues at the other side, else black follows."""
    height, width = image.shape[:2]
    columns, rows = _rounded(across * width), _rounded(up * height)
    moved = np.roll(image, (rows, columns), axis=(0, 1))
    if wrap:
        return moved
    y, x = np.mgrid[:height, :width]
    inside = (x - columns >= 0) & (x - columns < width) & (y - rows >= 0) & (y - rows < height)
    return moved * inside[..., np.newaxis]


def resized(image: Image, across: float, up: float) -> Image:
    """Stretch the image about the middle; its size stays, and black fills the rest. Factors are not 0."""
    x, y = _from_middle(image.shape)
    return _sampled(image, x / across, y / up)


def rotated(image: Image, angle: float) -> Image:
    """Rotate the image about the middle, anticlockwise as seen, by radians; black fills the corners."""
    x, y = _from_middle(image.shape)
    cosine, sine = math.cos(angle), math.sin(angle)
    return _sampled(image, x * cosine + y * sine, y * cosine - x * sine)


def _sampled(image: Image, x: NDArray[np.float64], y: NDArray[np.float64]) -> Image:
    """Return the nearest pixels at positions relative to the middle; black outside."""
    height, width = image.shape[:2]
    columns = np.floor(x + width / 2 + 1e-9).astype(int)
    rows = np.floor(y + height / 2 + 1e-9).astype(int)
    inside = (columns >= 0) & (columns < width) & (rows >= 0) & (rows < height)
    found = image[rows.clip(0, height - 1), columns.clip(0, width - 1)]
    return found * inside[..., np.newaxis]


def _from_middle(shape: tuple[int, ...]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return x and y of every pixel's middle, in pixels from the middle of the image, each (height, width)."""
    y, x = np.mgrid[: shape[0], : shape[1]]
    return x + 0.5 - shape[1] / 2, y + 0.5 - shape[0] / 2


def _rounded(number: float) -> int:
    """Round half away from zero."""
    return int(math.copysign(math.floor(abs(number) + 0.5), number))
