"""Bars side by side: the rivals on a logarithmic scale. `drawing_bars.py` draws them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Bar:
    """One figure."""

    name: str
    value: float
    """Above zero."""

    is_ours: bool


@dataclass(frozen=True)
class Bars:
    """Bars below each other."""

    name: str
    """Of the file, without its suffix."""

    groups: Sequence[tuple[str, Sequence[Bar]]]
    """Title, with the unit, and bars."""
