"""The output of a program as lines in bounds, without what would control a terminal; and the line of an error in it."""

from __future__ import annotations

import codecs
import re
from collections import deque
from itertools import islice
from typing import Any

MOST_LINES = 2000
"""Lines that are kept, of which the oldest go first."""

MOST_LINE = 2000
"""Characters of a line; the rest is left out."""

MOST_KEPT = 400_000
"""Characters of all kept lines."""

MOST_SENT = 50_000
"""Characters of an answer to a browser, which asks again for the rest."""

CUT = " … the rest of this line is left out"

_ESCAPES = re.compile(r"\x1b(?:\[[0-?]*[ -/]*[@-~]|\][^\x07\x1b]*(?:\x07|\x1b\\)?|[ -/]*[0-~])?")
_CONTROLS = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")
"""Characters that cannot be seen, but tabs; the last two groups turn the direction of text."""


class Output:
    """The lines of one run. Used by one thread."""

    def __init__(self, hidden: str = "") -> None:
        """Start without a line.

        Args:
            hidden: a text that is left out, such as the folder before the names of files.
        """
        self._hidden = hidden
        self._decoder = codecs.getincrementaldecoder("utf-8")("replace")
        self._lines: deque[str] = deque()
        self._size = 0
        self.first = 0
        """Number of the first line that is kept."""

        self._open = ""
        """The start of a line that has not ended."""

        self._is_cut = False
        """The rest of that line is left out."""

    @property
    def count(self) -> int:
        """Return the number of lines that have ended, with those that are not kept."""
        return self.first + len(self._lines)

    def add(self, data: bytes, *, is_last: bool = False) -> None:
        """Take what the program has written.

        Args:
            data: bytes, which may end within a character.
            is_last: the program has ended.
        """
        *ended, rest = self._decoder.decode(data, final=is_last).split("\n")
        if (more := len(ended) - MOST_LINES - 1) > 0:  # they would be dropped again at once
            del ended[:more]
            self.first += more
            self._open, self._is_cut = "", False
        for each in ended:
            self._continue(each)
            self._end()
        self._continue(rest)
        if is_last and self._open:
            self._end()

    def note(self, text: str) -> None:
        """Add a line that is not the program's."""
        if self._open:
            self._end()
        self._keep(text)

    def _continue(self, text: str) -> None:
        if not self._is_cut:
            room = 2 * MOST_LINE - len(self._open)  # escapes take room too
            self._is_cut = len(text) > room
            self._open += text[:room]

    def _end(self) -> None:
        line = self._shown()
        if self._is_cut or len(line) > MOST_LINE:
            line = line[:MOST_LINE] + CUT
        self._open, self._is_cut = "", False
        self._keep(line)

    def _keep(self, line: str) -> None:
        self._lines.append(line)
        self._size += len(line) + 1
        while len(self._lines) > MOST_LINES or self._size > MOST_KEPT:
            self._size -= len(self._lines.popleft()) + 1
            self.first += 1

    def since(self, number: int) -> dict[str, Any]:
        """Return the lines from one on, as many as an answer may have.

        Args:
            number: of the first line that the browser lacks.
        """
        first = max(self.first, min(number, self.count))
        lines: list[str] = []
        left = MOST_SENT
        for line in islice(self._lines, first - self.first, None):
            left -= len(line) + 1
            if left < 0 and lines:
                break
            lines.append(line)
        is_whole = first + len(lines) == self.count
        return {
            "first": first,
            "lines": lines,
            "open": self._shown()[:MOST_LINE] if is_whole else "",
            "has_more": not is_whole,
        }

    def error(self, name: str) -> tuple[int, str]:
        """Return the line of the program in the last traceback, from 1, and the error's text; 0 without one.

        Args:
            name: of the program's file.
        """
        place = re.compile(rf'  File "(?:[^"]*/)?{re.escape(name)}", line (\d{{1,7}})')
        line, text, is_fresh = 0, "", True
        for each in self._lines:
            if each.startswith("Traceback "):
                is_fresh = True
            elif found := place.match(each):
                line, text, is_fresh = int(found[1]), "", False
            elif not is_fresh and not text and each and not each.startswith(" "):
                text = each
        return line, text

    def _shown(self) -> str:
        """Return the open line as a terminal shows it in the end: no controls, and what follows the last return."""
        text = _ESCAPES.sub("", self._open).removesuffix("\r").rpartition("\r")[2]
        text = _CONTROLS.sub("", text)
        return text.replace(self._hidden, "") if self._hidden else text
