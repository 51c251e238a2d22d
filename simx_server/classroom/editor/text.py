"""The text of a seat's program: in memory for browsers, in a file for the next week."""

from __future__ import annotations

import contextlib
import os
import stat
import time
from pathlib import Path

from .plan import MOST_TEXT


class NotSaved(Exception):
    """A text cannot be kept; the message gives the reason."""


class ProgramText:
    """The newest text of one program. Used by one thread."""

    def __init__(self, folder: Path, name: str, start: str) -> None:
        """Read the file, or start with a text.

        Args:
            folder: holds the file; it is made with the first text.
            name: of the file.
            start: the text without a file.
        """
        self._folder, self._file = folder, folder / name
        self.text = start
        self.version = int(time.time())
        """Of the text: each new one has the next number, also after a start of the page."""

        self._is_saved = False
        with contextlib.suppress(OSError, UnicodeError):
            self.text = self._read()
            self._is_saved = True

    def save(self, body: bytes) -> int:
        """Keep a text, which a browser has sent as UTF-8. Returns its version.

        Raises:
            NotSaved: it is not a text, it is too large, or the disk does not take it. In the last case it is kept in
                memory.
        """
        if len(body) > MOST_TEXT:
            raise NotSaved(f"a program has at most {MOST_TEXT} bytes")
        try:
            text = body.decode()
        except UnicodeDecodeError:
            raise NotSaved("a program is a text in UTF-8") from None
        if "\0" in text:
            raise NotSaved("a program has no characters with the number 0")
        if text == self.text and self._is_saved:
            return self.version
        self.version += text != self.text
        self.text, self._is_saved = text, False
        try:
            self._write(body)
            self._is_saved = True
        except OSError as problem:
            raise NotSaved(f"the file of the program cannot be written: {problem.strerror}") from None
        return self.version

    def _read(self) -> str:
        descriptor = os.open(self._file, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
        with os.fdopen(descriptor, "rb") as stream:
            if not stat.S_ISREG(os.fstat(descriptor).st_mode):
                raise IsADirectoryError
            return stream.read(MOST_TEXT).decode()

    def _write(self, body: bytes) -> None:
        """Replace the file in one step: a full disk must not cost the text of before."""
        self._folder.mkdir(parents=True, exist_ok=True)
        new = self._file.with_name(f".{self._file.name}.new")
        with contextlib.suppress(FileNotFoundError):
            new.unlink()
        try:
            descriptor = os.open(new, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW, 0o600)
            with open(descriptor, "wb") as stream:
                stream.write(body)
            os.replace(new, self._file)
        finally:
            new.unlink(missing_ok=True)
