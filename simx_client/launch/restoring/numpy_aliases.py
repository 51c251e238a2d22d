"""Restore names that old scripts use and newer NumPy versions removed.

Sources: NumPy release notes 1.24 (``np.int`` and the other aliases of Python's types, deprecated since 1.20)
and 2.0 (the migration guide's list of removed members), 2.4 (``np.trapz``, ``np.in1d``).
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from types import ModuleType
from typing import Any

from .keywords import calling

PYTHON_TYPES: dict[str, type] = {
    "bool": bool,
    "int": int,
    "float": float,
    "complex": complex,
    "object": object,
    "str": str,
    "long": int,
    "unicode": str,
}

RENAMED = {
    "float_": "float64",
    "complex_": "complex128",
    "longfloat": "longdouble",
    "singlecomplex": "complex64",
    "cfloat": "complex128",
    "clongfloat": "clongdouble",
    "string_": "bytes_",
    "unicode_": "str_",
    "Inf": "inf",
    "Infinity": "inf",
    "infty": "inf",
    "PINF": "inf",
    "NaN": "nan",
    "NAN": "nan",
    "product": "prod",
    "cumproduct": "cumprod",
    "sometrue": "any",
    "alltrue": "all",
    "row_stack": "vstack",
    "round_": "round",
    "trapz": "trapezoid",
    "in1d": "isin",
    "mat": "asmatrix",
    "bool8": "bool_",
    "int0": "intp",
    "uint0": "uintp",
    "object0": "object_",
    "rank": "ndim",
}

EXCEPTIONS = ("VisibleDeprecationWarning", "ComplexWarning", "RankWarning", "AxisError", "TooHardError")
"""Members of numpy.exceptions that were members of numpy."""

OTHERS: dict[str, Callable[[Any], Any]] = {
    "NINF": lambda numpy: -numpy.inf,
    "math": lambda numpy: math,
    "asscalar": lambda numpy: calling("item"),
    "asfarray": lambda numpy: _asfarray(numpy),
}
"""Functions that make a member from the module, by name."""


def _asfarray(numpy: Any) -> Callable[..., Any]:
    def asfarray(a: Any, dtype: Any = float) -> Any:
        return numpy.asarray(a, dtype)

    return asfarray


def give_back_aliases(numpy: ModuleType) -> None:
    """Add the missing names to the imported module; existing ones stay unchanged."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # reading a removed name warns
        missing = {
            name for name in (*PYTHON_TYPES, *RENAMED, *OTHERS, *EXCEPTIONS) if not hasattr(numpy, name)
        }
    for name in missing:
        if name in PYTHON_TYPES:
            setattr(numpy, name, PYTHON_TYPES[name])
        elif name in OTHERS:
            setattr(numpy, name, OTHERS[name](numpy))
        else:
            owner = getattr(numpy, "exceptions", None) if name in EXCEPTIONS else numpy
            new = RENAMED.get(name, name)
            if hasattr(owner, new):
                setattr(numpy, name, getattr(owner, new))
