"""Draw bars as a small PNG."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from .bars import Bar, Bars

WIDTH, LINE, TOP, LEFT, RIGHT = 900, 22, 34, 300, 110
OURS, THEIRS, INK, GRID = (180, 90, 20), (170, 170, 170), (60, 60, 60), (228, 228, 228)
"""Colours, BGR."""


def draw_bars(folder: Path, bars: Bars) -> Path:
    """Write the image into a folder, which is made if it is missing.

    Raises:
        OSError: it could not be written.
    """
    picture = np.vstack([_draw_group(title, group) for title, group in bars.groups])
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{bars.name}.png"
    few = (picture // 16 * 17).astype(np.uint8)
    if not cv2.imwrite(str(path), few, [cv2.IMWRITE_PNG_COMPRESSION, 9]):
        raise OSError(f"the image could not be written to {path}")
    return path


def _draw_group(title: str, bars: Sequence[Bar]) -> NDArray[np.uint8]:
    picture = np.full((TOP + LINE * len(bars) + 8, WIDTH, 3), 255, np.uint8)
    low = 10.0 ** math.floor(math.log10(min(bar.value for bar in bars)))
    high = 10.0 ** math.ceil(math.log10(max(bar.value for bar in bars) * 1.0001))
    span = math.log10(high / low)

    def across(value: float) -> int:
        return LEFT + round(math.log10(value / low) / span * (WIDTH - LEFT - RIGHT))

    power = low
    while power <= high * 1.01:
        cv2.line(picture, (across(power), TOP - 6), (across(power), picture.shape[0] - 4), GRID, 1)
        power *= 10
    _write(picture, title, (LEFT, 20), 0.0, 0.5)
    for place, bar in enumerate(bars):
        y = TOP + place * LINE
        cv2.rectangle(
            picture,
            (LEFT, y + 3),
            (max(LEFT + 2, across(bar.value)), y + LINE - 4),
            OURS if bar.is_ours else THEIRS,
            -1,
        )
        _write(picture, bar.name, (LEFT - 8, y + 15), 1.0)
        _write(picture, f"{bar.value:.3g}", (max(LEFT + 2, across(bar.value)) + 6, y + 15), 0.0)
    return picture


def _write(
    picture: NDArray[np.uint8], text: str, at: tuple[int, int], align: float, size: float = 0.42
) -> None:
    font = cv2.FONT_HERSHEY_SIMPLEX
    (width, _), _ = cv2.getTextSize(text, font, size, 1)
    cv2.putText(picture, text, (at[0] - round(align * width), at[1]), font, size, INK, 1, cv2.LINE_AA)
