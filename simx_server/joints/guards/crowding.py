"""Detect too many overlapping shapes, since MuJoCo tests every pair of them in an uninterruptible physics step.

Physics keeps shapes apart. Hundreds in the same place come from copies, files and positions that were set.
"""

from __future__ import annotations

from typing import NamedTuple

import mujoco
import numpy as np

FEW = 400
"""Number of shapes whose pairs are not counted, as that would cost more than a physics step: 80,000 pairs at most."""

_AT_ONCE = 1 << 18
"""Number of pairs that are compared at once."""


class _Boxes(NamedTuple):
    """Boxes around shapes in the world's frame, in metres: arrays of shape (n, 3)."""

    low: np.ndarray
    high: np.ndarray

    def chosen(self, which: np.ndarray) -> _Boxes:
        return _Boxes(self.low[which], self.high[which])


def is_crowded(model: mujoco.MjModel, data: mujoco.MjData, most: int) -> bool:
    """Return whether the boxes of more than `most` pairs of colliding shapes overlap.

    One shape of each pair can move. Shapes of one body and of neighbouring links are counted too, because there are
    few.

    Args:
        model: the compiled model.
        data: its state, with fresh kinematics.
        most: number of pairs above which the scene counts as crowded.
    """
    # Planes have no bounds, and MuJoCo compares each shape with them once.
    geoms = np.flatnonzero(((model.geom_contype | model.geom_conaffinity) != 0) & (model.geom_rbound > 0))
    moves = model.body_weldid[model.geom_bodyid[geoms]] != 0
    movers = int(moves.sum())
    if len(geoms) <= FEW or movers * len(geoms) <= most:
        return False
    turn = data.geom_xmat[geoms].reshape(-1, 3, 3)
    centre = data.geom_xpos[geoms] + np.einsum("nij,nj->ni", turn, model.geom_aabb[geoms, :3])
    half = np.einsum("nij,nj->ni", np.abs(turn), model.geom_aabb[geoms, 3:])
    boxes = _Boxes(centre - half, centre + half)
    moving, fixed = boxes.chosen(moves), boxes.chosen(~moves)
    found = _pairs_among(moving, most)
    return found > most or found + _pairs_between(moving, fixed, most - found) > most


def _pairs_among(boxes: _Boxes, most: int) -> int:
    """Return the number of overlapping pairs; counting stops beyond `most`."""
    # Use the axis on which the fewest overlap: from each box to the boxes that start before it ends.
    orders = [np.argsort(boxes.low[:, axis], kind="stable") for axis in range(3)]
    following = [_following(boxes.chosen(order), axis) for axis, order in enumerate(orders)]
    axis = int(np.argmin([counts.sum() for counts in following]))
    boxes, counts = boxes.chosen(orders[axis]), following[axis]
    found = first = 0
    while first < len(counts) and found <= most:
        last = first + max(1, int(np.searchsorted(np.cumsum(counts[first:]), _AT_ONCE)))
        some = counts[first:last]
        one = np.repeat(np.arange(first, first + len(some)), some)
        other = one + 1 + np.arange(len(one)) - np.repeat(np.cumsum(some) - some, some)
        found += int(_overlap(boxes.chosen(one), boxes.chosen(other)).sum())
        first = last
    return found


def _pairs_between(boxes: _Boxes, others: _Boxes, most: int) -> int:
    """Return the number of overlapping pairs between two sets; counting stops beyond `most`."""
    found = 0
    size = max(1, _AT_ONCE // max(1, len(others.low)))
    for first in range(0, len(boxes.low), size):
        some = _Boxes(boxes.low[first : first + size, None], boxes.high[first : first + size, None])
        found += int(_overlap(some, others).sum())
        if found > most:
            break
    return found


def _following(boxes: _Boxes, axis: int) -> np.ndarray:
    """Return for each box how many others start after it and before it ends; boxes are in order of their start."""
    low, high = boxes.low[:, axis], boxes.high[:, axis]
    return np.searchsorted(low, high, side="right") - np.arange(1, len(low) + 1)


def _overlap(boxes: _Boxes, others: _Boxes) -> np.ndarray:
    return np.all((boxes.low <= others.high) & (others.low <= boxes.high), axis=-1)
