"""Scripts of the scene among themselves: handles, names, calls, parameters."""

from __future__ import annotations

from .base import ApiPart


class ScriptFunctions(ApiPart):
    """A child script is known by a handle of its own."""
