"""Filters that find something: they return the numbers of V-REP's packets, and change the work image."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from . import image_filters as filters
from . import image_findings as findings
from .work import View, Work


@dataclass(frozen=True)
class Wanted:
    """A bright patch that a sensor detects: each number within its tolerance. Shares of the image, radians."""

    proportion: float
    proportion_tolerance: float
    x: float
    x_tolerance: float
    y: float
    y_tolerance: float
    angle: float
    angle_tolerance: float
    roundness: float
    """Greatest roundness."""

    def is_met_by(self, found: findings.Patch) -> bool:
        """Return whether a patch is as wanted; angles are compared modulo a turn."""
        turn = (self.angle - found.angle + math.pi) % (2 * math.pi) - math.pi
        return (
            abs(self.proportion - found.proportion) < self.proportion_tolerance
            and abs(self.x - found.x) < self.x_tolerance
            and abs(self.y - found.y) < self.y_tolerance
            and abs(turn) < self.angle_tolerance
            and found.roundness <= self.roundness
        )


def find_patch(
    work: Work, threshold: float, wanted: Wanted, overlay: list[float] | None = None
) -> tuple[bool, list[float]]:
    """Make bright pixels white and others black.

    Args:
        threshold: least intensity of a bright pixel.
        wanted: the patch to detect.
        overlay: colour of a cross and an axis over the image, None for none.

    Returns:
        Whether the bright pixels are as wanted; share of the image, x, y, angle, roundness.
    """
    bright = filters.intensity(work.image) >= threshold
    found = findings.patch(bright)
    work.image = filters.as_grey(bright.astype(float))
    if overlay and found.proportion:
        work.image = findings.with_axis(work.image, found, overlay)
    return wanted.is_met_by(found), [found.proportion, found.x, found.y, found.angle, found.roundness]


def find_blobs(
    work: Work, threshold: float, least_size: float, paint_apart: bool, overlay: list[float] | None = None
) -> list[float]:
    """Find connected bright pixels.

    Args:
        threshold: least intensity of a bright pixel.
        least_size: share of the image that a blob has at least.
        paint_apart: the image becomes the blobs in separate colours; else smaller blobs become black.
        overlay: colour of rectangles over the image, None for none.

    Returns:
        The number of blobs, 6, and the six numbers of each.
    """
    bright = filters.intensity(work.image) >= threshold
    found = findings.blobs(bright, least_size)
    if paint_apart:
        work.image = findings.painted_apart(found, work.image.shape)
    else:
        stays = ~bright
        for blob in found:
            stays[blob.pixels] = True
        work.keep(stays, False)
    if overlay:
        work.image = findings.with_rectangles(work.image, found, overlay)
    return [len(found), 6, *(number for blob in found for number in blob.numbers)]


def find_changes(work: Work, threshold: float) -> list[float]:
    """Find pixels that changed against buffer 2, which then holds what to compare the next image with."""
    packet, work.image, work.buffer2 = findings.changes(work.image, work.buffer2, threshold)
    return packet


def find_coordinates(
    work: Work, view: View, count: tuple[int, int], even_angles: bool
) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
    """Return points and pixels of a work image that holds the depth, as `image_findings.coordinates`."""
    return findings.coordinates(
        filters.intensity(work.image),
        view.clip,
        view.half,
        count,
        is_perspective=view.is_perspective,
        even_angles=even_angles and view.is_perspective,
    )


def scan(work: Work, view: View, count: tuple[int, int], angle: float) -> NDArray[np.float64]:
    """Return the points that a rotating laser scanner meets in a work image that holds the depth.

    Unlike in `find_coordinates`, a row of points lies on a cone: it has one elevation.

    Args:
        count: points across the whole view, and rows.
        angle: between the lowest and the highest row, radians.

    Returns:
        (points, 4): x, y, z in the sensor's frame and the distance, metres; from right to left in the image, the
            lowest row first. Where nothing is met, or beside the image, the distance is that of the far plane.
    """
    depth = filters.intensity(work.image)
    height, width = depth.shape
    reach = math.atan(view.half[0]) if view.is_perspective else 0.0
    azimuth, elevation = (
        each.ravel() for each in np.meshgrid(_even(count[0], 2 * reach), _even(count[1], angle))
    )
    x, y = np.tan(azimuth), np.tan(elevation) / np.cos(azimuth)
    shares = [np.divide(part, half) for part, half in zip((x, y), view.half, strict=True)]
    within = (np.abs(shares[0]) <= 1.0 + 1e-9) & (np.abs(shares[1]) <= 1.0 + 1e-9)
    columns, rows = (
        np.clip((0.5 + sign * share / 2) * (pixels - 0.5), 0, pixels - 1).astype(np.intp)
        for share, pixels, sign in zip(shares, (width, height), (-1, 1), strict=True)
    )
    near, far = view.clip
    slant = np.sqrt(1.0 + x * x + y * y)
    distance = np.where(within, (near + depth[rows, columns] * (far - near)) * slant, far)
    distance = np.minimum(distance, far)
    along = distance / slant
    return np.stack([x * along, y * along, along, distance], axis=1)


def _even(count: int, angle: float) -> NDArray[np.float64]:
    """Return angles over a whole angle around 0; a single one is in the middle."""
    return np.zeros(1) if count == 1 else np.linspace(-angle / 2, angle / 2, count)


def packet_of(count: Sequence[int], points: NDArray[np.float64]) -> list[float]:
    """Return the packet of points: how many across and up, then x, y, z and the distance of each."""
    return [*count, *points.ravel().tolist()]
