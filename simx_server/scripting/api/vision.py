"""Vision sensors: handling, statistics, pictures and depth."""

from __future__ import annotations

from .base import ApiPart


class VisionFunctions(ApiPart):
    """Pictures are made on the render thread; a script waits for them."""
