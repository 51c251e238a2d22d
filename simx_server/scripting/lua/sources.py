"""Texts that Lua's compiler would work on for long: no hook strikes while it compiles.

Its time grows with the square of the labels, gotos, breaks and ``and``, ``or``, ``elseif`` in a row, so their number is
bounded as the length is.
"""

from __future__ import annotations

import re

LONGEST = 1_000_000
"""Bytes of a script or a module; what ``load`` takes is bounded in `library.lua`."""

MOST_JUMPS = 10_000

_JUMP = re.compile(rb"\b(?:and|break|elseif|goto|or)\b|::")


def too_much(source: bytes) -> str | None:
    """Why a text is not compiled; None if it is."""
    if len(source) > LONGEST:
        return f"a script of more than {LONGEST} bytes cannot be run"
    if len(source) > 2 * MOST_JUMPS and sum(1 for _ in _JUMP.finditer(source)) > MOST_JUMPS:
        return f"a script with more than {MOST_JUMPS} of and, or, elseif, goto, break and :: cannot be run"
    return None
