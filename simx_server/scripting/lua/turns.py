"""Count the iterations of a script's loops, so that a coroutine can switch inside a loop without calls of ``sim``.

V-REP interrupted a script's thread by the clock, at any point. A hook of Lua can stop a coroutine but cannot make it
yield, and with a clock no two runs are alike. So a script's text is compiled with a counter in each loop, before each
``goto`` and before each tail call: no other code can run for ever without growing the stack. The counter is two
upvalues of the chunk, line numbers stay, and error messages stay the same. `sandbox.lua` defines the action at zero.

A counter makes a short loop three times as slow, so a script that can make no coroutine has none.
"""

from __future__ import annotations

import re
from functools import lru_cache

COUNTER, ACTION = b"simx_left", b"simx_turn"
"""Names of the two upvalues: the remaining iterations, and the function that is called at zero."""

_COUNT = b" %b=%b-1 if %b<0 then %b()end " % (COUNTER, COUNTER, COUNTER, ACTION)

_BEGINNING, _END = b"local %b,%b return function(...) " % (COUNTER, ACTION), b"\nend"

_COROUTINES = re.compile(
    rb"hread|coroutine|_G\b|_ENV\b|\b(?:debug|dofile|getfenv|include|load|loadfile|loadstring|package|setfenv)\b"
)
"""Words without which a text can make no coroutine; the API's functions that wait need one too."""

_REQUIRE = re.compile(rb"""\brequire\b(?!\s*\(?\s*(['"])sim\w*(?:-\d)?\1\s*+(?!\.\.))""")
"""Loads a module other than a namespace of the simulator: its functions may make coroutines of the text's own."""

_TOKEN = re.compile(
    rb"""--\[(=*)\[.*?\]\1\]|--[^\r\n]*+|\[(=*)\[.*?\]\2\]"""
    rb"""|"(?:[^"\\]++|\\\r\n|\\.)*+"|'(?:[^'\\]++|\\\r\n|\\.)*+'"""
    rb"""|\b(?P<word>do|end|for|function|goto|if|repeat|return|until|while)\b""",
    re.DOTALL,
)

_CALL = re.compile(rb"""\s*+(?:--|\(|[A-Za-z_]\w*+(?:\s*+[.:]\s*+\w++)*+\s*+(?:--|[(\[{"']|[.:]\s*+--))""")
"""Text after ``return`` where it may be a tail call; a comment may hide one."""


@lru_cache(maxsize=16)  # each start of the simulation needs it for the same texts
def may_make_coroutines(source: bytes) -> bool:
    """Return False for a text that surely makes no coroutine, so that its loops need no counters."""
    return bool(_COROUTINES.search(source) or _REQUIRE.search(source))


def with_turns(source: bytes) -> bytes | None:
    """Return the text of a function that returns the chunk with counters; None: no loops, or the text uses their
    names.

    Args:
        source: a text that Lua compiles; for any other text the result is undefined.
    """
    if COUNTER in source or ACTION in source:
        return None
    pieces: list[bytes] = []
    blocks: list[bool] = []
    """The open blocks; True: the header of a loop whose ``do`` has not been read yet."""
    done = 0
    for token in _TOKEN.finditer(source):
        place = -1
        match token["word"]:
            case b"while" | b"for":
                blocks.append(True)
            case b"do" if blocks and blocks[-1]:
                blocks[-1] = False
                place = token.end()
            case b"repeat":
                blocks.append(False)
                place = token.end()
            case b"do" | b"if" | b"function":
                blocks.append(False)
            case b"end" | b"until" if blocks:
                blocks.pop()
            case b"goto":
                place = token.start()
            case b"return" if _CALL.match(source, token.end()):
                place = token.start()
            case _:
                pass
        if place >= 0:
            pieces += source[done:place], _COUNT
            done = place
    if not pieces:
        return None
    return b"".join((_BEGINNING, *pieces, source[done:], _END))
