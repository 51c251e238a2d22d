"""Draws docs/pictures/camera.png, the drawing of docs/cameras.md: ``python docs/drawings.py``.

An oblique view from the right-hand side of a vision sensor: its z goes to the right, its y up, its x away from us.
"""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

FILE = Path(__file__).with_name("pictures") / "camera.png"
WIDTH, HEIGHT, SOFTER = 760, 360, 3
EYE = (90.0, 190.0)
"""Where the sensor is in the picture, pixels."""

AXES = np.array([[0.42, -0.34], [0.0, -1.0], [1.0, 0.0]]) * 100
"""Pixels to the right and down per unit of the sensor's x, y, z."""

NEAR, SURFACE, FAR = 0.9, 2.4, 4.6
HALF_X, HALF_Y = 0.33, 0.25
"""Half of what is seen at depth 1."""

RED, GREEN, BLUE, GREY, DARK = (34, 34, 204), (43, 136, 34), (204, 68, 34), (160, 150, 140), (34, 34, 34)
"""Of OpenCV: blue, green, red."""


def place(x: float, y: float, z: float) -> tuple[int, int]:
    """Sensor's frame to pixels of the large picture."""
    right, down = np.array([x, y, z]) @ AXES + EYE
    return round(right * SOFTER), round(down * SOFTER)


def section(depth: float, share: float = 1.0) -> list[tuple[int, int]]:
    """Corners of what is seen at a depth, from the first pixel, bottom left, on."""
    x, y = HALF_X * depth * share, HALF_Y * depth * share
    return [place(x, -y, depth), place(-x, -y, depth), place(-x, y, depth), place(x, y, depth)]


def draw() -> Path:
    """The picture's file."""
    picture = np.full((HEIGHT * SOFTER, WIDTH * SOFTER, 3), 255, dtype=np.uint8)

    def line(
        start: tuple[int, int], end: tuple[int, int], colour: tuple[int, int, int], width: float = 1
    ) -> None:
        cv2.line(picture, start, end, colour, round(width * SOFTER), cv2.LINE_AA)

    def text(words: str, right: float, down: float, colour: tuple[int, int, int] = DARK) -> None:
        corner = round(right * SOFTER), round(down * SOFTER)
        cv2.putText(
            picture, words, corner, cv2.FONT_HERSHEY_SIMPLEX, 0.5 * SOFTER, colour, SOFTER, cv2.LINE_AA
        )

    for depth, share, colour in (
        (FAR, 1, (250, 232, 214)),
        (SURFACE, 0.6, (176, 190, 245)),
        (NEAR, 1, (247, 222, 196)),
    ):
        corners = np.array(section(depth, share))
        cv2.fillPoly(picture, [corners], colour, cv2.LINE_AA)
        cv2.polylines(picture, [corners], True, GREY, SOFTER, cv2.LINE_AA)
    for corner in section(FAR):
        line(place(0, 0, 0), corner, GREY)
    line(place(0, 0, 0), place(0, 0, FAR), GREY)
    for words, end, colour in (
        ("+x", (0.75, 0, 0), RED),
        ("+y", (0, 0.8, 0), GREEN),
        ("+z", (0, 0, 0.75), BLUE),
    ):
        tip = place(*end)
        cv2.arrowedLine(picture, place(0, 0, 0), tip, colour, 3 * SOFTER, cv2.LINE_AA, tipLength=0.15)
        text(words, tip[0] / SOFTER + 3, tip[1] / SOFTER - 6, colour)
    cv2.circle(picture, place(0, 0, 0), 5 * SOFTER, DARK, -1, cv2.LINE_AA)
    cv2.circle(picture, section(FAR)[0], 5 * SOFTER, DARK, -1, cv2.LINE_AA)
    first = section(FAR)[0]
    text("first pixel", first[0] / SOFTER + 8, first[1] / SOFTER + 5)
    text("near: 0", 110, 262)
    text("surface: (z - near) / (far - near)", 170, 50, RED)
    text("far: 1", 515, 345)
    text("+x is left, +y up in the picture", 15, 335)
    small = cv2.resize(picture, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA)
    cv2.imwrite(str(FILE), small)
    return FILE


if __name__ == "__main__":
    draw()
