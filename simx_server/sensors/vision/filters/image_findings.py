"""Image analysis: a bright patch, blobs, changes, the positions of pixels.

Images are as in `image_filters.py`; positions are shares of width and height from the lower left corner, angles
radians.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from .image_filters import Image, Mask, as_grey, intensity

_COLOURS = np.array([[1, 0, 0], [0, 1, 0], [1, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1], [1, 1, 1]], float)
"""Colours of separately painted blobs, in turn."""

MOST_BLOBS = 10_000
"""Most blobs of an image, which take about 0.3 s: an image of noise can have hundreds of thousands."""

_EVEN_DARKNESS = 0.001
"""Intensity that replaces black when a change is compared with the previous value."""


@dataclass(frozen=True)
class Patch:
    """All bright pixels together."""

    proportion: float
    """Share of the image, 0..1."""
    x: float
    y: float
    """Centre of mass."""
    angle: float
    """Angle of the longest axis, from -pi/2 to pi/2; 0 when there is none."""
    roundness: float
    """Minimum moment of inertia over the maximum: 1 for a disc, 0 for a line."""


def patch(bright: Mask) -> Patch:
    """Return the moments of a mask; for an empty one half a pixel from the corner, as in V-REP."""
    height, width = bright.shape
    rows, columns = np.nonzero(bright)
    if not len(rows):
        return Patch(0.0, 0.5 / width, 0.5 / height, 0.0, 1.0)
    x, y = float(columns.mean()), float(rows.mean())
    across, up = columns - x, rows - y
    xx, yy, xy = float((across**2).sum()), float((up**2).sum()), float((across * up).sum())
    spread = math.hypot(2 * xy, xx - yy)
    is_round = spread == 0.0
    return Patch(
        proportion=len(rows) / bright.size,
        x=x / width,
        y=y / height,
        angle=0.0 if is_round else 0.5 * math.atan2(2 * xy, xx - yy),
        roundness=1.0 if is_round else (xx + yy - spread) / (xx + yy + spread),
    )


@dataclass(frozen=True)
class Blob:
    """Bright pixels that touch, also by a corner, and the smallest rectangle around their middles."""

    size: float
    """Share of the image, 0..1."""
    angle: float
    """Angle of the rectangle's width against the rows, anticlockwise, from -78.75 to 11.25 degrees."""
    x: float
    y: float
    """The rectangle's centre."""
    width: float
    height: float
    """Sizes of the rectangle along its own axes, as shares of the image's width and height."""
    pixels: tuple[NDArray[np.intp], NDArray[np.intp]]
    """Rows and columns. A mask for each blob could take gigabytes: noise has a blob at every fourth pixel."""

    @property
    def numbers(self) -> list[float]:
        """Return the six numbers of V-REP's packet."""
        return [self.size, self.angle, self.x, self.y, self.width, self.height]


def blobs(bright: Mask, least_size: float) -> list[Blob]:
    """Return the blobs of at least a size (share of the image), of very many the largest `MOST_BLOBS`.

    They are ordered by their first pixel, from the lower left by rows.
    """
    _, labels = cv2.connectedComponents(bright.astype(np.uint8), connectivity=8)
    label_of_pixel = labels.ravel()
    counts = np.bincount(label_of_pixel)
    counts[0] = 0  # the dark pixels
    by_label = np.argsort(label_of_pixel, kind="stable")
    ends = np.cumsum(np.bincount(label_of_pixel))
    found = np.flatnonzero((counts > 0) & (counts / bright.size >= least_size))
    found = found[np.argsort(-counts[found], kind="stable")[:MOST_BLOBS]]
    pixels = [by_label[ends[label] - counts[label] : ends[label]] for label in found]
    return [_blob(places, bright.shape) for places in sorted(pixels, key=lambda places: int(places[0]))]


def _blob(places: NDArray[np.intp], shape: tuple[int, ...]) -> Blob:
    """Return the blob of pixels, given by their places in the image, row by row."""
    height, width = shape
    rows, columns = np.divmod(places, width)
    points = np.stack([columns, rows], axis=1).astype(np.float32)
    (x, y), (across, up), degrees = cv2.minAreaRect(points)
    # A rectangle can be described by either side; V-REP's search ends within this range.
    while degrees > 11.25:
        degrees, across, up = degrees - 90.0, up, across
    while degrees <= -78.75:
        degrees, across, up = degrees + 90.0, up, across
    return Blob(
        size=len(rows) / (width * height),
        angle=math.radians(degrees),
        x=(x + 0.5) / width,
        y=(y + 0.5) / height,
        width=across / width,
        height=up / height,
        pixels=(rows, columns),
    )


def painted_apart(found: list[Blob], shape: tuple[int, ...]) -> Image:
    """Return every blob in a separate colour, all else black; after each seven they get darker."""
    image = np.zeros(shape)
    for index, blob in enumerate(found):
        turn, colour = divmod(index, len(_COLOURS))
        image[blob.pixels] = _COLOURS[colour] * (0.2 + (0.6 - 0.2 * turn) % 0.8)
    return image


def with_rectangles(image: Image, found: list[Blob], colour: list[float]) -> Image:
    """Draw the rectangles over the image."""
    drawn = np.array(image, order="C")
    height, width = image.shape[:2]
    for blob in found:
        box = ((blob.x * width, blob.y * height), (blob.width * width, blob.height * height))
        corners = cv2.boxPoints((*box, math.degrees(blob.angle)))
        cv2.polylines(drawn, [corners.astype(np.int32)], True, colour)
    return drawn


def with_axis(image: Image, found: Patch, colour: list[float]) -> Image:
    """Draw a cross at the centre of mass and a line along the longest axis, the longer the less round."""
    drawn = np.array(image, order="C")
    height, width = image.shape[:2]
    middle = (round(found.x * width), round(found.y * height))
    cv2.drawMarker(drawn, middle, colour, cv2.MARKER_CROSS, 8)
    if found.roundness < 1.0:
        reach = 0.3 - 0.25 * found.roundness
        across, up = reach * width * math.cos(found.angle), reach * height * math.sin(found.angle)
        ends = [(round(middle[0] + sign * across), round(middle[1] + sign * up)) for sign in (-1, 1)]
        cv2.line(drawn, ends[0], ends[1], colour)
    return drawn


def changes(image: Image, before: Image, threshold: float) -> tuple[list[float], Image, Image]:
    """Find pixels whose intensity has changed by at least this share of its previous value.

    Returns:
        For each 1 or -1 (brighter, darker), x and y in pixels, by rows; the image of it (white, black, grey where
            nothing changed); and the image to compare the next one with.
    """
    now, then = intensity(image), intensity(before)
    difference = now - then
    changed = np.abs(difference) / np.where(then == 0.0, _EVEN_DARKNESS, then) >= threshold
    rows, columns = np.nonzero(changed)
    signs = np.where(difference[rows, columns] > 0, 1.0, -1.0)
    numbers = [float(number) for number in np.stack([signs, columns, rows], axis=1).ravel()]
    shown = np.where(changed, np.where(difference > 0, 1.0, 0.0), 0.5)
    compared = before.copy()
    compared[changed] = now[changed][:, np.newaxis]
    return numbers, as_grey(shown), compared


def coordinates(
    depth: NDArray[np.float64],
    clip: tuple[float, float],
    half: tuple[float, float],
    count: tuple[int, int],
    *,
    is_perspective: bool,
    even_angles: bool,
) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
    """Return the positions of a grid of points over a depth image (0 near .. 1 far).

    Args:
        depth: (height, width).
        clip: near and far plane, metres.
        half: half of the visible area across and up, metres: at 1 m, or anywhere if not perspective.
        count: points across and up; from right to left in the image, which is along the sensor's x axis, and
            upwards.
        is_perspective: whether the view is a perspective.
        even_angles: even steps of the angle instead of the image.

    Returns:
        (points, 4): x, y, z in the sensor's frame (z along the view) and the distance, metres, at most the far
            plane; and (points, 2): row and column of the pixel of each.
    """
    shares = [
        _shares(number, math.atan(reach), even_angles) for number, reach in zip(count, half, strict=True)
    ]
    y, x = (each.ravel() for each in np.meshgrid(shares[1], shares[0], indexing="ij"))
    height, width = depth.shape
    rows = ((0.5 + y / 2) * (height - 0.5)).astype(np.intp)
    columns = ((0.5 - x / 2) * (width - 0.5)).astype(np.intp)
    z = clip[0] + depth[rows, columns] * (clip[1] - clip[0])
    across, up = (z, z) if is_perspective else (np.ones_like(z), np.ones_like(z))
    points = np.stack([x * half[0] * across, y * half[1] * up, z], axis=1)
    distance = z
    if is_perspective:
        distance = np.linalg.norm(points, axis=1)
        points *= np.minimum(1.0, clip[1] / distance)[:, np.newaxis]
        distance = np.minimum(distance, clip[1])
    pixels = np.stack([rows, columns], axis=1)
    return np.concatenate([points, distance[:, np.newaxis]], axis=1), pixels


def _shares(count: int, half_angle: float, even_angles: bool) -> NDArray[np.float64]:
    """Return positions from -1 to 1 across the image; a single one is in the middle."""
    if count == 1:
        return np.zeros(1)
    even = np.linspace(-1.0, 1.0, count)
    return np.tan(even * half_angle) / math.tan(half_angle) if even_angles else even
