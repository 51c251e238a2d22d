"""Names of a URDF's elements in messages."""

from __future__ import annotations

from collections.abc import Sequence

MOST_NAMED = 5
"""Most names in one message."""


def some(names: Sequence[str]) -> str:
    """Return the first names in quotes, with the number of the others."""
    shown = [repr(name) for name in names[:MOST_NAMED]]
    more = len(names) - len(shown)
    return ", ".join(shown) + (f" and {more} more" if more else "")
