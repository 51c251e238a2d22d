"""Tasks of an agent: a scene, what it sees and sets, its reward, and how episodes start and end."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .actions import How
from .observations import Observed


class State(dict[str, Any]):
    """Values by name after a step: a float, a vector (float64) or an image (uint8).

    Names are those of the observations and measures: ``now["Target.position in kinect_rgb"]``.
    """

    action: Any = None
    """The action that led here; None at the start of an episode."""

    before: State | None = None
    """The state before that action; None at the start of an episode."""


@dataclass(frozen=True)
class Uniform:
    """A number or vector drawn for each episode, uniformly from ``low`` to ``high``."""

    low: float | Sequence[float]
    high: float | Sequence[float]

    def __post_init__(self) -> None:
        low, high = np.asarray(self.low, np.float64), np.asarray(self.high, np.float64)
        if not (np.isfinite(low).all() and np.isfinite(high).all() and (low <= high).all()):
            raise ValueError(f"Uniform needs finite low <= high, not {self.low!r} and {self.high!r}")

    def draw(self, random: np.random.Generator) -> Any:
        """Return a number or a vector."""
        return random.uniform(self.low, self.high)


Drawn = Callable[[np.random.Generator], "float | Sequence[float] | NDArray[Any]"]
"""A function of the environment's random generator that returns a number or a vector."""

Start = Mapping[str, "float | Sequence[float] | NDArray[Any] | Uniform | Drawn"]
"""Values that are set at the start of an episode, by name, in this order."""


@dataclass(frozen=True, kw_only=True)
class Task:
    """A task; `SimxEnv` describes the fields."""

    scene: str | os.PathLike[str] | None = None
    observations: Observed | Mapping[str, Observed]
    actions: Mapping[str, How]
    reward: Callable[[State], float]
    done: Callable[[State], bool] | None = None
    start: Start | Callable[[np.random.Generator], Start] | None = None
    measures: Sequence[str] = ()
    info: Callable[[State], dict[str, Any]] | None = None
    time_step: float | None = None
    frame_skip: int = 1
    camera: str | None = None

    def __post_init__(self) -> None:
        if self.frame_skip < 1:
            raise ValueError(f"frame_skip must be at least 1, not {self.frame_skip}")
        if self.time_step is not None and not 0 < self.time_step < np.inf:
            raise ValueError(f"time_step must be greater than 0 s, not {self.time_step}")

    def draw_start(self, random: np.random.Generator) -> dict[str, list[float]]:
        """Return the values that an episode starts with."""
        start = self.start(random) if callable(self.start) else self.start or {}
        drawn = {text: value.draw if isinstance(value, Uniform) else value for text, value in start.items()}
        return {
            text: np.atleast_1d(value(random) if callable(value) else value).tolist()
            for text, value in drawn.items()
        }
