"""The script's side of the pipes to the server: messages, functions passed to the server, printed text."""

from __future__ import annotations

import io
import os
from collections.abc import Callable
from typing import Any

from python_wire import HEADER, MAX_NUMBERS, MAX_TEXT, Packer, Unpacker

_LINE = 1 << 16
"""Maximum characters of printed text without a line end that are kept in one piece."""


class Link:
    """The two pipes to the server."""

    def __init__(self, reading: int, writing: int) -> None:
        self._reading, self._writing = reading, writing
        self._functions: list[Callable[..., Any]] = []
        self._numbers: dict[int, int] = {}
        self._packer = Packer(self._number_of, MAX_TEXT, MAX_NUMBERS)
        self._unpacker = Unpacker(self.function)

    def function(self, number: int) -> Callable[..., Any]:
        return self._functions[number]

    def _number_of(self, value: Any) -> int:
        """Return the number of a function. Functions passed to the server are never freed, so their `id` stays
        unique.
        """
        if not callable(value):
            raise TypeError(f"a {type(value).__name__} cannot leave the script")
        number = self._numbers.get(id(value))
        if number is None:
            number = self._numbers[id(value)] = len(self._functions)
            self._functions.append(value)
        return number

    def send(self, *message: Any) -> None:
        rest = memoryview(self._packer.pack(list(message)))
        while rest:
            rest = rest[os.write(self._writing, rest) :]

    def receive(self) -> list[Any]:
        text, blobs = self._unpacker.lengths(self._read(HEADER.size))
        return self._unpacker.unpack(self._read(text + blobs), text)

    def _read(self, length: int) -> bytes:
        data = os.read(self._reading, length)
        if len(data) < length:
            parts = [data]
            missing = length - len(data)
            while missing:
                data = os.read(self._reading, min(missing, 1 << 20))
                if not data:
                    os._exit(0)  # the server has ended
                parts.append(data)
                missing -= len(data)
            data = b"".join(parts)
        return data


class Output(io.TextIOBase):
    """Printed text of the script, sent line by line."""

    def __init__(self, link: Link) -> None:
        self._link = link
        self._pending = ""

    def writable(self) -> bool:
        return True

    def write(self, text: str) -> int:
        *lines, self._pending = (self._pending + text).split("\n")
        for line in lines:
            self._link.send("print", line)
        if len(self._pending) > _LINE:
            self.finish()
        return len(text)

    def finish(self) -> None:
        """Send the text that has no line end yet."""
        if self._pending:
            text, self._pending = self._pending, ""
            self._link.send("print", text)
