"""Complete and check the values of a message that come from outside, such as a script's table."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from typing import Any, SupportsFloat

import numpy as np

from .errors import MessageError
from .layouts import Field, Layout
from .primitives import Primitive

_MOST_FLOAT32 = 3.4028235677973366e38
"""Numbers from here on are infinite in single precision."""


def default_value(layout: Layout) -> dict[str, Any]:
    """Return a message in which each field has its default; arrays of numbers are lists."""
    return {field.name: _default(field) for field in layout.fields}


def fill(layout: Layout, value: Any, path: str = "") -> dict[str, Any]:
    """Return a message with all fields, each of its type; missing ones have their defaults.

    Args:
        layout: of the message.
        value: a mapping of fields.
        path: names the message within a larger one, in errors.

    Raises:
        MessageError: a field is unknown, or its value does not fit.
    """
    if value == []:
        value = {}  # Lua has one form for an empty list and an empty table
    if not isinstance(value, Mapping):
        names = ", ".join(field.name for field in layout.fields) or "no fields"
        raise _error(layout, path, f"takes a table with the fields {names}, not {_shown(value)}")
    given: Mapping[Any, Any] = value  # pyright: ignore[reportUnknownVariableType]
    known = [field.name for field in layout.fields]
    for name in given:
        if name not in known:
            near = get_close_matches(str(name), known, 1)
            hint = f"; did you mean {near[0]}?" if near else f"; it has {', '.join(known) or 'no fields'}"
            raise _error(layout, path, f"has no field {_shown(name)}{hint}")
    return {
        field.name: _converted(
            layout, field, given[field.name], f"{path}.{field.name}" if path else field.name
        )
        if field.name in given
        else _default(field)
        for field in layout.fields
    }


def _default(field: Field) -> Any:
    if field.count is None:
        if isinstance(field.kind, Layout):
            return default_value(field.kind)
        return field.default
    if isinstance(field.kind, Layout):
        return [default_value(field.kind) for _ in range(field.count)]
    given = list(field.default) if isinstance(field.default, tuple) else []
    return given or [field.kind.default if isinstance(field.kind, Primitive) else ""] * field.count


def _converted(layout: Layout, field: Field, value: Any, path: str) -> Any:
    if field.count is None:
        return _one(layout, field, value, path)
    if isinstance(field.kind, Primitive) and isinstance(value, np.ndarray | bytes | bytearray | memoryview):
        return _packed(layout, field, field.kind, value, path)
    if value == {}:
        value = []
    if isinstance(value, str | bytes) or not isinstance(value, Sequence | np.ndarray):
        raise _error(layout, path, f"takes a list, not {_shown(value)}")
    items: Sequence[Any] = value  # pyright: ignore[reportUnknownVariableType, reportAssignmentType]
    _check_count(layout, field, len(items), path)
    return [_one(layout, field, item, f"{path}[{at}]") for at, item in enumerate(items)]


def _packed(layout: Layout, field: Field, kind: Primitive, value: Any, path: str) -> Any:
    if isinstance(value, bytes | bytearray | memoryview):
        data = memoryview(value)  # pyright: ignore[reportUnknownArgumentType]
        if data.nbytes % kind.size:
            why = f"takes packed values of {kind.size} bytes each, not {data.nbytes} bytes"
            raise _error(layout, path, why)
        array: Any = np.frombuffer(data, kind.dtype)
    else:
        array = value
        if array.dtype != kind.dtype:
            return [_number(layout, kind, item, path) for item in array.ravel().tolist()]
    _check_count(layout, field, array.size, path)
    return array


def _check_count(layout: Layout, field: Field, count: int, path: str) -> None:
    if field.most and count > field.most:
        raise _error(layout, path, f"takes at most {field.most} values, not {count}")
    if field.count and count != field.count:
        raise _error(layout, path, f"takes {field.count} values, not {count}")


def _one(layout: Layout, field: Field, value: Any, path: str) -> Any:
    if isinstance(field.kind, Layout):
        return fill(field.kind, value, path)
    if isinstance(field.kind, Primitive):
        return _number(layout, field.kind, value, path)
    if isinstance(value, bytes | bytearray):
        try:
            value = value.decode()
        except UnicodeDecodeError:
            raise _error(layout, path, "takes a text in UTF-8") from None
    if not isinstance(value, str):
        raise _error(layout, path, f"takes a text, not {_shown(value)}")
    if field.longest and len(value) > field.longest:
        raise _error(layout, path, f"takes at most {field.longest} characters, not {len(value)}")
    try:
        value.encode()
    except UnicodeEncodeError:
        raise _error(layout, path, f"takes a text that can be UTF-8, not {_shown(value)}") from None
    return value


def _number(layout: Layout, kind: Primitive, value: Any, path: str) -> bool | int | float:
    if not isinstance(value, SupportsFloat) or isinstance(value, str):
        raise _error(layout, path, f"takes a number ({kind.name}), not {_shown(value)}")
    if kind.letter == "?":
        return bool(value)
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        raise _error(layout, path, f"takes a number ({kind.name}), not {_shown(value)}") from None
    if kind.least is None or kind.most is None:
        if kind.letter == "f" and _MOST_FLOAT32 <= abs(number) < math.inf:
            raise _error(layout, path, f"takes a number of single precision, not {_shown(value)}")
        return number
    whole = value if isinstance(value, int) else int(number) if number.is_integer() else None
    if whole is None or not kind.least <= whole <= kind.most:
        raise _error(
            layout,
            path,
            f"takes an integer from {kind.least} to {kind.most} ({kind.name}), not {_shown(value)}",
        )
    return int(whole)


def _error(layout: Layout, path: str, why: str) -> MessageError:
    return MessageError(f"{layout.name}: field {path} {why}" if path else f"{layout.name} {why}")


def _shown(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
