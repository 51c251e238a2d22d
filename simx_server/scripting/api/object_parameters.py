"""Numbered parameters and properties of objects."""

from __future__ import annotations

from .base import ApiPart


class ObjectParameterFunctions(ApiPart):
    """Parameters by number."""
