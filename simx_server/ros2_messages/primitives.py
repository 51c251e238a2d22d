"""The plain types of ROS 2 messages: their size, their letter in `struct`, their NumPy type.

Sizes and alignments are those of CDR version 1: each number is aligned to its own size.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np


@dataclass(frozen=True)
class Primitive:
    """A number or truth value.

    Attributes:
        name: as message definitions write it.
        letter: in `struct`.
        size: in bytes; also the alignment.
        default: value of a field that is not set.
        least, most: range of an integer; None for others.
    """

    name: str
    letter: str
    size: int
    default: bool | int | float
    least: int | None = None
    most: int | None = None

    @cached_property
    def dtype(self) -> np.dtype[Any]:
        """Return the NumPy type, little endian."""
        import numpy

        return numpy.dtype(f"<{self.letter}")


def _integer(name: str, letter: str, size: int) -> Primitive:
    bits = 8 * size
    if letter.isupper():
        return Primitive(name, letter, size, 0, 0, (1 << bits) - 1)
    return Primitive(name, letter, size, 0, -(1 << bits - 1), (1 << bits - 1) - 1)


PRIMITIVES = MappingProxyType(
    {
        kind.name: kind
        for kind in (
            Primitive("bool", "?", 1, False),
            Primitive("float32", "f", 4, 0.0),
            Primitive("float64", "d", 8, 0.0),
            _integer("byte", "B", 1),
            _integer("char", "B", 1),
            _integer("int8", "b", 1),
            _integer("uint8", "B", 1),
            _integer("int16", "h", 2),
            _integer("uint16", "H", 2),
            _integer("int32", "i", 4),
            _integer("uint32", "I", 4),
            _integer("int64", "q", 8),
            _integer("uint64", "Q", 8),
        )
    }
)

COUNT = PRIMITIVES["uint32"]
"""Stands before the values of a sequence, and before a string."""
