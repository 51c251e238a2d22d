"""Fields of the tables that scripts pass to motions."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from simx_server.errors import CommandError
from simx_server.scripting.conversion.signature import describe, to_float, to_list

from .moving import numbers

NUMBERS = to_list(to_float)


def read(data: Mapping[str, Any], name: str, convert: Callable[[Any], Any], default: Any) -> Any:
    """Return a checked field of a script's table.

    Raises:
        CommandError: the field has the wrong type.
    """
    value = data.get(name)
    if value is None:
        return default
    try:
        return convert(value)
    except TypeError as problem:
        raise CommandError(f"the field {name} must be {problem}, got {describe(value)}") from None


def field(
    data: Mapping[str, Any], name: str, count: int, default: Sequence[float] | None = None
) -> list[float]:
    """Return `count` numbers of a table's field; a single number stands for all."""
    value = data.get(name)
    if isinstance(value, (int, float)):
        value = [value] * count
    return numbers(read({name: value}, name, NUMBERS, None), count, f"the field {name}", default)
