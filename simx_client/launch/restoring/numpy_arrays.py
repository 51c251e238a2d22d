"""Restore conversions of NumPy's arrays and arguments of the functions that make them.

An array of one element was accepted as a number: ``float(a)``, ``int(a)``, ``'%.2f' % a``, ``math.sin(a)``,
``b[0] = a``. NumPy 2.4 takes only arrays of no dimension (deprecated since 1.25).

Sources: NumPy release notes 1.18 (``num`` of linspace), 1.24 (ragged lists), 2.0 (``copy=False``, methods ``ptp``,
``itemset``), 2.3 (``tostring``, ``fromstring`` of bytes), 2.4 (arrays of one element).
"""

from __future__ import annotations

import functools
import warnings
from collections.abc import Callable
from types import ModuleType
from typing import Any

from simx_client.launch.after_import import Patch

from .immutable import set_attributes
from .keywords import calling, give_missing, take_old_keywords
from .numpy_aliases import give_back_aliases


def give_back_arrays(numpy: ModuleType) -> None:
    """Patch the imported module where a conversion is missing."""
    ndarray: Any = numpy.ndarray
    missing: dict[str, Callable[..., Any]] = {
        name: method for name, method in _METHODS.items() if not hasattr(ndarray, name)
    }
    if not _are_numbers(numpy.zeros(1)):
        missing |= {name: _one_element(getattr(ndarray, name), kind) for name, kind in _NUMBERS.items()}
        missing["__round__"] = _round
        missing["__complex__"] = _one_element(ndarray.__complex__, complex)
    set_attributes(ndarray, missing)
    take_old_keywords(numpy, "histogram", normed="density")
    take_old_keywords(numpy, "reshape", newshape="shape")
    for name, make in (("array", _array), ("fromstring", _fromstring), ("linspace", _linspace)):
        plain = getattr(numpy, name)
        if not hasattr(plain, "gives_back"):
            made = functools.wraps(plain)(make(numpy, plain))
            setattr(made, "gives_back", True)  # noqa: B010 - a function takes attributes, its type does not know
            setattr(numpy, name, made)


def _are_numbers(one: Any) -> bool:
    """Return whether an array of one element is accepted as a number, possibly with a deprecation warning."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            return float(one) == 0.0
        except TypeError:
            return False


def _itemset(self: Any, *args: Any) -> None:
    *place, value = args
    if len(place) == 1 and not isinstance(place[0], tuple):
        self.flat[place[0]] = value
    else:
        self[place[0] if len(place) == 1 else tuple(place) or ...] = value


def _peak_to_peak(self: Any, axis: Any = None, out: Any = None, keepdims: bool = False) -> Any:
    import numpy

    return numpy.ptp(self, axis, out, keepdims=keepdims)


_NUMBERS: dict[str, Callable[[Any], Any]] = {"__float__": float, "__int__": int}

_METHODS: dict[str, Callable[..., Any]] = {
    "tostring": calling("tobytes"),
    "itemset": _itemset,
    "ptp": _peak_to_peak,
}


def _one_element(plain: Callable[[Any], Any], kind: Callable[[Any], Any]) -> Callable[[Any], Any]:
    def convert(self: Any) -> Any:
        return kind(self.item()) if self.ndim and self.size == 1 else plain(self)

    return convert


def _round(self: Any, digits: int | None = None) -> Any:
    return round(self.item(), digits)  # raises for several elements


def _array(numpy: ModuleType, plain: Callable[..., Any]) -> Callable[..., Any]:
    """Return ``array`` with ``copy=False`` as "copy if needed", and lists of unequal lengths as arrays of
    objects."""

    where_needed = None if int(numpy.__version__.partition(".")[0]) >= 2 else False

    def array(*args: Any, **kwargs: Any) -> Any:
        if kwargs.get("copy") is False:
            kwargs["copy"] = where_needed
        try:
            return plain(*args, **kwargs)
        except ValueError as error:
            if len(args) > 1 or kwargs.get("dtype") is not None or "inhomogeneous" not in str(error):
                raise
            return plain(*args, **kwargs | {"dtype": object})

    return array


def _fromstring(numpy: ModuleType, plain: Callable[..., Any]) -> Callable[..., Any]:
    """Return ``fromstring`` that takes bytes; texts with a separator go to NumPy."""

    def fromstring(string: Any, dtype: Any = float, count: int = -1, *, sep: str = "", **more: Any) -> Any:
        if sep:
            return plain(string, dtype, count, sep=sep, **more)
        data = string.encode("latin-1") if isinstance(string, str) else string
        return numpy.frombuffer(data, dtype, count).copy()

    return fromstring


def _linspace(numpy: ModuleType, plain: Callable[..., Any]) -> Callable[..., Any]:
    """Return ``linspace`` whose ``num`` may be a float, as in ``np.linspace(0, T, T / dt)``."""

    def linspace(start: Any, stop: Any, num: Any = 50, *args: Any, **kwargs: Any) -> Any:
        return plain(start, stop, int(num), *args, **kwargs)

    return linspace


def _all(numpy: ModuleType) -> None:
    give_back_aliases(numpy)
    give_back_arrays(numpy)


NUMPY: dict[str, Patch] = {
    "numpy": _all,
    "numpy.linalg": lambda linalg: give_missing(linalg, linalg=linalg),
}
"""Patch by the name of the module."""
