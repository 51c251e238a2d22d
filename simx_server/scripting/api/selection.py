"""The selection of objects."""

from __future__ import annotations

from .base import ApiPart


class SelectionFunctions(ApiPart):
    """What a person would have selected."""
