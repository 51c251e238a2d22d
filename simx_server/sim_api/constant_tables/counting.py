"""Short form for constants with consecutive numbers."""

from __future__ import annotations


def counted(prefix: str, names: str, start: int = 0) -> dict[str, int]:
    """Return names, separated by spaces, with numbers that rise by 1; ``NAME=5`` continues from there, ``-`` skips one.

    Args:
        prefix: put before each name with an underscore.
        names: the names in the order of their numbers.
        start: the first number.
    """
    found: dict[str, int] = {}
    number = start
    for part in names.split():
        name, sign, value = part.partition("=")
        number = int(value, 0) if sign else number
        if name != "-":
            found[f"{prefix}_{name}"] = number
        number += 1
    return found
