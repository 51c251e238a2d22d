"""Count the turns of a script's loops, so that a coroutine can give way inside a loop without calls of ``sim``.

V-REP interrupted a script's thread by the clock, wherever it was. A hook of Lua can stop a coroutine but cannot make it
yield, and a clock makes no two runs alike. So a script's text is compiled with a counter in each loop, before each
``goto`` and before each tail call: nothing else can run for ever without growing the stack. The counter is two
upvalues of the chunk, no line moves, and error messages stay the same. What is done when it runs out: `sandbox.lua`.
"""

from __future__ import annotations

import re

COUNTER, ACTION = b"simx_left", b"simx_turn"
"""Names of the two upvalues: the turns that are left, and the function that is called when there are none."""

_COUNT = b" %b=%b-1 if %b<0 then %b()end " % (COUNTER, COUNTER, COUNTER, ACTION)

_BEGINNING, _END = b"local %b,%b return function(...) " % (COUNTER, ACTION), b"\nend"

_TOKEN = re.compile(
    rb"""--\[(=*)\[.*?\]\1\]|--[^\r\n]*+|\[(=*)\[.*?\]\2\]"""
    rb"""|"(?:[^"\\]++|\\\r\n|\\.)*+"|'(?:[^'\\]++|\\\r\n|\\.)*+'"""
    rb"""|\b(?P<word>do|end|for|function|goto|if|repeat|return|until|while)\b""",
    re.DOTALL,
)

_CALL = re.compile(rb"""\s*+(?:--|\(|[A-Za-z_]\w*+(?:\s*+[.:]\s*+\w++)*+\s*+(?:--|[(\[{"']|[.:]\s*+--))""")
"""What follows ``return`` where it may be a tail call; a comment may hide one."""


def with_turns(source: bytes) -> bytes | None:
    """The text of a function that gives the chunk with its turns counted; None: none to count, or it names one.

    Args:
        source: a text that Lua compiles; of any other the result may be anything.
    """
    if COUNTER in source or ACTION in source:
        return None
    pieces: list[bytes] = []
    blocks: list[bool] = []
    """The open blocks; True: of a loop whose ``do`` is yet to come."""
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
