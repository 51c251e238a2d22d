"""The list of functions that are written by hand."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Generic, NamedTuple, TypeVar

from ..plain import FAILED

_F = TypeVar("_F", bound=Callable[..., Any])


class Special(NamedTuple, Generic[_F]):
    """A function that takes the way to ``sim`` (`plain.Call`), then the arguments of C."""

    function: _F
    failure: Any
    """Its result when it fails."""


SPECIAL: dict[str, Special[Any]] = {}


def c_function(failure: Any = FAILED) -> Callable[[_F], _F]:
    """Add a function to the list, by its name in snake case: ``sim_get_qhull`` is not possible, names are C's.

    Args:
        failure: what it returns when it fails.
    """

    def add(function: _F) -> _F:
        SPECIAL[function.__name__] = Special(function, failure)
        return function

    return add
