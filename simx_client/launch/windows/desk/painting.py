"""Trackbars and lines of text as pixels. Drawn here, so that they are the same with every window system."""

from __future__ import annotations

from typing import Any, cast

import cv2
import numpy as np

ROW = 28
"""Height of a trackbar or a line of text in pixels."""

_GROUND, _INK, _RAIL, _KNOB = (240, 240, 240), (30, 30, 30), (170, 170, 170), (31, 111, 139)
_SHARE = 0.42
"""Share of the width for the label."""

_MARGIN = 12


def rail(width: int) -> tuple[int, int]:
    """Return the first and last x of the slider."""
    begin = max(int(width * _SHARE), 1)
    return begin, max(begin + 1, width - _MARGIN)


def value_at(x: int, width: int, minimum: int, maximum: int) -> int:
    """Return the value of a slider at x."""
    begin, end = rail(width)
    share = min(max((x - begin) / (end - begin), 0.0), 1.0)
    return minimum + round(share * (maximum - minimum))


def text_row(width: int, text: str) -> Any:
    """Return a line of text as uint8, (ROW, width, 3)."""
    row = np.full((ROW, width, 3), _GROUND, np.uint8)
    line = text.replace("\n", " ")
    cv2.putText(row, line, (6, ROW - 9), cv2.FONT_HERSHEY_SIMPLEX, 0.45, _INK, 1, cv2.LINE_AA)
    return row


def trackbar_row(width: int, label: str, value: int, minimum: int, maximum: int) -> Any:
    """Return a trackbar: label and value at the left, slider at the right."""
    row = text_row(width, f"{label}: {value}")
    begin, end = rail(width)
    row[:, max(0, begin - 8) :] = _GROUND  # a long label ends before the slider
    knob = begin + round((end - begin) * (value - minimum) / max(1, maximum - minimum))
    cv2.line(row, (begin, ROW // 2), (end, ROW // 2), _RAIL, 3)
    cv2.line(row, (begin, ROW // 2), (knob, ROW // 2), _KNOB, 3)
    cv2.circle(row, (knob, ROW // 2), 7, _KNOB, -1, cv2.LINE_AA)
    return row


def fitted(
    image: Any, width: int, height: int, *, keeps_ratio: bool
) -> tuple[Any, tuple[int, int, int, int]]:
    """Scale an image into an area, on grey; return it with its position in the area: x, y, width, height."""
    rows, columns = image.shape[:2]
    scale_x, scale_y = width / columns, height / rows
    if keeps_ratio:
        scale_x = scale_y = min(scale_x, scale_y)
    size = max(1, round(columns * scale_x)), max(1, round(rows * scale_y))
    if size != (columns, rows):
        shrinks = scale_x < 1 or scale_y < 1
        how = cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR
        image = cast(Any, cv2.resize(image, size, interpolation=how))
    x, y = (width - size[0]) // 2, (height - size[1]) // 2
    if (x, y) == (0, 0) and size == (width, height):
        return image, (0, 0, width, height)
    area = np.full((height, width, 3), _RAIL, np.uint8)
    area[y : y + size[1], x : x + size[0]] = image
    return area, (x, y, *size)
