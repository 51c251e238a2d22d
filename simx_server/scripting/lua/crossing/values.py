"""Values of a script that enter and leave Lua.

A table of Lua becomes a list when its keys are 1, 2 ... without a gap (or when it is empty), else a dict; a Python list
or dict becomes a table. `scripting/interpreter.py` specifies the values.
"""

from __future__ import annotations

import itertools
import struct
from array import array
from collections.abc import Callable, Iterable, Iterator, Sequence, Sized
from numbers import Integral, Real
from typing import Any, Final, Protocol, TypeVar, cast

from simx_server.errors import CommandError
from simx_server.scripting.interpreter import Plain, ScriptError

_T = TypeVar("_T")

_MANY = 5000
"""Items of a table that are converted in about 3 ms; after this number the clock is checked."""

_SIMPLE: Final = frozenset({bool, float, int, bytes, type(None)})
"""Types that lupa returns for values of Lua."""

_UNCHANGED: Final = frozenset({bool, float, bytes})
"""Types of items that enter Lua as they are."""

_ALONE: Final = ord("-")
_FLOATS: Final = ord("d")
_MIXED: Final = ord("m")
"""Kinds of arguments, as in `values.lua`."""

_PACKED: Final = 200
"""Numbers in a piece of a list that leaves Lua, as in `values.lua`."""

_NUMBER: Final = 8
"""Bytes of a number of Lua."""

_FEW_FLOATS = {_NUMBER * count: struct.Struct(f"={count}d").unpack for count in range(_PACKED + 1)}
"""Functions that unpack short lists of floats, by the bytes of the list: in half the time of an array."""


class _Interpreter(Protocol):
    name: str

    def apply(self, function: LuaFunction, arguments: tuple[Any, ...]) -> list[Any]: ...


class LuaFunction:
    """A function that a script passed to the server; see `interpreter.Function`."""

    def __init__(self, interpreter: _Interpreter, function: Any) -> None:
        self.interpreter = interpreter
        self.function = function

    def __call__(self, *arguments: Any) -> list[Any]:
        return self.interpreter.apply(self, arguments)


class Values:
    """Converts the values of one interpreter."""

    def __init__(
        self,
        interpreter: _Interpreter,
        runtime: Any,
        lua_type: Callable[[Any], str | None],
        breathe: Callable[[], object],
    ) -> None:
        """Convert nothing yet.

        Args:
            runtime: lupa's.
            lua_type: lupa's function that names the kind of a value of Lua.
            breathe: is called now and then during a long conversion, and may end it by an exception.
        """
        self._lua_type = lua_type
        self._interpreter: Any = interpreter
        self._breathe: Any = breathe
        self._runtime: Any = runtime
        self._of_main: Any = runtime.globals()[b"assert"]
        """Returns its argument, of which lupa makes an object of the main coroutine. A value of another coroutine must
        not outlive that: when Python frees it, lupa writes to the coroutine's memory."""

    def close(self) -> None:
        """Forget the interpreter and Lua's state, so that both are freed; nothing is converted any more."""
        self._interpreter = self._breathe = self._runtime = self._of_main = None

    def given(self, kinds: bytes, values: tuple[Any, ...]) -> list[Any]:
        """Return the arguments of a call.

        Args:
            kinds: a letter for each value: `_ALONE`, or a kind of list of numbers that `values.lua` has packed in a
                string: ``d`` of floats, ``j`` of integers, ``m`` of both.
            values: from Lua.
        """
        found: list[Any] = []
        for kind, value in zip(kinds, values):  # noqa: B905  # as many; `strict` takes as long as all of this
            if kind == _ALONE:
                found.append(value if value.__class__ in _SIMPLE else self.from_lua(value))
            elif kind == _FLOATS and (unpack := _FEW_FLOATS.get(len(value))) is not None:
                found.append(list(unpack(value)))
            else:
                found.append(self._numbers(kind, value))
        return found

    def given_list(self, kind: bytes, data: bytes) -> list[int | float]:
        """Return a list within a table, which Lua has packed; Lua passes it on as it is."""
        return self._numbers(kind[0], data)

    def _numbers(self, kind: int, data: bytes) -> list[int | float]:
        """Return the numbers of a list that Lua has packed."""
        if kind == _MIXED:
            size = _PACKED * (1 + _NUMBER)  # of a piece: letters, then numbers
            found: list[int | float] = []
            for start in range(0, len(data), size):
                piece = data[start : start + size]
                count = len(piece) // (1 + _NUMBER)
                letters = piece[:count].replace(b"j", b"q").decode()
                found += struct.unpack(f"={letters}", piece[count:])
            return found
        numbers = array("d" if kind == _FLOATS else "q", data)
        if len(numbers) <= _MANY:
            return cast("list[int | float]", numbers.tolist())
        found = []
        for piece in self._pieces(numbers):
            found += piece
        return found

    def to_lua(self, value: Plain | Integral | Real | bytearray | memoryview) -> Any:
        """Convert a value so that lupa passes a value of Lua: other values would reach the script as Python objects."""
        kind = type(value)
        if kind is float or kind is bytes or kind is bool or value is None:
            return value
        # That its type is int says nothing to pyright.
        if kind is int and -(1 << 63) <= value < 1 << 63:  # pyright: ignore[reportOperatorIssue]
            return value
        if isinstance(value, str):
            return value.encode("utf-8", "surrogateescape")
        if isinstance(value, (list, tuple)):
            is_short = len(value) <= _MANY and _UNCHANGED.issuperset(map(type, value))
            return self._runtime.table_from(value if is_short else self._entering(value))
        if isinstance(value, dict):
            items = self._breathing(value.items())
            return self._runtime.table_from(
                {self.to_lua(key): self.to_lua(item) for key, item in items if item is not None}
            )
        if isinstance(value, LuaFunction):
            if value.interpreter is not self._interpreter:
                raise CommandError("a function of one script cannot be given to another")
            return value.function
        if isinstance(value, Integral):
            number = int(value)
            return number if -(1 << 63) <= number < 1 << 63 else float(number)
        if isinstance(value, Real):
            return float(value)
        if isinstance(value, (bytes, bytearray, memoryview)):
            return bytes(value)
        raise TypeError(f"a {type(value).__name__} cannot enter a script")

    def _entering(self, items: Sequence[Any]) -> list[Any]:
        entering: list[Any] = []
        for piece in self._pieces(items):
            entering += piece if _enters_as_it_is(piece) else map(self.to_lua, piece)
        return entering

    def from_lua(self, value: Any) -> Any:
        if type(value) in _SIMPLE:
            return value
        kind = self._lua_type(value)
        if kind == "table":
            pairs = iter(value.items())
            items = dict(itertools.islice(pairs, _MANY))
            if len(items) == _MANY:
                self._read_on(items, pairs)
            try:
                found = [items[i] for i in range(1, len(items) + 1)]
            except KeyError:  # it has a gap, or names
                return {_key(key): self.from_lua(item) for key, item in self._breathing(items.items())}
            if len(found) <= _MANY and _SIMPLE.issuperset(map(type, found)):
                return found
            leaving: list[Any] = []
            for piece in self._pieces(found):
                leaving += piece if _SIMPLE.issuperset(map(type, piece)) else map(self.from_lua, piece)
            return leaving
        if kind == "function":
            return LuaFunction(self._interpreter, self._of_main(value))
        if kind is not None:
            raise ScriptError(f"{self._interpreter.name}: a {kind} cannot leave the script")
        return value

    def _read_on(self, items: dict[Any, Any], pairs: Iterator[tuple[Any, Any]]) -> None:
        """Add the remaining keys and values of a long table of Lua, unconverted."""
        read = len(items)
        while len(items) == read:
            self._breathe()
            items.update(itertools.islice(pairs, _MANY))
            read += _MANY

    def _pieces(self, items: Sequence[_T]) -> Iterator[Sequence[_T]]:
        """Yield a long list in pieces; the server answers other clients between them."""
        for start in range(0, len(items), _MANY):
            if start:
                self._breathe()
            yield items[start : start + _MANY]

    def _breathing(self, items: Iterable[_T]) -> Iterable[_T]:
        """Yield the items of a table; a large one takes long to convert, so the server answers other clients
        meanwhile.
        """
        if isinstance(items, Sized) and len(items) < _MANY:
            return items
        return self._with_turns_of_others(items)

    def _with_turns_of_others(self, items: Iterable[_T]) -> Iterator[_T]:
        for number, item in enumerate(items, 1):
            if number % _MANY == 0:
                self._breathe()
            yield item


def _enters_as_it_is(items: Sequence[Any]) -> bool:
    """Return whether lupa makes values of Lua of all items; Lua's integers have 64 bits."""
    kinds = set(map(type, items))
    if kinds == {int}:
        return min(items) >= -(1 << 63) and max(items) < 1 << 63
    return kinds <= _UNCHANGED


def _key(key: bytes | int) -> str | int:
    return key.decode("utf-8", "surrogateescape") if isinstance(key, bytes) else key
