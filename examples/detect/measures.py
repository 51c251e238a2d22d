"""How good a detector is: precision, recall, and the mean average precision at an overlap of one half."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from detector import OVERLAP, overlaps
from numpy.typing import NDArray

Boxes = NDArray[np.float64]


@dataclass(frozen=True)
class Measures:
    precision: float
    """Share of what was found that is there."""
    recall: float
    """Share of what is there that was found."""
    map50: float
    """Area below the curve of precision over recall, over all thresholds. There is one class to take the mean of."""

    def __str__(self) -> str:
        return f"precision {self.precision:.3f}, recall {self.recall:.3f}, mAP50 {self.map50:.3f}"


def measure(found: Sequence[Boxes], labels: Sequence[Boxes], threshold: float) -> Measures:
    """Compare what was found with the truth.

    Args:
        found: for each picture (things, 5): left, top, right, bottom, how sure; the surest first, all thresholds.
        labels: for each picture (things, 4): x, y of the middle, width, height.
        threshold: from how sure on a thing counts for precision and recall.
    """
    sure, right = [], []
    for boxes, things in zip(found, labels, strict=True):
        truth = np.hstack([things[:, :2] - things[:, 2:] / 2, things[:, :2] + things[:, 2:] / 2])
        for box in boxes:
            shares = overlaps(box, truth)
            is_right = bool(len(shares) and shares.max() > OVERLAP)
            if is_right:  # each thing is found once; who finds it again is wrong
                truth = np.delete(truth, shares.argmax(), axis=0)
            sure.append(box[4])
            right.append(is_right)
    total = sum(len(things) for things in labels)
    order = np.argsort(-np.array(sure), kind="stable")
    hits = np.cumsum(np.array(right, dtype=float)[order])
    recalls = np.concatenate([[0.0], hits / max(total, 1)])
    precisions = np.concatenate([[1.0], hits / np.arange(1, len(hits) + 1)])
    # The curve's envelope: the best precision at this recall or a higher one.
    envelope = np.maximum.accumulate(precisions[::-1])[::-1]
    taken = int(np.sum(np.array(sure) >= threshold))
    return Measures(
        float(precisions[taken]), float(recalls[taken]), float(np.sum(np.diff(recalls) * envelope[1:]))
    )
