"""The statistics by which policies normalise: of each episode, and of all of them together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

QUANTILES = (0.01, 0.10, 0.50, 0.90, 0.99)
_MOST_IMAGES = 100
"""Images of an episode that are looked at."""

Statistics = dict[str, NDArray[Any]]
"""Least, greatest, mean, deviation, count and quantiles of a feature."""


def of_numbers(rows: NDArray[Any]) -> Statistics:
    """Return the statistics of (n,) or (n, k) values, each an array of (k,)."""
    return _of(rows.reshape(len(rows), -1).astype(np.float64), len(rows))


def of_images(images: NDArray[np.uint8]) -> Statistics:
    """Return those of (n, height, width, 3) images: by colour, 0 to 1, each an array of (3, 1, 1)."""
    chosen = np.unique(np.linspace(0, len(images) - 1, min(len(images), _MOST_IMAGES)).astype(int))
    pixels = images[chosen].reshape(-1, 3) / 255.0
    found = _of(pixels, len(chosen))
    return {name: each if name == "count" else each.reshape(3, 1, 1) for name, each in found.items()}


def merged(parts: Sequence[Statistics]) -> Statistics:
    """Return the statistics of several episodes together; quantiles are the means of theirs, as LeRobot has them."""
    counts = np.array([each["count"][0] for each in parts], np.float64)
    total = counts.sum()
    shape = (-1, *[1] * parts[0]["mean"].ndim)
    weights = (counts / total).reshape(shape)

    def stacked(name: str) -> NDArray[np.float64]:
        return np.stack([each[name] for each in parts])

    mean = (weights * stacked("mean")).sum(axis=0)
    variance = (weights * (stacked("std") ** 2 + (stacked("mean") - mean) ** 2)).sum(axis=0)
    return {
        "min": stacked("min").min(axis=0),
        "max": stacked("max").max(axis=0),
        "mean": mean,
        "std": np.sqrt(variance),
        "count": np.array([int(total)]),
        **{name: (weights * stacked(name)).sum(axis=0) for name in map(_name, QUANTILES)},
    }


def as_lists(statistics: Statistics) -> dict[str, Any]:
    """Return them for JSON and Parquet."""
    return {name: each.tolist() for name, each in statistics.items()}


def _of(rows: NDArray[np.float64], count: int) -> Statistics:
    quantiles = np.quantile(rows, QUANTILES, axis=0)
    return {
        "min": rows.min(axis=0),
        "max": rows.max(axis=0),
        "mean": rows.mean(axis=0),
        "std": rows.std(axis=0),
        "count": np.array([count]),
        **{_name(share): each for share, each in zip(QUANTILES, quantiles, strict=True)},
    }


def _name(share: float) -> str:
    return f"q{round(100 * share):02d}"
