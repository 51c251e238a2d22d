"""What a terminal can show: colours, and the characters of its encoding; and what a closed pipe does to a program.

NO_COLOR switches colours off (no-color.org), FORCE_COLOR on (force-color.org); NO_COLOR wins.
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
        """Use colours on this stream if it is a terminal that can show them, or if FORCE_COLOR is set."""
        self.is_on = _has_colours(stream)

    def __call__(self, text: str, colour: str) -> str:
        """`text` in one of COLOURS; surrounding blanks count as text, so columns can be filled before."""
        return f"\x1b[{COLOURS[colour]}m{text}\x1b[0m" if self.is_on and text else text


def _has_colours(stream: TextIO) -> bool:
    if os.environ.get("NO_COLOR"):
        return False
    if os.environ.get("FORCE_COLOR"):
        return True
    is_terminal = bool(getattr(stream, "isatty", lambda: False)())
    return is_terminal and os.environ.get("TERM") != "dumb" and _reads_codes(stream)


def _reads_codes(stream: TextIO) -> bool:
    """Whether the terminal takes SGR codes. A console of Windows does once it was told to (SetConsoleMode)."""
    if sys.platform != "win32":
        return True
    import ctypes
    import msvcrt

    enable_virtual_terminal_processing = 4
    console = ctypes.c_void_p(msvcrt.get_osfhandle(stream.fileno()))
    mode = ctypes.c_ulong()
    kernel = ctypes.windll.kernel32
    return bool(
        kernel.GetConsoleMode(console, ctypes.byref(mode))
        and kernel.SetConsoleMode(console, mode.value | enable_virtual_terminal_processing)
    )
