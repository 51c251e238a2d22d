"""Tasks of an agent: a scene, what it sees and sets, its reward, and how episodes start and end."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from simx_client.randomization import Distribution, Randomize

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


Drawn = Callable[[np.random.Generator], "float | Sequence[float] | NDArray[Any]"]
"""A function of the environment's random generator that returns a number or a vector."""

Start = Mapping[str, "float | Sequence[float] | NDArray[Any] | Distribution | Drawn"]
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
    randomize: Randomize | None = None
    vectorized: bool = False
    """Whether `reward` and `done` also take the states of many simulations as one, with arrays that have a row for
    each. It saves the time of calling them for each simulation.
    """

    def __post_init__(self) -> None:
        if self.frame_skip < 1:
            raise ValueError(f"frame_skip must be at least 1, not {self.frame_skip}")
        if self.time_step is not None and not 0 < self.time_step < np.inf:
            raise ValueError(f"time_step must be greater than 0 s, not {self.time_step}")

    def judge(self, now: State) -> tuple[float, bool]:
        """Return the reward of a state, and whether it ends the episode."""
        return float(self.reward(now)), self.done is not None and bool(self.done(now))

    def info_of(self, now: State) -> dict[str, Any]:
        """Return the information about a state."""
        return {} if self.info is None else self.info(now)

    def draw_start(self, random: np.random.Generator) -> dict[str, list[float]]:
        """Return the values that an episode starts with."""
        start = self.start(random) if callable(self.start) else self.start or {}
        # By name: to ask for the protocol takes longer than to draw.
        drawn: dict[str, Any] = {text: getattr(value, "draw", value) for text, value in start.items()}
        return {text: _listed(value(random) if callable(value) else value) for text, value in drawn.items()}


def _listed(value: Any) -> list[float]:
    return [value] if value.__class__ is float else np.atleast_1d(value).tolist()
