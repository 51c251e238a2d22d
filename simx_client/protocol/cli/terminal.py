"""Capabilities of a terminal: colours, and the characters of its encoding; and handling of a closed pipe.

NO_COLOR switches colours off (no-color.org), FORCE_COLOR on (force-color.org); NO_COLOR has precedence.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from typing import TextIO

from .exit_codes import UNREAD

COLOURS = {"red": "31", "green": "32", "yellow": "33", "blue": "34", "grey": "90", "bold": "1"}
"""SGR codes of ECMA-48; 90 is bright black, which all present terminals support."""


def print_what_can_be() -> None:
    """Print ``?`` for a character that stdout's encoding lacks, instead of raising an exception.

    For programs of this project only: a pipe on Windows has some 250 characters, and names of objects may
    contain any.
    """
    reconfigure = getattr(sys.stdout, "reconfigure", None)  # a program may have replaced stdout
    if reconfigure is not None:
        reconfigure(errors="replace")


def while_read(work: Callable[[], int]) -> int:
    """Run a function that prints; return the exit code. A closed pipe, as behind `` head``, ends it silently."""
    try:
        code = work()
        sys.stdout.flush()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # for output still in the buffer
        return UNREAD
    return code


class Paint:
    """Colours words, or returns them unchanged."""

    def __init__(self, stream: TextIO) -> None:
        """Use colours on this stream if it is a terminal that can show them, or if FORCE_COLOR is set."""
        self.is_on = _has_colours(stream)

    def __call__(self, text: str, colour: str) -> str:
        """Return `text` in one of COLOURS; surrounding blanks are kept, so columns can be filled before."""
        return f"\x1b[{COLOURS[colour]}m{text}\x1b[0m" if self.is_on and text else text


def _has_colours(stream: TextIO) -> bool:
    if os.environ.get("NO_COLOR"):
        return False
    if os.environ.get("FORCE_COLOR"):
        return True
    is_terminal = bool(getattr(stream, "isatty", lambda: False)())
    return is_terminal and os.environ.get("TERM") != "dumb" and _reads_codes(stream)


def _reads_codes(stream: TextIO) -> bool:
    """Return whether the terminal takes SGR codes. A console of Windows does after SetConsoleMode."""
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
