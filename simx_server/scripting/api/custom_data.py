"""Data that scripts keep with objects, the scene or the server."""

from __future__ import annotations

from .base import ApiPart


class CustomDataFunctions(ApiPart):
    """Bytes by name."""
