"""Make the CDR bytes of messages, with one function per layout that is compiled from Python text.

Rules of CDR version 1, little endian: a number is aligned to its size, counted from the end of the header of four
bytes; a string is the count of its bytes with the final NUL, then these; a wide string the count of its units, then
these; a sequence is its count, then its values.

The text of a function collects the plain values that follow each other, and packs them with one call of `struct`.
The padding depends on where the values start, so each such run has eight `struct` objects, one per start modulo 8.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping, Sequence
from functools import cache, lru_cache
from typing import Any, TypeAlias

import numpy as np

from .layouts import Field, Layout, WideString
from .primitives import COUNT, Primitive

HEADER = b"\x00\x01\x00\x00"
"""CDR version 1, little endian, no options."""

Write: TypeAlias = Callable[[Mapping[str, Any], Callable[[Any], None], int], int]
"""Takes a message, a function that appends bytes, and the number of bytes before; returns the number after."""

WRONG_VALUE = (KeyError, TypeError, ValueError, AttributeError, OverflowError, struct.error)
"""A compiled function raises these for a message with missing or wrong fields."""

_MOST_KEPT = 64
"""Number of strings in the longest list that is kept encoded: the names of joints are the same in each step."""


class Encoders:
    """The compiled functions of all layouts, each made when it is first needed."""

    def __init__(self) -> None:
        self._made: dict[str, Write] = {}

    def of(self, layout: Layout) -> Write:
        """Return the function that writes a message of this layout."""
        if layout.name not in self._made:
            self._made[layout.name] = _Compiler(self).compile(layout)
        return self._made[layout.name]


class _Compiler:
    """Makes the text of one function and compiles it."""

    def __init__(self, encoders: Encoders) -> None:
        self._encoders = encoders
        self._lines: list[str] = []
        self._names: dict[str, Any] = {
            "_numbers": _numbers,
            "_array": _array,
            "_texts": _texts,
            "_wide": _wide,
            "_wide_texts": _wide_texts,
            "_exact": _exact,
        }
        self._run: list[tuple[Primitive, str]] = []
        self._variables = 0

    def compile(self, layout: Layout) -> Write:
        self._message(layout, "message")
        self._flush()
        body = "\n    ".join(self._lines)
        text = f"def write(message, add, n):\n    {body}\n    return n\n"
        exec(compile(text, f"<encoder of {layout.name}>", "exec"), self._names)
        return self._names["write"]

    def _message(self, layout: Layout, variable: str) -> None:
        if not layout.fields:
            # ROS 2 gives a message without fields one byte.
            self._run.append((_BYTE, "0"))
        for field in layout.fields:
            value = f"{variable}[{field.name!r}]"
            if field.count is None:
                self._single(field, value)
            else:
                self._several(field, value, field.count)

    def _single(self, field: Field, value: str) -> None:
        if isinstance(field.kind, Primitive):
            self._run.append((field.kind, value))
        elif isinstance(field.kind, Layout):
            self._message(field.kind, self._let(value))
        else:
            is_wide = field.kind is WideString
            text = self._let(f"_wide({value})" if is_wide else f"{value}.encode() + b'\\0'")
            self._run.append((COUNT, f"len({text}){' // 4' if is_wide else ''}"))
            self._flush()
            self._lines += [f"add({text})", f"n += len({text})"]

    def _several(self, field: Field, value: str, count: int) -> None:
        if isinstance(field.kind, Primitive):
            self._numbers(field.kind, value, count)
        elif isinstance(field.kind, Layout):
            self._messages(field.kind, value, count)
        else:
            # The encoded form has the count; an array of a fixed number of strings has none.
            function = "_wide_texts" if field.kind is WideString else "_texts"
            text = self._let(f"{function}({value}, {count})")
            self._flush(align=4)
            self._lines += [f"add({text})", f"n += len({text})"]

    def _numbers(self, kind: Primitive, value: str, count: int) -> None:
        data, size, number = self._let(), self._let(), self._let()
        call = f"_array({value}, _{kind.name}, {count})" if count else f"_numbers({value}, _{kind.name})"
        self._names[f"_{kind.name}"] = kind
        self._lines.append(f"{data}, {size}, {number} = {call}")
        if count:
            self._flush(align=kind.size)
        else:
            self._run.append((COUNT, number))
            self._flush()
            self._lines.append(f"if {size}:")
            if kind.size == 8:
                self._lines.append("    if n & 4: add(b'\\0\\0\\0\\0'); n += 4")
        indent = "" if count else "    "
        self._lines += [f"{indent}add({data})", f"{indent}n += {size}"]

    def _messages(self, kind: Layout, value: str, count: int) -> None:
        items = self._let(f"_exact({value}, {count})" if count else value)
        write = f"write_{len(self._names)}"
        self._names[write] = self._encoders.of(kind)
        if not count:
            self._run.append((COUNT, f"len({items})"))
        self._flush()
        self._lines.append(f"for item in {items}: n = {write}(item, add, n)")

    def _let(self, value: str | None = None) -> str:
        """Return the name of a new variable, which is given the value, if any."""
        self._variables += 1
        name = f"v{self._variables}"
        if value is not None:
            self._lines.append(f"{name} = {value}")
        return name

    def _flush(self, align: int = 1) -> None:
        """Write the plain values collected, then pad to the alignment."""
        if not self._run and align == 1:
            return
        name = f"run_{len(self._names)}"
        self._names[name] = _packers("".join(kind.letter for kind, _ in self._run), align)
        data = self._let(f"{name}[n & 7]({', '.join(value for _, value in self._run)})")
        self._lines += [f"add({data})", f"n += len({data})"]
        self._run.clear()


_BYTE = Primitive("uint8", "B", 1, 0)


@cache
def structs(letters: str, align: int = 1) -> tuple[struct.Struct, ...]:
    """Return eight forms of a run of numbers: that which starts at a multiple of 8, at one byte after it, and so on.

    Args:
        letters: `struct` letters of the numbers.
        align: bytes to which the end is padded.
    """
    found: list[struct.Struct] = []
    for start in range(8):
        text, at = "<", start
        for letter in letters:
            size = struct.calcsize(f"<{letter}")
            text += "x" * (-at % size) + letter
            at += -at % size + size
        found.append(struct.Struct(text + "x" * (-at % align)))
    return tuple(found)


def _packers(letters: str, align: int) -> tuple[Callable[..., bytes], ...]:
    return tuple(form.pack for form in structs(letters, align))


def _numbers(value: Any, kind: Primitive) -> tuple[Any, int, int]:
    """Return the bytes of numbers, in a form that can be joined; how many bytes; how many numbers.

    Args:
        value: a list, an array, or the packed bytes.
    """
    if isinstance(value, np.ndarray):
        array: np.ndarray[Any, np.dtype[Any]] = value  # pyright: ignore[reportUnknownVariableType]
        if array.dtype != kind.dtype:
            array = array.astype(kind.dtype, casting="same_kind")
        if not array.flags.c_contiguous:
            array = np.ascontiguousarray(array)
        return array, array.nbytes, array.size
    if isinstance(value, bytes | bytearray | memoryview):
        data = memoryview(value)  # pyright: ignore[reportUnknownArgumentType]
        if data.nbytes % kind.size:
            raise ValueError
        return data, data.nbytes, data.nbytes // kind.size
    if isinstance(value, str):
        raise TypeError
    number = len(value)
    return struct.pack(f"<{number}{kind.letter}", *value), number * kind.size, number


def _array(value: Any, kind: Primitive, count: int) -> tuple[Any, int, int]:
    found = _numbers(value, kind)
    if found[2] != count:
        raise ValueError
    return found


def _exact(value: Sequence[Any], count: int) -> Sequence[Any]:
    if len(value) != count:
        raise ValueError
    return value


def _texts(value: Any, count: int) -> bytes:
    """Return strings as they stand in a message, with their number before them unless `count` fixes it."""
    if isinstance(value, str) or (count and len(value) != count):
        raise ValueError
    names = tuple(value)
    encoded = _kept(names) if len(names) <= _MOST_KEPT else _joined(names)
    return encoded[4:] if count else encoded


def _wide(text: str) -> bytes:
    """Return the 16-bit units of a string, with 32 bits each."""
    return np.frombuffer(text.encode("utf-16-le"), "<u2").astype("<u4").tobytes()


def _wide_texts(value: Any, count: int) -> bytes:
    """Return what `_texts` returns, of wide strings."""
    if isinstance(value, str) or (count and len(value) != count):
        raise ValueError
    made = [_wide(text) for text in value]
    found = b"".join(struct.pack("<I", len(each) // 4) + each for each in made)
    return found if count else struct.pack("<I", len(made)) + found


def _joined(names: tuple[str, ...]) -> bytes:
    found = bytearray(struct.pack("<I", len(names)))
    for name in names:
        data = name.encode() + b"\0"
        found += bytes(-len(found) % 4) + struct.pack("<I", len(data)) + data
    return bytes(found)


_kept = lru_cache(maxsize=64)(_joined)
