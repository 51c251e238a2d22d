"""Names, aliases and copy numbers of objects."""

from __future__ import annotations

from .base import ApiPart


class ObjectNameFunctions(ApiPart):
    """Old names and aliases."""
