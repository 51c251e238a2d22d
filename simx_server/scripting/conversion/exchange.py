"""Check of the four values that a function must return to a caller outside."""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any

from simx_client.protocol.kinds import MAX_BYTES

from ..interpreter import ScriptError
from .signature import describe, to_bytes, to_float, to_int, to_list, to_text


def _to_float32(value: Any) -> float:
    """Return a number rounded to single precision, as are all numbers that leave the simulator."""
    number = to_float(value)
    try:
        return struct.unpack("<f", struct.pack("<f", number))[0]
    except OverflowError:
        raise TypeError("a number that single precision can hold") from None


_RESULTS: tuple[tuple[str, Callable[[Any], Any]], ...] = (
    ("integers", to_list(to_int)),
    ("floats", to_list(_to_float32)),
    ("strings", to_list(to_text)),
    ("buffer", to_bytes),
)


def check_results(function: str, results: list[Any]) -> tuple[list[int], list[float], list[str], bytes]:
    """Return integers, floats, strings and buffer; further results are ignored.

    Raises:
        ScriptError: there are fewer than four results, or one has the wrong type.
    """
    names = ", ".join(name for name, _ in _RESULTS)
    if len(results) < len(_RESULTS):
        raise ScriptError(
            f"{function} returned {len(results)} values, but must return four: {names}; return {{}}, {{}}, {{}}, '' "
            "when there is nothing to say"
        )
    checked: list[Any] = []
    for index, ((name, convert), value) in enumerate(zip(_RESULTS, results, strict=False), 1):
        try:
            checked.append(convert(value))
        except TypeError as problem:
            raise ScriptError(
                f"{function} returned {describe(value)} as result {index} ({name}), which must be {problem}"
            ) from None
    if len(checked[3]) > MAX_BYTES:
        raise ScriptError(f"{function} returned a buffer of {len(checked[3])} bytes; at most {MAX_BYTES}")
    ints, floats, texts, buffer = checked
    return ints, floats, texts, buffer
