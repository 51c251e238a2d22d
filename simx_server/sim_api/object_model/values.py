"""Values of API 2 that API 1 has as plain numbers: objects, matrices, poses, quaternions, colours.

The ZeroMQ gateway writes them with CBOR tags. Scripts get and give them as tables with a mark, which the modules
`sim-2` turn into objects.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, cast

from simx_server.scripting.interpreter import Function

MOST_NUMBERS = 1 << 22
"""Numbers of one matrix."""


class WrongValue(TypeError):
    """A value is of another kind; the text says what it must be."""


@dataclass(frozen=True, slots=True)
class Ref:
    """An object of the model, by its handle; -1 stands for nil."""

    handle: int


@dataclass(frozen=True, slots=True)
class Matrix:
    """A matrix, row by row; a vector has one column."""

    rows: int
    columns: int
    numbers: list[float]

    def __post_init__(self) -> None:
        """Check the count. Raises ValueError."""
        if self.rows < 0 or self.columns < 0 or self.rows * self.columns != len(self.numbers):
            raise ValueError(f"a matrix of {self.rows} x {self.columns} has not {len(self.numbers)} numbers")

    @staticmethod
    def vector(numbers: Iterable[float]) -> Matrix:
        """Return a matrix of one column."""
        found = [float(each) for each in numbers]
        return Matrix(len(found), 1, found)

    @staticmethod
    def of_points(numbers: Sequence[float], length: int) -> Matrix:
        """Return points, given one after the other, as the columns of a matrix."""
        count = len(numbers) // length if length else 0
        return Matrix(
            length, count, [float(numbers[length * j + i]) for i in range(length) for j in range(count)]
        )

    def in_rows(self) -> list[list[float]]:
        """Return the rows."""
        width = self.columns
        return [self.numbers[width * place : width * (place + 1)] for place in range(self.rows)]

    def points(self, length: int) -> list[float]:
        """Return the columns one after the other. Raises TypeError unless each has `length` numbers."""
        if self.rows != length:
            raise WrongValue(f"a matrix with {length} rows, one column for each item")
        return [self.numbers[self.columns * i + j] for j in range(self.columns) for i in range(self.rows)]


@dataclass(frozen=True, slots=True)
class Pose:
    """x, y, z and the quaternion x, y, z, w."""

    numbers: list[float]


@dataclass(frozen=True, slots=True)
class Quaternion:
    """x, y, z, w."""

    numbers: list[float]


@dataclass(frozen=True, slots=True)
class Color:
    """Red, green, blue and alpha, each 0 to 255."""

    rgba: bytes

    @staticmethod
    def of(parts: Iterable[float]) -> Color:
        """Return the colour of parts from 0 to 1; without a fourth it is opaque."""
        numbers = [min(255, max(0, round(255 * each))) for each in parts]
        return Color(bytes([*numbers, 255][:4]))

    @property
    def parts(self) -> list[float]:
        """Return red, green and blue, 0 to 1."""
        return [each / 255 for each in self.rgba[:3]]


_MARKS: Mapping[str, Callable[[Any], Any]] = {
    "object": lambda value: Ref(int(value)),
    "pose": lambda value: Pose(finite_numbers(value, 7)),
    "quaternion": lambda value: Quaternion(finite_numbers(value, 4)),
    "color": lambda value: _of_bytes(_list(value)),
    "matrix": lambda value: Matrix(int(value[0]), int(value[1]), finite_numbers(value[2])),
    "buffer": lambda value: _buffer(value),
}


class ScriptFunction:
    """A function of a script, which takes and returns values of API 2; see `interpreter.Function`."""

    def __init__(self, function: Function, *, texts_are_bytes: bool) -> None:
        self._function, self._texts_are_bytes = function, texts_are_bytes

    def __call__(self, *arguments: Any) -> list[Any]:
        results = self._function(*(to_script(each) for each in arguments))
        return [from_script(each, texts_are_bytes=self._texts_are_bytes) for each in results]


MARK = "@"
"""Key of the mark in a table of a script: ``{['@']='pose', value={...}}``."""


def _list(value: Any) -> list[Any]:
    if isinstance(value, list):
        return cast(list[Any], value)
    raise WrongValue("a list of numbers")


def _byte(value: Any) -> int:
    return min(255, max(0, int(value)))


def _of_bytes(parts: Sequence[Any]) -> Color:
    """Return a colour of 3 or 4 parts from 0 to 255. Raises TypeError or ValueError."""
    if len(parts) not in (3, 4):
        raise WrongValue("a colour of 3 or 4 parts")
    return Color(bytes([*map(_byte, parts), 255][:4]))


def _buffer(value: Any) -> bytes:
    if isinstance(value, str):
        return value.encode("utf-8", "surrogateescape")
    if isinstance(value, bytes):
        return value
    raise WrongValue("a buffer")


def finite_numbers(value: Any, count: int | None = None) -> list[float]:
    """Return finite numbers. Raises TypeError."""
    items = _list(value)
    if len(items) > MOST_NUMBERS or (count is not None and len(items) != count):
        raise WrongValue(f"a table of {MOST_NUMBERS if count is None else count} numbers")
    if not set(map(type, items)) <= _FLAT:
        raise WrongValue("a table of numbers")
    try:
        found = [float(each) for each in items]
    except OverflowError:  # Python's integers have no limit
        raise WrongValue("a table of finite numbers") from None
    if not all(map(math.isfinite, found)):
        raise WrongValue("a table of finite numbers")
    return found


def from_script(value: Any, *, texts_are_bytes: bool = False) -> Any:
    """Return a script's value with the values of API 2 in place of the tables with a mark.

    Args:
        value: the script's.
        texts_are_bytes: its texts are bytes, so only the tables marked as buffers become bytes.

    Raises:
        TypeError: a table with a mark that holds something else.
    """
    if isinstance(value, list):
        items = cast(list[Any], value)
        return (
            items
            if _is_flat(items)
            else [from_script(each, texts_are_bytes=texts_are_bytes) for each in items]
        )
    if isinstance(value, Function):
        return ScriptFunction(value, texts_are_bytes=texts_are_bytes)
    if texts_are_bytes and isinstance(value, bytes):
        return value.decode("utf-8", "surrogateescape")
    if isinstance(value, dict):
        fields = cast(dict[Any, Any], value)
        mark = fields.get(MARK)
        make = _MARKS.get(mark.decode("ascii", "replace") if isinstance(mark, bytes) else str(mark))
        if make is None or mark is None:
            return {key: from_script(each, texts_are_bytes=texts_are_bytes) for key, each in fields.items()}
        try:
            return make(fields.get("value"))
        except (TypeError, ValueError, IndexError, KeyError, OverflowError):
            raise WrongValue("a value of the module sim-2") from None
    return value


def to_script(value: Any) -> Any:
    """Return a value of API 2 as a script's table with a mark, also within lists and maps."""
    match value:
        case Ref():
            return {MARK: "object", "value": value.handle}
        case Matrix():
            return {MARK: "matrix", "value": [value.rows, value.columns, value.numbers]}
        case Pose():
            return {MARK: "pose", "value": value.numbers}
        case Quaternion():
            return {MARK: "quaternion", "value": value.numbers}
        case Color():
            return {MARK: "color", "value": list(value.rgba)}
        case bytes():
            return {MARK: "buffer", "value": value}
        case list() | tuple():
            items = list(cast(Sequence[Any], value))
            return items if _is_flat(items) else [to_script(each) for each in items]
        case dict():
            return {key: to_script(each) for key, each in cast(dict[Any, Any], value).items()}
        case _:
            return value


def plain(value: Any) -> Any:
    """Return a value as the functions of API 1 take it: handles and lists of numbers; a matrix with several
    columns stays.
    """
    match value:
        case Ref():
            return value.handle
        case Pose() | Quaternion():
            return value.numbers
        case Matrix():
            return value.numbers if value.columns == 1 else value
        case list():
            items = cast(list[Any], value)
            return items if _is_flat(items) else [_plain_within(each) for each in items]
        case dict():
            return {key: _plain_within(each) for key, each in cast(dict[Any, Any], value).items()}
        case _:
            return value


def _plain_within(value: Any) -> Any:
    """Return a value of a list or map as API 1 has it in tables: a matrix as its rows, a colour as its parts."""
    if isinstance(value, Color):
        return value.parts
    found = plain(value)
    return found.in_rows() if isinstance(found, Matrix) else found


_FLAT = {int, float, bool}


def _is_flat(items: list[Any]) -> bool:
    return set(map(type, items)) <= _FLAT


def to_color(value: Any) -> Color:
    """Return a colour of what programs give: 3 or 4 bytes, 3 or 4 parts from 0 to 1, or as many from 0 to 255.

    Raises TypeError.
    """
    if isinstance(value, Color):
        return value
    if isinstance(value, Matrix):
        value = value.numbers
    if isinstance(value, bytes) and len(value) in (3, 4):
        return _of_bytes(value)
    if isinstance(value, list) and len(cast(list[Any], value)) in (3, 4):
        parts = finite_numbers(value)
        all_whole = all(isinstance(each, int) for each in cast(list[Any], value))
        if max(parts) > 1 or (all_whole and len(parts) == 4):
            return _of_bytes(parts)
        return Color.of(parts)
    raise WrongValue("a colour: red, green, blue, and perhaps alpha, each 0 to 1 or 0 to 255")


def to_matrix(value: Any) -> Matrix:
    """Return a matrix of what programs give: a matrix, a list of rows, or a list of numbers, which is a vector.

    Raises TypeError.
    """
    if isinstance(value, Matrix):
        return value
    if isinstance(value, (Pose, Quaternion)):
        return Matrix.vector(value.numbers)
    rows = _list(value)
    if rows and all(isinstance(row, list) for row in rows):
        width = len(rows[0])
        if any(len(row) != width for row in rows):
            raise WrongValue("a matrix whose rows are equally long")
        return Matrix(len(rows), width, [each for row in rows for each in finite_numbers(row, width)])
    return Matrix.vector(finite_numbers(rows))
