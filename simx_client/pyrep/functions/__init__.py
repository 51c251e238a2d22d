"""The functions of the C library that are more than a row of the table: each takes the way to ``sim`` first."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from . import data, handling, scripts, shapes, stacks
from .registry import SPECIAL, Special

__all__ = ["Special", "special_functions"]

_MODULES = (data, handling, scripts, shapes, stacks)


def special_functions() -> Mapping[str, Special[Any]]:
    """Return them by name."""
    return SPECIAL
