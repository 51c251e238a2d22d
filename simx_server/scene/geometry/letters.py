"""Text as a mesh: letters of small boxes, from OpenCV's own font."""

from __future__ import annotations

from itertools import groupby

import cv2
import numpy as np
from numpy.typing import NDArray

_FONT, _SCALE, _STROKE = cv2.FONT_HERSHEY_SIMPLEX, 1.5, 5
"""About 32 pixels for a capital letter: a letter takes 20 to 40 boxes."""

_LINE = 1.6
"""Distance of two lines, in heights of a capital letter."""

_THICKNESS = 0.1
"""Thickness of letters, in heights of a capital letter."""

_SIDES = ((0, 2, 1), (0, 3, 2), (4, 5, 6), (4, 6, 7), (0, 1, 5), (0, 5, 4), (1, 2, 6), (1, 6, 5), (2, 3, 7), (2, 7, 6),
          (3, 0, 4), (3, 4, 7))  # fmt: skip
"""Triangles of a box whose corners are counted round its lower side, then round its upper side."""

_Box = tuple[int, int, int, int]
"""First and last column, first and last row of pixels, the last ones excluded."""


def text_mesh(text: str, height: float, *, centred: bool) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return points (n, 3) and triangles (m, 3) of a text in the x-y plane, its lower side at z = 0.

    The first line stands on y = 0 and starts at x = 0, or has its middle there; characters other than printable
    ones of ASCII are left out.

    Args:
        text: one or more lines.
        height: of a capital letter, metres.
        centred: whether the middle of each line is at x = 0.
    """
    capital = _boxes("H")
    unit = height / (max(box[3] for box in capital) - min(box[2] for box in capital))
    ground = max(box[3] for box in capital)
    corners: list[tuple[float, float, float]] = []
    for number, line in enumerate(text.split("\n")):
        boxes = _boxes(line)
        left = min((box[0] for box in boxes), default=0)
        shift = -(left + max((box[1] for box in boxes), default=0)) / 2 if centred else -left
        fall = number * _LINE * height
        for start, stop, top, bottom in boxes:
            x = (unit * (start + shift), unit * (stop + shift))
            y = (unit * (ground - bottom) - fall, unit * (ground - top) - fall)
            for z in (0.0, _THICKNESS * height):
                corners += [(x[0], y[0], z), (x[1], y[0], z), (x[1], y[1], z), (x[0], y[1], z)]
    points = np.array(corners, dtype=np.float64).reshape(-1, 3)
    faces = np.arange(len(points) // 8)[:, None, None] * 8 + np.array(_SIDES)
    return points, faces.reshape(-1, 3)


def _boxes(line: str) -> list[_Box]:
    """Return boxes of pixels that cover a line of text; rows that are alike share theirs."""
    shown = "".join(character for character in line if " " <= character <= "~")
    (width, height), below = cv2.getTextSize(shown, _FONT, _SCALE, _STROKE)
    image = np.zeros((2 * height + 2 * below + 2 * _STROKE, width + 4 * _STROKE), np.uint8)
    ground = height + below + _STROKE
    cv2.putText(image, shown, (2 * _STROKE, ground), _FONT, _SCALE, 255, _STROKE)
    found: list[_Box] = []
    first = 0
    for runs, rows in groupby(_runs(row) for row in image > 127):
        last = first + len(list(rows))
        found += [(start, stop, first - ground, last - ground) for start, stop in runs]
        first = last
    return found


def _runs(row: NDArray[np.bool_]) -> tuple[tuple[int, int], ...]:
    """Return where the pixels of a row start and end."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], row, [False]]).astype(np.int8)))
    return tuple((int(start), int(stop)) for start, stop in zip(edges[::2], edges[1::2], strict=True))
