"""Compare two forms of one scene: which of their numbers and texts differ."""

from __future__ import annotations

from typing import Any, cast

import mujoco
import numpy as np
from numpy.typing import NDArray

_ROUNDED = 1e-6
"""Largest difference of numbers in single precision: files count coordinates of textures from the other side."""

_NOT_COMPARED = (
    "name_", "names", "text_", "bvh_", "mesh_pathadr", "hfield_pathadr", "tex_pathadr", "paths", "tex_colorspace",
)  # fmt: skip
"""Beginnings of the names of arrays about texts and files, and of those that follow from others."""


def differing_arrays(model: mujoco.MjModel, other: mujoco.MjModel) -> list[str]:
    """Return the names of the arrays of numbers that differ, sorted."""
    found: list[str] = []
    for name in dir(model):
        array: Any = None if name.startswith(("_", *_NOT_COMPARED)) else getattr(model, name)
        if isinstance(array, np.ndarray) and not _are_equal(
            cast("NDArray[Any]", array), getattr(other, name)
        ):
            found.append(name)
    return found


def differing_texts(spec: mujoco.MjSpec, other: mujoco.MjSpec) -> list[str]:
    """Return the names of the texts that differ, or that only one has, sorted."""
    first, second = ({text.name: text.data for text in each.texts} for each in (spec, other))
    return sorted(name for name in first.keys() | second.keys() if first.get(name) != second.get(name))


def _are_equal(array: NDArray[Any], other: NDArray[Any]) -> bool:
    if array.shape != other.shape:
        return False
    if array.dtype == np.float32:
        return bool(np.allclose(array, other, rtol=_ROUNDED, atol=_ROUNDED, equal_nan=True))
    return np.array_equal(array, other)
