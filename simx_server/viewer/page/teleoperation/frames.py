"""Directions of an operator in the world: as the view shows them, or along the arm's base."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from simx_server.scene.poses.poses import Quaternion, matrix, normalised

from .browser_input import Input

Axes = NDArray[np.float64]
"""(3, 3): the columns forward, left and up."""

_LEVEL = 0.2
"""Least length of a level direction: below, the camera looks straight down or up."""


def axes_of_base(xyzw: Sequence[float]) -> Axes:
    """Return the axes of an arm's base: x is forward."""
    x, y, z, w = xyzw
    return np.array(matrix(normalised((w, x, y, z))))


def axes_of_view(wxyz: Quaternion) -> Axes:
    """Return level axes as a camera sees them: forward leads away from it.

    Args:
        wxyz: orientation of the camera: z looks ahead, y points down.
    """
    frame = np.array(matrix(normalised(wxyz)))
    forward = frame[:, 2] * (1, 1, 0)
    if np.linalg.norm(forward) < _LEVEL:
        forward = -frame[:, 1] * (1, 1, 0) * (1 if frame[2, 2] < 0 else -1)
    forward /= np.linalg.norm(forward)
    up = np.array((0.0, 0.0, 1.0))
    return np.stack((forward, np.cross(up, forward), up), axis=1)


def twist(wish: Input, axes: Axes, speed: float, turn: float) -> list[float]:
    """Return the velocity in the world that an operator wants: m/s along, and rad/s about its axes."""
    return [*(speed * (axes @ np.array(wish.way))).tolist(), *(turn * (axes @ np.array(wish.turn))).tolist()]
