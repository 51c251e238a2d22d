"""Gives back the names that old scripts use and newer NumPy versions dropped, where they are missing.

Sources: NumPy release notes 1.24 (``np.int`` and the other aliases of Python's types, deprecated since 1.20)
and 2.0 (the migration guide's list of removed members), 2.4 (``np.trapz``, ``np.in1d``).
"""

from __future__ import annotations

import warnings
from types import ModuleType

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
}


def give_back_aliases(numpy: ModuleType) -> None:
    """Add the missing names to the imported module; what is there stays as it is."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # merely asking for a dropped name warns
        missing = {name for name in (*PYTHON_TYPES, *RENAMED, "NINF") if not hasattr(numpy, name)}
    for name in missing:
        if name in PYTHON_TYPES:
            setattr(numpy, name, PYTHON_TYPES[name])
        elif name == "NINF":
            setattr(numpy, name, -numpy.inf)
        elif hasattr(numpy, RENAMED[name]):
            setattr(numpy, name, getattr(numpy, RENAMED[name]))
