"""Draws how a loss fell and a share rose, with OpenCV, which is there anyway."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
import pictures

WIDTH, HEIGHT = 900, 420
LEFT, RIGHT, TOP, BOTTOM = 60, 60, 45, 45
INK, GRID, LOSS, SHARE = (60, 60, 60), (225, 225, 225), (190, 90, 20), (20, 110, 180)
"""Colours, RGB."""


def draw(path: Path, losses: Sequence[float], shares: Sequence[float], title: str) -> None:
    """Write a PNG: losses with their own scale at the left, shares 0..1 at the right, one of each per epoch."""
    drawn = np.full((HEIGHT, WIDTH, 3), 255, np.uint8)
    top = max(losses) * 1.05

    def place(epoch: float, height: float) -> tuple[int, int]:
        across = (epoch - 1) / max(len(losses) - 1, 1)
        return round(LEFT + across * (WIDTH - LEFT - RIGHT)), round(
            HEIGHT - BOTTOM - height * (HEIGHT - TOP - BOTTOM)
        )

    def text(words: str, at: tuple[int, int], colour: tuple[int, int, int] = INK) -> None:
        cv2.putText(drawn, words, at, cv2.FONT_HERSHEY_SIMPLEX, 0.45, colour, 1, cv2.LINE_AA)

    for share in np.linspace(0, 1, 6):
        cv2.line(drawn, place(1, share), place(len(losses), share), GRID, 1)
        text(f"{share * top:.2f}", (12, place(1, share)[1] + 5), LOSS)
        text(f"{share:.1f}", (WIDTH - RIGHT + 10, place(1, share)[1] + 5), SHARE)
    for values, scale, colour in ((losses, top, LOSS), (shares, 1.0, SHARE)):
        points = np.array([place(epoch, value / scale) for epoch, value in enumerate(values, 1)], np.int32)
        cv2.polylines(drawn, [points], isClosed=False, color=colour, thickness=2, lineType=cv2.LINE_AA)
    text(title, (LEFT, 28))
    text("loss", (12, 28), LOSS)
    text("mAP50", (WIDTH - RIGHT + 2, 28), SHARE)
    text(f"{len(losses)} epochs", (WIDTH // 2 - 30, HEIGHT - 15))
    pictures.write(path, drawn)
