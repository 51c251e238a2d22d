"""The original binding's names of its C functions, such as ``vrep.c_GetJointPosition``, which some programs call.

Such a call has the arguments of the function ``simx...``, then where the results go, such as ``byref(position)`` or an
array, then the operation mode; it returns the return code.
"""

from __future__ import annotations

import ctypes
import inspect
from collections.abc import Callable, Mapping
from functools import cache
from types import FunctionType
from typing import Any, cast

PREFIX = "c_"

_VALUE: Any = ctypes.c_int.__base__
_POINTER: Any = ctypes.POINTER(ctypes.c_int).__base__
_ARRAY: Any = ctypes.Array
"""The classes of all simple C values, all pointers and all arrays."""


def c_function(name: str, functions: Mapping[str, FunctionType]) -> Callable[..., Any] | None:
    """Return the C function of a name, such as ``c_GetJointPosition``; None for any other name."""
    function = functions.get(f"simx{name.removeprefix(PREFIX)}") if name.startswith(PREFIX) else None
    return None if function is None else _as_c(name, function)


@cache
def _as_c(name: str, function: FunctionType) -> Callable[..., Any]:
    parameters = list(inspect.signature(function).parameters)
    has_mode = parameters[-1:] == ["operationMode"]
    count = len(parameters) - has_mode

    def call(*arguments: Any) -> Any:
        taken, targets = arguments[:count], arguments[count:]
        mode: tuple[Any, ...] = ()
        if has_mode:
            *targets, last = targets or [None]
            mode = (_plain(last),)
        if any(map(_is_reference, (*taken, *mode))) or not all(map(_is_target, targets)):
            raise TypeError(
                f"{name} takes {', '.join(parameters)}, with the results in front of operationMode"
            )
        found: Any = function(*map(_plain, taken), *mode)
        values: list[Any] = list(cast(tuple[Any, ...], found)) if isinstance(found, tuple) else [found]
        code, *results = values
        if code == 0:
            for target, result in zip(targets, results, strict=False):
                _store(name, target, result)
        return code

    call.__name__ = call.__qualname__ = name
    call.__doc__ = f"Call {function.__name__}, and put its results where the last arguments point."
    return call


def _is_reference(value: Any) -> bool:
    return hasattr(value, "_obj") or isinstance(value, _POINTER)


def _is_target(value: Any) -> bool:
    return _is_reference(value) or isinstance(value, _ARRAY)


def _plain(value: Any) -> Any:
    """Return what a simple C value, a text of C or an array stands for."""
    if isinstance(value, _VALUE):
        return value.value
    if isinstance(value, _ARRAY):
        return value.value if value._type_ is ctypes.c_char else list(value)
    return value


def _store(name: str, target: Any, result: Any) -> None:
    """Write a result where ``byref``, a pointer or an array points. Raises TypeError: it does not fit."""
    place: Any = getattr(target, "_obj", target)
    try:
        if isinstance(result, list):
            for index, item in enumerate(cast(list[Any], result)):
                place[index] = item
        elif isinstance(place, _VALUE):
            place.value = result
        else:
            place[0] = result
    except (TypeError, IndexError):
        text = f"{name} cannot fill a {type(place).__name__}; call simx{name.removeprefix(PREFIX)}"
        raise TypeError(text) from None
