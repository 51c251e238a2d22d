"""Stacks of values. Programs make, fill and read them; nothing else of the library takes one here."""

from __future__ import annotations

from itertools import count
from typing import Any

from .. import c_values as c
from ..plain import Call
from .registry import c_function

_stacks: dict[int, list[Any]] = {}
_handles = count(1)

NO_VALUE = 0
"""The result of a function that finds another type on top."""


@c_function()
def simCreateStack(_call: Call) -> int:
    """Make an empty stack and return its handle."""
    handle = next(_handles)
    _stacks[handle] = []
    return handle


@c_function()
def simReleaseStack(_call: Call, stack: int) -> int:
    """Remove a stack."""
    del _stacks[stack]
    return 1


@c_function()
def simPushInt32OntoStack(_call: Call, stack: int, value: int) -> int:
    """Put an integer on top."""
    _stacks[stack].append(int(value))
    return 1


@c_function()
def simPushFloatOntoStack(_call: Call, stack: int, value: float) -> int:
    """Put a number on top."""
    _stacks[stack].append(c.single(float(value)))
    return 1


@c_function()
def simPushStringOntoStack(_call: Call, stack: int, value: Any, length: int) -> int:
    """Put a text on top; of the length 0 up to its zero byte."""
    _stacks[stack].append((c.content(value) or b"")[:length] if length else c.text(value))
    return 1


@c_function()
def simGetStackInt32Value(_call: Call, stack: int, value: c.C) -> int:
    """Write the integer on top."""
    return _top(stack, int, value)


@c_function()
def simGetStackFloatValue(_call: Call, stack: int, value: c.C) -> int:
    """Write the number on top."""
    return _top(stack, (int, float), value)


def _top(stack: int, kind: Any, value: c.C) -> int:
    values = _stacks[stack]
    if not values or not isinstance(values[-1], kind):
        return NO_VALUE
    c.fill(value, values[-1])
    return 1
