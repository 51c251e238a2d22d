"""Load the compiled module, or find out why rays are computed in Python."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from types import ModuleType

import numpy as np

from simx_server.compiled import Form, form_without_mujoco

VARIABLE = "SIMX_FIRST_HIT"
"""Environment variable: ``python`` leaves the compiled module unused, to compare the two forms."""

SOURCE = Path(__file__).with_name("_first_hit.c")

_TRIED = 100
"""Products of random numbers that are compared: two ways of rounding give the same for half of them or less."""


def compiled_module() -> ModuleType | None:
    """Return the compiled module, `_first_hit.pyi`; None where rays are computed in Python."""
    return form().module


def form() -> Form:
    """Return the form that is used now, and why."""
    found = form_without_mujoco(SOURCE, __package__, VARIABLE)
    if found.module is not None and sums_of_numpy(found.module) is None:
        return Form(None, "NumPy sums products here in a way that the compiled module does not know")
    return found


@cache
def sums_of_numpy(module: ModuleType) -> tuple[int, int] | None:
    """Return how NumPy rounds sums of products on this processor, for `Surfaces`; None: unknown."""
    a, b = np.random.default_rng(0).normal(size=(2, _TRIED, 3, 3))
    pairs = list(zip(a, b, strict=True))
    products = (  # as in first_hit.py: of a matrix that is turned over, and of a list of matrices
        np.stack([one.T.copy().T @ other for one, other in pairs]),
        np.concatenate([one[np.newaxis] @ other for one, other in pairs]),
    )
    rows = zip(a.reshape(-1, 1, 3), b.reshape(-1, 1, 3), strict=True)
    sums = (
        np.stack([np.einsum("ni,ni->n", *pair) for pair in pairs]),
        np.concatenate([np.einsum("ni,ni->n", *pair) for pair in rows]).reshape(-1, 3),
    )
    found = {module.ways(a, b, product, total) for product in products for total in sums}
    return found.pop() if len(found) == 1 else None
