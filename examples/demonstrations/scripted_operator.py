"""A scripted operator: it does what a person would do with keys, and its hand trembles."""

from __future__ import annotations

import math

import numpy as np
from cell import Numbers

SPEED = 0.2
"""m/s"""

ABOVE, LAID = 0.1, 0.03
"""Metres over cube or mark at which the tip travels, and over the mark at which it lets the cube go."""

OPEN, CLOSED = 0.045, 0.01
"""Positions of the finger's joint, in metres, that count as open, and as closed on the cube."""


class Operator:
    """Decides by what it sees. The tremble is a velocity that changes slowly and is zero on average."""

    def __init__(self, seed: int, tremble: float = 0.03) -> None:
        """Make one; `tremble`: deviation of the velocity in m/s."""
        self._random = np.random.default_rng(seed)
        self._tremble, self._push = tremble, np.zeros(3)

    def __call__(self, observation: Numbers) -> tuple[Numbers, bool]:
        velocity, is_open = decide(observation)
        self._push = 0.8 * self._push + 0.6 * self._random.normal(0.0, self._tremble, 3)
        return velocity + self._push, is_open


def decide(observation: Numbers) -> tuple[Numbers, bool]:
    """Return the velocity of the tip, m/s, and whether the gripper is to be open."""
    tip, cube, mark, finger = observation[:3], observation[3:6], observation[6:9], observation[9]
    off = float(np.linalg.norm(cube - tip))
    if math.hypot(*(cube - mark)[:2]) < 0.02 and cube[2] < LAID:
        return (_towards(tip, tip + _up(ABOVE)) if finger > OPEN else np.zeros(3)), True
    if finger < CLOSED and off < 0.03:
        return _over(tip, mark, LAID), False
    is_at_cube = off < (0.008 if finger > OPEN else 0.02)
    return _over(tip, cube, 0.0), not is_at_cube


def _over(tip: Numbers, place: Numbers, height: float) -> Numbers:
    """Return the velocity to a place: up, along, and down to a height over it."""
    if math.hypot(*(place - tip)[:2]) < 0.015:
        return _towards(tip, place + _up(height))
    if tip[2] < place[2] + 0.7 * ABOVE:
        return _towards(tip, tip + _up(ABOVE))
    return _towards(tip, place + _up(ABOVE))


def _up(height: float) -> Numbers:
    return np.array((0.0, 0.0, height))


def _towards(tip: Numbers, goal: Numbers) -> Numbers:
    velocity = (goal - tip) / 0.15
    return velocity * min(1.0, SPEED / max(float(np.linalg.norm(velocity)), 1e-9))
