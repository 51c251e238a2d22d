"""Places of a program, and the things that it names there."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path


@dataclass(frozen=True, order=True)
class Place:
    """Where something stands in the program."""

    file: Path
    line: int

    def __str__(self) -> str:
        return f"{self.file}:{self.line}"


@dataclass(frozen=True, order=True)
class Wanted:
    """Something a program names; a text with ``*`` is known in parts."""

    kind: str
    name: str
    place: Place = field(compare=False)
