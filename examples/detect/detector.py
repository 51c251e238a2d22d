"""A small YOLO: one look at the picture, one grid of cells, and no anchors. Needs PyTorch.

The picture is made 160 x 120. Seven convolutions make a grid of 20 x 15 cells of it. Each cell says whether the middle
of a ball lies in it, where in the cell, and how large the ball's box is.
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from pictures import CameraImage, shrunk
from torch import Tensor, nn
from torch.nn import functional

SIZE = 160, 120
"""Width and height that every picture is made to, pixels."""
STRIDE = 8
"""Pixels of these that a cell is wide and high."""
USUAL = 0.1
"""Share of the picture that a box of which nothing is known yet is wide and high."""

OVERLAP = 0.5
"""Two boxes that overlap by more are the same thing: intersection over union."""


class Detector(nn.Module):
    """Pictures (n, 3, 120, 160), 0..1, to (n, 5, 15, 20): presence, x, y, width, height of each cell, all raw.

    x and y are in cells from the cell's middle; width and height are logarithms of multiples of USUAL.
    """

    def __init__(self, channels: int = 48) -> None:
        super().__init__()
        widths = (3, 16, 32, channels)
        layers = [_layer(*pair, stride=2) for pair in pairwise(widths)]
        layers += [_layer(channels, channels, stride=1) for _ in range(4)]
        self.features = nn.Sequential(*layers)
        self.head = nn.Conv2d(channels, 5, 1)
        # At first no cell believes in a ball: almost none has one.
        self.head.bias = nn.Parameter(torch.tensor([-4.0, 0.0, 0.0, 0.0, 0.0]))

    def forward(self, pictures: Tensor) -> Tensor:
        return self.head(self.features(pictures))

    def save(self, path: Path) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        torch.save(self.state_dict(), path)

    @classmethod
    def load(cls, path: Path) -> Detector:
        """Weights that `save` wrote. Raises OSError."""
        detector = cls()
        detector.load_state_dict(torch.load(path, weights_only=True))
        return detector.eval()

    @torch.inference_mode()
    def detect(self, picture: CameraImage, threshold: float) -> NDArray[np.float64]:
        """(things, 5): left, top, right, bottom in the picture's pixels, and how sure it is, 0..1; the surest first."""
        height, width = picture.shape[:2]
        (found,) = boxes_of(self(as_tensor(shrunk(picture, SIZE)[np.newaxis])), threshold)
        return found * (width, height, width, height, 1.0)


def _layer(incoming: int, outgoing: int, stride: int) -> nn.Sequential:
    convolution = nn.Conv2d(incoming, outgoing, 3, stride, padding=1, bias=False)
    return nn.Sequential(convolution, nn.BatchNorm2d(outgoing), nn.SiLU())


def as_tensor(pictures: CameraImage) -> Tensor:
    """(n, height, width, 3) bytes to (n, 3, height, width), 0..1."""
    return torch.from_numpy(pictures).permute(0, 3, 1, 2).float() / 255  # as they lie: channels last


def loss_of(output: Tensor, labels: list[NDArray[np.float64]]) -> Tensor:
    """How wrong the cells are: about presence, and, where there is something, about its box.

    Args:
        labels: for each picture (things, 4): x, y of the middle, width, height; 0..1.
    """
    count, _, rows, columns = output.shape
    present, counts = torch.zeros(count, rows, columns), torch.ones(count, rows, columns)
    where, wanted = [], []
    for picture, things in enumerate(labels):
        for x, y, width, height in things:
            column, row = min(int(x * columns), columns - 1), min(int(y * rows), rows - 1)
            # The cells around the right one are nearly right: they learn the same box, so that it does not matter which
            # of them believes in it, and are not told whether to believe.
            for near in range(max(row - 1, 0), min(row + 2, rows)):
                for beside in range(max(column - 1, 0), min(column + 2, columns)):
                    where.append((picture, near, beside))
                    offset = x * columns - beside - 0.5, y * rows - near - 0.5
                    wanted.append((*offset, np.log(width / USUAL), np.log(height / USUAL)))
                    counts[picture, near, beside] = 0
            present[picture, row, column] = 1
    counts[present > 0] = 1
    doubt = (
        functional.binary_cross_entropy_with_logits(output[:, 0], present, counts, reduction="sum") / count
    )
    if not where:
        return doubt
    pictures, at_rows, at_columns = torch.tensor(where).T
    boxes = output[pictures, 1:, at_rows, at_columns]
    return doubt + 4.0 * functional.smooth_l1_loss(boxes, torch.tensor(wanted).float(), beta=0.1)


def boxes_of(output: Tensor, threshold: float) -> list[NDArray[np.float64]]:
    """For each picture (things, 5): left, top, right, bottom (0..1) and presence; overlapping ones only once."""
    rows, columns = output.shape[2:]
    row, column = torch.meshgrid(torch.arange(rows), torch.arange(columns), indexing="ij")
    x, y = (column + 0.5 + output[:, 1]) / columns, (row + 0.5 + output[:, 2]) / rows
    half = output[:, 3:].clamp(-4.0, 2.5).exp() * USUAL / 2
    edges = (x - half[:, 0], y - half[:, 1], x + half[:, 0], y + half[:, 1])
    every = torch.stack([*(edge.clamp(0, 1) for edge in edges), output[:, 0].sigmoid()], dim=3).flatten(1, 2)
    return [_without_doubles(found[found[:, 4] >= threshold]) for found in every.double().numpy()]


def _without_doubles(boxes: NDArray[np.float64]) -> NDArray[np.float64]:
    """The surest of each group that overlaps: non-maximum suppression."""
    left = boxes[np.argsort(-boxes[:, 4])]
    kept = []
    while len(left):
        first, others = left[0], left[1:]
        kept.append(first)
        left = others[overlaps(first, others) <= OVERLAP]
    return np.array(kept).reshape(-1, 5)


def overlaps(box: NDArray[np.float64], others: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n,): intersection over union of a box with others (n, 4 or more): left, top, right, bottom."""
    low, high = np.maximum(box[:2], others[:, :2]), np.minimum(box[2:4], others[:, 2:4])
    shared = np.prod(np.clip(high - low, 0, None), axis=1)
    areas = np.prod(others[:, 2:4] - others[:, :2], axis=1)
    return shared / np.maximum(np.prod(box[2:4] - box[:2]) + areas - shared, 1e-12)
