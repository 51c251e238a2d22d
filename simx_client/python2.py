"""Functions of Python 2 that Python 3 does not have; converted scripts import these names.

``simx-run --print-converted`` shows where. The prefix py2_ avoids collisions with names of the script, except
for three built-ins that only moved to other modules.
"""

from __future__ import annotations

import builtins
import functools
import math
from collections.abc import Callable
from decimal import ROUND_HALF_UP, Context, Decimal
from functools import reduce
from importlib import reload
from numbers import Integral
from sys import intern
from types import CodeType
from typing import Any

__all__ = [
    "intern",
    "py2_cmp",
    "py2_code",
    "py2_divide",
    "py2_file",
    "py2_idivide",
    "py2_join",
    "py2_key",
    "py2_next",
    "py2_round",
    "reduce",
    "reload",
]


_HALF_AWAY = Context(prec=1500, rounding=ROUND_HALF_UP)


def py2_divide(a: Any, b: Any) -> Any:
    """Compute ``a / b``, rounded down between whole numbers and NumPy arrays of them (PEP 238)."""
    return a // b if _is_whole(a) and _is_whole(b) else a / b


def py2_idivide(a: Any, b: Any) -> Any:
    """Compute ``a /= b`` with the same rule, in place where `a` supports it."""
    if _is_whole(a) and _is_whole(b):
        a //= b
    else:
        a /= b
    return a


def _is_whole(value: Any) -> bool:
    if isinstance(value, Integral):
        return True
    # an array: test its dtype, so that a script without NumPy does not import it
    return getattr(getattr(value, "dtype", None), "kind", "") in ("i", "u", "b")


def py2_round(number: Any, ndigits: int = 0) -> Any:
    """Round as Python 2: return a float, halves away from zero. Python 3 returns an int and rounds halves to
    even."""
    if not isinstance(number, int | float):
        return builtins.round(number, ndigits)
    if not math.isfinite(number):
        return float(number)
    # in decimal digits, of which a float has finitely many: a half is then exactly one, as it was in Python 2.7
    return float(Decimal(number).quantize(Decimal((0, (1,), -ndigits)), context=_HALF_AWAY))


def py2_cmp(a: Any, b: Any) -> int:
    """Compare as ``cmp``: return -1, 0 or 1."""
    return (a > b) - (a < b)


def py2_key(compare: Callable[[Any, Any], int]) -> Callable[[Any], Any]:
    """Return a sort key for the comparison that ``sort`` and ``sorted`` took."""
    return functools.cmp_to_key(compare)


def py2_next(value: Any) -> Any:
    """Return ``value.next``: an attribute of this name, or the method of an iterator."""
    return value.next if hasattr(value, "next") else value.__next__


def py2_join(words: Any, separator: str = " ") -> str:
    """Join words as ``string.join``."""
    return separator.join(words)


def py2_code(code: Any) -> Any:
    """Return an argument of ``exec``: text converted from Python 2, a code object unchanged."""
    return _code_of(code) if isinstance(code, str) else code


@functools.lru_cache(256)  # loops often execute the same text
def _code_of(text: str) -> CodeType | str:
    from .old_python.convert import CannotConvert, to_python3  # only scripts that execute text pay for it

    try:
        return to_python3(text, "<string>").code
    except CannotConvert:
        return text  # exec says what is wrong with it


def py2_file(path: str) -> CodeType:
    """Return the converted code of a file that ``execfile`` names."""
    from pathlib import Path

    from .old_python.convert import decode, to_python3

    return to_python3(decode(Path(path).read_bytes()), path).code
