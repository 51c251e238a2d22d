"""Texts that Lua's compiler would need long for: no hook runs while it compiles.

Its time grows with the square of the labels, gotos, breaks and ``and``, ``or``, ``elseif`` in a row, so their number
is limited, as is the length.
"""

from __future__ import annotations

import re

LONGEST = 1_000_000
"""Maximum bytes of a script or a module; `library.lua` limits the texts for ``load``."""

MOST_JUMPS = 10_000

_JUMP = re.compile(rb"\b(?:and|break|elseif|goto|or)\b|::")


def too_much(source: bytes) -> str | None:
    """Return why a text is not compiled; None if it is."""
    if len(source) > LONGEST:
        return f"a script of more than {LONGEST} bytes cannot be run"
    if len(source) > 2 * MOST_JUMPS and sum(1 for _ in _JUMP.finditer(source)) > MOST_JUMPS:
        return f"a script with more than {MOST_JUMPS} of and, or, elseif, goto, break and :: cannot be run"
    return None
