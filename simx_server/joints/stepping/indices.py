"""Arrays of indices. Of adjacent ones, a view of an array costs less than its items."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Columns = dict[str, NDArray[Any]]
"""Arrays of numbers (float64) and indices (intp), one item per joint: the compiled form shares them."""


def as_slice(indices: NDArray[np.intp]) -> slice | None:
    """Return a slice of the same items in the same order; None if they are not adjacent, or there are none."""
    if not indices.size or np.any(np.diff(indices) != 1):
        return None
    return slice(int(indices[0]), int(indices[-1]) + 1)
