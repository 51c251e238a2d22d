"""Drawing objects: points, lines and the like, for whoever shows the scene."""

from __future__ import annotations

from .base import ApiPart


class DrawingFunctions(ApiPart):
    """Metres in the world, colours 0..1."""
