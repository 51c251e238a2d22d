"""Collects the returns of episodes, and draws how they grew, with OpenCV, which is there anyway."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from stable_baselines3.common.callbacks import BaseCallback

WIDTH, HEIGHT = 900, 500
LEFT, RIGHT, TOP, BOTTOM = 80, 25, 50, 60
INK, GRID, DOT, LINE = (60, 60, 60), (225, 225, 225), (215, 190, 160), (180, 90, 20)
"""Colours, BGR."""

PROGRESS_EVERY = 4_000
"""Steps between two lines of progress."""

WINDOW = 5
"""Rounds of the running mean; in a round all simulators end an episode."""


class Episodes(BaseCallback):
    """The returns of all episodes of a training, and the number of steps when each ended."""

    def __init__(self) -> None:
        super().__init__()
        self.steps: list[int] = []
        self.returns: list[float] = []

    def _on_step(self) -> bool:
        for info in self.locals["infos"]:
            if episode := info.get("episode"):
                self.steps.append(self.num_timesteps)
                self.returns.append(float(episode["r"]))
        if self.returns and self.num_timesteps % PROGRESS_EVERY == 0:
            print(
                f"{self.num_timesteps} steps, return of the last episodes {np.mean(self.returns[-20:]):.1f}"
            )
        return True


def draw(path: Path, steps: Sequence[int], returns: Sequence[float], title: str) -> None:
    """Write a PNG: one dot an episode, and their running mean.

    Args:
        steps: environment steps at each episode's end.
        returns: the sum of each episode's rewards.
    """
    picture = np.full((HEIGHT, WIDTH, 3), 255, dtype=np.uint8)
    x_ticks, y_ticks = _ticks(0, max(steps)), _ticks(min(returns), max(*returns, 0.0))

    def place(step: float, value: float) -> tuple[int, int]:
        across = (step - x_ticks[0]) / (x_ticks[-1] - x_ticks[0])
        up = (value - y_ticks[0]) / (y_ticks[-1] - y_ticks[0])
        return round(LEFT + across * (WIDTH - LEFT - RIGHT)), round(
            HEIGHT - BOTTOM - up * (HEIGHT - TOP - BOTTOM)
        )

    for tick in y_ticks:
        cv2.line(picture, place(x_ticks[0], tick), place(x_ticks[-1], tick), GRID, 1)
        _write(picture, f"{tick:g}", (LEFT - 10, place(0, tick)[1] + 5), align=1.0)
    for tick in x_ticks:
        cv2.line(picture, place(tick, y_ticks[0]), place(tick, y_ticks[-1]), GRID, 1)
        _write(picture, f"{tick:,.0f}", (place(tick, 0)[0], HEIGHT - BOTTOM + 22), align=0.5)
    for step, value in zip(steps, returns, strict=True):
        cv2.circle(picture, place(step, value), 2, DOT, -1, cv2.LINE_AA)
    rounds = sorted(set(steps))
    means = [
        np.mean([value for step, value in zip(steps, returns, strict=True) if step == end]) for end in rounds
    ]
    window = min(WINDOW, len(rounds))
    smooth = np.convolve(means, np.ones(window) / window, "valid")
    points = np.array(
        [place(*point) for point in zip(rounds[window - 1 :], smooth, strict=True)], dtype=np.int32
    )
    cv2.polylines(picture, [points], isClosed=False, color=LINE, thickness=2, lineType=cv2.LINE_AA)
    _write(picture, title, (LEFT, 30), align=0.0)
    _write(picture, "environment steps", ((WIDTH + LEFT) // 2, HEIGHT - 12), align=0.5)
    path.parent.mkdir(parents=True, exist_ok=True)
    if not cv2.imwrite(str(path), picture):
        raise OSError(f"the picture could not be written to {path}")


def _ticks(low: float, high: float) -> NDArray[np.float64]:
    """Four to ten round numbers around a range."""
    size = 10.0 ** np.floor(np.log10(max(high - low, 1e-9)))
    size = next(each for each in (size / 5, size / 2, size, size * 2) if (high - low) / each <= 8)
    return np.arange(np.floor(low / size), np.ceil(high / size) + 1) * size


def _write(picture: NDArray[np.uint8], text: str, at: tuple[int, int], *, align: float) -> None:
    """Text whose left edge (0), middle (0.5) or right edge (1) is at a place."""
    font, scale = cv2.FONT_HERSHEY_SIMPLEX, 0.5
    (width, _), _ = cv2.getTextSize(text, font, scale, 1)
    cv2.putText(picture, text, (at[0] - round(align * width), at[1]), font, scale, INK, 1, cv2.LINE_AA)
