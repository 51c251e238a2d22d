"""Indices that are adjacent: a view of an array costs less than its items."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def as_slice(indices: NDArray[np.intp]) -> slice | None:
    """Return a slice of the same items in the same order; None if they are not adjacent, or there are none."""
    if not indices.size or np.any(np.diff(indices) != 1):
        return None
    return slice(int(indices[0]), int(indices[-1]) + 1)
