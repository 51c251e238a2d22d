"""Forces on shapes."""

from __future__ import annotations

from .base import ApiPart


class DynamicsFunctions(ApiPart):
    """Newtons and newton metres."""
