"""A V-REP file from which objects of the scene were made: it is needed to write them into such a file again."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True, eq=False, slots=True)
class VrepSource:
    """The file, and which of its objects became which."""

    data: bytes
    name: str
    """The file's name in messages."""
    is_model: bool
    handles: Mapping[str, int]
    """Names of the objects in the scene that the file gave, and their handles in the file."""
