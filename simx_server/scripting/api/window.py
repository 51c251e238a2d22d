"""What needs a window."""

from __future__ import annotations

from .base import ApiPart


class WindowFunctions(ApiPart):
    """None of it is there."""
