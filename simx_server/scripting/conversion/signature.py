"""Conversion of the values that a script passes into the typed arguments of a ``sim`` function.

The annotations of the Python method are the complete description: ``int``, ``float``, ``bool``, ``str``, ``bytes``,
``list`` of these (``list[X | None]``: with nil inside), ``Any`` plain value, ``dict`` for a table with names, ``X | Y``
for the first that fits, ``X | None`` for an optional value or nil, and ``Annotated[X, Most(100)]`` for what must not be
larger. Numbers behave as they do in Lua 5.1, which has one type of number: 3.0 is accepted as an integer, and a
fraction is dropped.
"""

from __future__ import annotations

import inspect
import math
import re
import types
import typing
from collections.abc import Callable, Sequence
from dataclasses import field
from itertools import repeat
from typing import Annotated, Any, cast

from simx_client.protocol.kinds import apply, to_int32
from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import CommandError

from ..interpreter import Function, Plain

MOST_ITEMS = 1_000_000
"""Numbers in a list, where the function does not declare fewer."""

MOST_TEXTS = 100_000
"""Items in a list of texts, or of other values than numbers."""

MOST_VALUES = 250_000
"""Values in a table of any kind, with those of tables in it."""

_NUMBERS_PER_VALUE = 4
"""Numbers that count as one of these, in a table of numbers alone."""

MOST_CHARACTERS = 1 << 20
"""Length of a text, as in the remote API."""

_NO_TEXT = 10**4000
"""Python converts no integer above 4300 digits to text."""


_OLD_HANDLE = re.compile(rb"@backCompatibility\d*:(-?\d{1,18})")
"""A handle as scripts pass it that V-REP 3.1.3 converted: the prefix asked for older colours."""

_NUMBER = re.compile(rb"\s*[-+]?(\d{1,300}\.?\d{0,300}|\.\d{1,300})([eE][-+]?\d{1,4})?\s*")


@dataclass(frozen=True, slots=True)
class Most:
    """The greatest number or length of an argument, chosen so that a call takes at most 0.25 s of processor time."""

    count: int


def _number_of(value: Any) -> Any:
    """Return the number that a text of Lua stands for, as Lua's own functions do; any other value as it is."""
    if isinstance(value, bytes):
        if old := _OLD_HANDLE.fullmatch(value):
            return int(old[1])
        if _NUMBER.fullmatch(value):
            return float(value)
    return value


def to_int(value: Any) -> int:
    """Return int32, wrapping; a float loses its fraction, true and false are 1 and 0."""
    if type(value) is int and -0x80000000 <= value <= 0x7FFFFFFF:  # by far the most frequent
        return value
    value = _number_of(value)
    if isinstance(value, int):
        return to_int32(int(value))
    if isinstance(value, float) and math.isfinite(value):
        return to_int32(int(value))
    raise TypeError("a number")


def to_float(value: Any) -> float:
    if type(value) is float and math.isfinite(value):  # by far the most frequent
        return value
    value = _number_of(value)
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        try:
            number = float(value)
        except OverflowError:  # Python's integers have no limit
            number = math.inf
        if math.isfinite(number):
            return number
    raise TypeError("a finite number")


def to_bool(value: Any) -> bool:
    if isinstance(value, (bool, int, float)):
        return bool(value)
    raise TypeError("true or false")


def to_bytes(value: Any) -> bytes:
    if isinstance(value, bytes):
        return value
    if isinstance(value, str):
        try:
            return value.encode("utf-8", "surrogateescape")
        except UnicodeEncodeError:
            raise TypeError("a string of characters that Unicode has") from None
    if isinstance(value, int) and not isinstance(value, bool) and abs(value) < _NO_TEXT:
        return str(value).encode()  # as in Lua
    if isinstance(value, float):
        return f"{value:.14g}".encode()  # as in V-REP's Lua
    raise TypeError("a string")


def to_text(value: Any) -> str:
    """Return a C string: cut at the first NUL."""
    return to_bytes(value).split(b"\0", 1)[0].decode("utf-8", "surrogateescape")


def to_short_text(value: Any) -> str:
    """Return a C string that is not too long."""
    if value.__class__ is bytes and len(value) <= MOST_CHARACTERS and b"\0" not in value:
        return value.decode("utf-8", "surrogateescape")
    if isinstance(value, (bytes, str)) and len(value) > MOST_CHARACTERS:
        raise TypeError(f"a string of at most {MOST_CHARACTERS} characters")
    return to_text(value)


def to_dict(value: Plain) -> dict[Any, Any]:
    """Return a table with names; an empty one may have arrived as an empty list. Names are text."""
    if isinstance(value, list) and not value:
        return {}
    if isinstance(value, dict):
        _check_size(value)
        return {to_text(name) if isinstance(name, bytes) else name: item for name, item in value.items()}
    raise TypeError("a table with named values")


def to_function(value: Any) -> Function:
    if isinstance(value, Function):
        return value
    raise TypeError("a function")


def to_any(value: Any) -> Any:
    if type(value) in _TABLES:
        _check_size(value)
    return value


def _check_size(table: list[Any] | dict[Any, Any]) -> None:
    """Raise TypeError if a table has too many values, with those of tables in it."""
    waiting: list[Any] = [table]
    left = MOST_VALUES
    while waiting:
        values = waiting.pop()
        content = cast(list[Any], values if isinstance(values, list) else list(values.values()))
        kinds = set(map(type, content))
        left -= 1 + (len(content) // _NUMBERS_PER_VALUE if kinds <= _REALS else len(content))
        if left < 0:
            raise TypeError(f"a table of at most {MOST_VALUES} values, with those of tables in it")
        if not _TABLES.isdisjoint(kinds):
            waiting += [each for each in content if type(each) in _TABLES]


_TABLES = {list, dict}
_REALS = {int, float}


_SCALARS: dict[Any, Callable[[Any], Any]] = {
    int: to_int,
    float: to_float,
    bool: to_bool,
    bytes: to_bytes,
    str: to_short_text,
    dict: to_dict,
    Function: to_function,
    Any: to_any,
}


_EACH_A_FLOAT = repeat(float)


def _all_ints(items: list[Any]) -> list[Any] | None:
    is_plain = set(map(type, items)) == {int} and min(items) >= -0x8000_0000 and max(items) <= 0x7FFF_FFFF
    return items.copy() if is_plain else None


def _all_floats(items: list[Any]) -> list[Any] | None:
    if all(map(isinstance, items, _EACH_A_FLOAT)) and math.isfinite(sum(items)):  # by far the most frequent
        return items.copy()
    if not set(map(type, items)) <= {int, float}:
        return None
    try:
        converted = list(map(float, items))
    except OverflowError:  # Python's integers have no limit
        return None
    return converted if math.isfinite(sum(converted)) else None


_ALL: dict[Callable[[Any], Any], Callable[[list[Any]], list[Any] | None]] = {
    to_int: _all_ints,
    to_float: _all_floats,
}
"""Conversions of whole lists of plain numbers, in a fraction of the time; None for any other list."""


def to_list(item: Callable[[Any], Any], *, with_nil: bool = False) -> Callable[[Any], list[Any]]:
    most = MOST_ITEMS if item in (to_int, to_float, to_bool) else MOST_TEXTS
    all_at_once = _ALL.get(item)

    def convert(value: Plain) -> list[Any]:
        if isinstance(value, list):
            given = value
        elif isinstance(value, dict) and len(value) > most:
            raise TypeError(f"a table of at most {most} values")
        else:
            given = _list_part(value, with_nil=with_nil)
        if len(given) > most:
            raise TypeError(f"a table of at most {most} values")
        if all_at_once is not None and (converted := all_at_once(given)) is not None:
            return converted
        items: list[Any] = []
        for index, element in enumerate(given, 1):
            try:
                items.append(None if with_nil and element is None else item(element))
            except TypeError as problem:
                raise TypeError(f"a table with {problem} at index {index}") from None
        return items

    return convert


def _list_part(value: Plain, *, with_nil: bool) -> list[Any]:
    """Return the list part of a table that also has names, a 0 or gaps; V-REP ignored the names and the 0.

    Args:
        with_nil: gaps are nil as long as more than half of the table is there, as for Lua's length of a table.
    """
    if isinstance(value, dict) and (numbered := [key for key in value if isinstance(key, int) and key > 0]):
        length = max(numbered)
        if length > (2 * len(numbered) if with_nil else len(numbered)):
            raise TypeError("a table without gaps")
        return [value.get(key) for key in range(1, length + 1)]
    raise TypeError("a table")


def to_bounded(convert: Callable[[Any], Any], most: int) -> Callable[[Any], Any]:
    """Return a conversion that refuses what is longer, or a greater number."""

    def bounded(value: Any) -> Any:
        if isinstance(value, (list, dict, bytes, str)):
            if len(cast(Any, value)) > most:
                kind = "a table" if isinstance(value, (list, dict)) else "a string"
                raise TypeError(f"{kind} of at most {most} {'values' if kind == 'a table' else 'characters'}")
            return convert(value)
        number = convert(value)
        if isinstance(number, (int, float)) and number > most:
            raise TypeError(f"a number of at most {most}")
        return number

    return bounded


def to_first(*kinds: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """Return a conversion that tries several and uses the first that fits."""

    def convert(value: Any) -> Any:
        wanted: list[str] = []
        for kind in kinds:
            try:
                return kind(value)
            except TypeError as problem:
                wanted.append(str(problem))
        raise TypeError(" or ".join(wanted))

    return convert


def _converter(annotation: Any) -> tuple[Callable[[Any], Any], bool]:
    """Return the conversion for an annotation, and whether None is accepted."""
    arguments = typing.get_args(annotation)
    origin = typing.get_origin(annotation)
    if origin is Annotated:
        convert, nil_passes = _converter(arguments[0])
        most = next(each for each in arguments[1:] if isinstance(each, Most))
        return to_bounded(convert, most.count), nil_passes
    if isinstance(annotation, types.UnionType) or origin is typing.Union:
        inner = [_converter(argument)[0] for argument in arguments if argument is not type(None)]
        return (inner[0] if len(inner) == 1 else to_first(*inner)), type(None) in arguments
    if origin is list:
        item, with_nil = _converter(arguments[0])
        return to_list(item, with_nil=with_nil and arguments[0] is not Any), False
    return _SCALARS[origin or annotation], annotation is Any


_NUMBERS = (int, float, type(None))
"""Results of functions that gave a number in V-REP; those without a result gave a code."""


@dataclass(frozen=True, slots=True)
class Parameter:
    name: str
    convert: Callable[[Any], Any]
    nil_passes: bool
    default: Any
    """Replaces nil or a missing value; ``inspect.Parameter.empty`` for a mandatory value."""


@dataclass(frozen=True, slots=True)
class Signature:
    """The parameters of one ``sim`` function, without ``self``."""

    parameters: tuple[Parameter, ...]
    rest: Parameter | None = None
    """Parameter for all values after the others."""

    gives_number: bool = False
    """Whether the result is one number."""

    conversions: tuple[Callable[[Any], Any], ...] = field(init=False, repr=False, compare=False)
    """Those of the parameters."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "conversions", tuple(each.convert for each in self.parameters))

    @classmethod
    def of(cls, function: Callable[..., Any]) -> Signature:
        hints = typing.get_type_hints(function, include_extras=True)
        parameters: list[Parameter] = []
        rest: Parameter | None = None
        for name, parameter in list(inspect.signature(function).parameters.items())[1:]:
            convert, nil_passes = _converter(hints[name])
            described = Parameter(name, convert, nil_passes, parameter.default)
            if parameter.kind is inspect.Parameter.VAR_POSITIONAL:
                rest = described
            else:
                parameters.append(described)
        return cls(tuple(parameters), rest, hints.get("return") in _NUMBERS)

    def bind(self, values: Sequence[Any]) -> list[Any]:
        """Return typed arguments for the passed values; more values than parameters are ignored, as in V-REP.

        Raises:
            CommandError: an argument has the wrong type; the text numbers the argument and names the type.
        """
        if len(values) == len(self.conversions) and self.rest is None and None not in values:
            try:
                return list(map(apply, self.conversions, values))
            except TypeError:
                pass  # found again below, where the error gets its text
        bound: list[Any] = []
        for index, parameter in enumerate(self.parameters, 1):
            if index <= len(values):
                bound.append(_bind(index, parameter, values[index - 1]))
            elif parameter.default is not inspect.Parameter.empty:
                bound.append(parameter.default)
            else:
                bound.append(_convert(index, parameter, None, is_missing=True))
        if self.rest is not None:
            for index, value in enumerate(values[len(self.parameters) :], len(self.parameters) + 1):
                bound.append(_bind(index, self.rest, value))
        return bound


def _bind(index: int, parameter: Parameter, value: Any) -> Any:
    if value is None and parameter.default is not inspect.Parameter.empty:
        return parameter.default
    if value is None and parameter.nil_passes:
        return None
    return _convert(index, parameter, value)


def _convert(index: int, parameter: Parameter, value: Any, *, is_missing: bool = False) -> Any:
    try:
        return parameter.convert(value)
    except TypeError as problem:
        got = "nothing" if is_missing else describe(value)
        raise CommandError(f"argument {index} ({parameter.name}) must be {problem}, got {got}") from None


def describe(value: Plain) -> str:
    """Return a plain value in a script author's words."""
    if value is None:
        return "nil"
    if isinstance(value, list):
        return f"a table of {len(value)}"
    if isinstance(value, dict):
        return "a table with names"
    if callable(value):
        return "a function"
    if isinstance(value, bytes):
        value = value.decode("utf-8", "replace")
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
