"""Graphs: streams of numbers over simulated time."""

from __future__ import annotations

from .base import ApiPart


class GraphFunctions(ApiPart):
    """Seconds; a stream has a handle of its own."""
