"""Height fields, which collide as MuJoCo's own and are drawn as meshes."""

from __future__ import annotations

from typing import Any

import numpy as np

from simx_server.scene.formats.vrep.objects import Leaf

_LEAST_HEIGHT = 1e-4
"""Least difference of heights in metres; a level field is as thick."""

_BASE = 0.1
"""Part of the larger side by which the solid below a field reaches below its lowest point."""


def add_height_field(spec: Any, leaf: Leaf, name: str) -> tuple[str, tuple[float, float, float]] | None:
    """Add a height field of a leaf; None for one that is too small, or damaged.

    Returns:
        Its name, and where its origin lies in the leaf's frame.
    """
    heights, points = leaf.heights, leaf.vertices
    if heights is None or min(heights.shape) < 2 or not np.isfinite(heights).all():
        return None
    low = np.array([-leaf.size[0] / 2, -leaf.size[1] / 2]) if not len(points) else points[:, :2].min(axis=0)
    high = -low if not len(points) else points[:, :2].max(axis=0)
    half = (high - low).astype(float) / 2
    if half.min() <= 1e-6:
        return None
    least, spread = float(heights.min()), float(np.ptp(heights))
    # The mesh may lie at another height than the numbers.
    lowest = least if not len(points) else float(points[:, 2].min())
    field = spec.add_hfield(name=name)
    field.nrow, field.ncol = heights.shape
    field.userdata = ((heights - least) / max(spread, _LEAST_HEIGHT)).astype(np.float32).ravel()
    field.size[:] = [half[0], half[1], max(spread, _LEAST_HEIGHT), _BASE * float(half.max())]
    middle = (high + low) / 2
    return name, (float(middle[0]), float(middle[1]), lowest)
