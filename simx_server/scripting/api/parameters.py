"""Parameters of the simulator."""

from __future__ import annotations

from .base import ApiPart


class ParameterFunctions(ApiPart):
    """By number."""
