"""The 15 numbers that a vision sensor reports of an image, and whether it detects something."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from simx_server.scene.cameras.image import NO_CODE, CameraImage, depth_as_grey, grey

from .vision_settings import Verdict, VisionSettings

if TYPE_CHECKING:
    from .filters.chain import Processed


def statistics(image: CameraImage, shows_depth: bool) -> list[float]:
    """Return the 15 numbers of V-REP's first auxiliary packet."""
    import cv2  # large, and few servers have an image judged

    assert image.depth is not None
    pixels = shown(image, shows_depth)
    # Whole channels are much faster than every third byte.
    channels = [grey(pixels), *cv2.split(pixels)]
    depth = image.depth
    least = [*(int(channel.min()) / 255 for channel in channels), float(depth.min())]
    greatest = [*(int(channel.max()) / 255 for channel in channels), float(depth.max())]
    means = [int(channel.sum(dtype=np.int64)) // channel.size / 255 for channel in channels]
    # Double precision: a large image's sum would lose digits in single.
    return [*least, *greatest, *means, float(depth.mean(dtype=np.float64))]


def _handles_in(image: CameraImage) -> list[float]:
    """Return the handles in an image, in order; V-REP adds a half so that rounding down cannot change them."""
    import cv2

    assert image.rgb is not None
    pixels = cv2.cvtColor(image.rgb, cv2.COLOR_RGB2RGBA).view("<u4").ravel()
    # Most pixels equal the one before.
    firsts = pixels[np.flatnonzero(pixels[1:] != pixels[:-1]) + 1]
    codes = np.unique(np.append(firsts, pixels[0])) & NO_CODE
    return [code + 0.5 for code in codes.tolist() if code != NO_CODE]


_MEAN_INTENSITY = 10
"""Index of the mean intensity in the 15 numbers."""


def judged(
    settings: VisionSettings,
    image: CameraImage,
    shows_depth: bool,
    verdict: Verdict | None = None,
    processed: Processed | None = None,
) -> tuple[bool, list[list[float]]]:
    """Return whether the sensor detects, and the packets: first the statistics, then those of the chain.

    It detects when all limits that are set are met, or when its chain detects. A script's verdict replaces both, and
    its packets follow.
    """
    if settings.shows_handles:
        seen = [_handles_in(image)]
        return (False, seen) if verdict is None else (bool(verdict.detects), [*seen, *verdict.packets])
    numbers = statistics(image, shows_depth) if settings.needs_statistics else []
    intensity = numbers[_MEAN_INTENSITY] if numbers else 0.0
    above, below = settings.detect_above, settings.detect_below
    detects = (
        (above is not None or below is not None)
        and (above is None or intensity > above)
        and (below is None or intensity < below)
    )
    packets = [numbers if settings.has_statistics else []]
    if processed is not None:
        detects |= processed.detects
        packets += processed.packets
    if verdict is not None:
        detects = detects if verdict.detects is None else verdict.detects
        packets += verdict.packets
    return detects, packets


def shown(image: CameraImage, shows_depth: bool) -> np.ndarray:
    """Return (h, w, 3) uint8: the sensor's image."""
    if shows_depth:
        assert image.depth is not None
        return depth_as_grey(image.depth)
    assert image.rgb is not None
    return image.rgb
