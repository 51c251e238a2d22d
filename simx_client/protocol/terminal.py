"""What a terminal can show: colours, unless NO_COLOR is set (no-color.org), and the characters of its encoding.

And what becomes of a program when the other end of its pipe closes.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from typing import TextIO

from .exit_codes import UNREAD

COLOURS = {"red": "31", "green": "32", "yellow": "33", "blue": "34", "grey": "90", "bold": "1"}
"""SGR codes of ECMA-48; 90 is bright black, which all terminals of today know."""


def print_what_can_be() -> None:
    """Have stdout take ``?`` for a character that its encoding lacks, in place of an exception.

    For programs of our own only: a pipe on Windows knows some 250 characters, and names of objects may have any.
    """
    reconfigure = getattr(sys.stdout, "reconfigure", None)  # not where a program has put something else there
    if reconfigure is not None:
        reconfigure(errors="replace")


def while_read(work: Callable[[], int]) -> int:
    """Do what prints. When nobody reads on, as behind ``| head``, it ends without a word. Returns the exit code."""
    try:
        code = work()
        sys.stdout.flush()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # for what is still in the buffer
        return UNREAD
    return code


class Paint:
    """Colours words, or leaves them as they are."""

    def __init__(self, stream: TextIO) -> None:
        """Colours are for this stream: none unless it is a terminal that can show them."""
        self.is_on = (
            not os.environ.get("NO_COLOR")
            and os.environ.get("TERM") != "dumb"
            and bool(getattr(stream, "isatty", lambda: False)())
        )

    def __call__(self, text: str, colour: str) -> str:
        """`text` in one of COLOURS; surrounding blanks count as text, so columns can be filled before."""
        return f"\x1b[{COLOURS[colour]}m{text}\x1b[0m" if self.is_on and text else text
