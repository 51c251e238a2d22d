"""What Python 2 meant and Python 3 has no word for; converted scripts import these names.

``simx-run --print-converted`` shows where. They are spelled py2_ so that none of a script's own is hidden, except
for three built-ins that only moved.
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
    "py2_round",
    "reduce",
    "reload",
]


_HALF_AWAY = Context(prec=1500, rounding=ROUND_HALF_UP)


def py2_divide(a: Any, b: Any) -> Any:
    """``a / b``: rounded down between whole numbers, NumPy's and arrays of them too (PEP 238)."""
    return a // b if _is_whole(a) and _is_whole(b) else a / b


def py2_idivide(a: Any, b: Any) -> Any:
    """``a /= b``: the same, in place where `a` can."""
    if _is_whole(a) and _is_whole(b):
        a //= b
    else:
        a /= b
    return a


def _is_whole(value: Any) -> bool:
    if isinstance(value, Integral):
        return True
    # an array; asked by its dtype, so that a script without NumPy does not pay for an import
    return getattr(getattr(value, "dtype", None), "kind", "") in ("i", "u", "b")


def py2_round(number: Any, ndigits: int = 0) -> Any:
    """``round``: a float, halves away from zero. Python 3 gives an int and rounds halves to even."""
    if not isinstance(number, int | float):
        return builtins.round(number, ndigits)
    if not math.isfinite(number):
        return float(number)
    # in decimal digits, of which a float has finitely many: a half is then exactly one, as it was in Python 2.7
    return float(Decimal(number).quantize(Decimal((0, (1,), -ndigits)), context=_HALF_AWAY))


def py2_cmp(a: Any, b: Any) -> int:
    """``cmp``: -1, 0 or 1."""
    return (a > b) - (a < b)


def py2_key(compare: Callable[[Any, Any], int]) -> Callable[[Any], Any]:
    """A sort key from the comparison that ``sort`` and ``sorted`` took."""
    return functools.cmp_to_key(compare)


def py2_join(words: Any, separator: str = " ") -> str:
    """``string.join``."""
    return separator.join(words)


def py2_code(code: Any) -> Any:
    """What ``exec`` was given, text of Python 2 converted; a code object stays what it is."""
    return _code_of(code) if isinstance(code, str) else code


@functools.lru_cache(256)  # such texts are often executed in a loop
def _code_of(text: str) -> CodeType | str:
    from .launch.python2.convert import CannotConvert, to_python3  # only scripts that execute text pay for it

    try:
        return to_python3(text, "<string>").code
    except CannotConvert:
        return text  # exec says what is wrong with it


def py2_file(path: str) -> CodeType:
    """The file that ``execfile`` names, converted."""
    from pathlib import Path

    from .launch.python2.convert import decode, to_python3

    return to_python3(decode(Path(path).read_bytes()), path).code
