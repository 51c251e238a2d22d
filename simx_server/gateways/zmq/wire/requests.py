"""Read the messages of one connection: the fields that all of them have are read once.

A program's client sends the same fields behind each function and its arguments: half of the bytes of a short message.
"""

from __future__ import annotations

import struct
from typing import Any

from .messages import LONGEST_NAME, Reader, Request, WireError, read_request

_LONGEST = 1 << 12
"""Bytes of a message that is compared with the one before. In a longer one the arguments take most of the time."""

_FUNCTION, _ARGUMENTS = b"\x64func", b"\x64args"

_MAP, _LARGEST_MAP = 0xA0, 0xB7
"""First bytes of an empty map, and of the largest one whose length is in this byte."""

_READ = frozenset(("func", "args", "eval"))


class Requests:
    """Reads the messages of one connection."""

    def __init__(self) -> None:
        self._head = self._tail = b""
        """Bytes of the newest short message before its function, and behind its arguments."""

    def read(self, payload: bytes) -> Request:
        """Return what `read_request` returns; raise as it does."""
        if len(payload) > _LONGEST:
            return read_request(payload)
        if self._tail and payload.startswith(self._head) and payload.endswith(self._tail):
            found = _between(payload, len(self._head))
            if found is not None and found[1] == len(payload) - len(self._tail):
                return found[0]
        request = read_request(payload)
        self._learn(payload)
        return request

    def _learn(self, payload: bytes) -> None:
        """Note the fields around function and arguments of a valid message, if others cannot take their place."""
        self._head, self._tail = payload[: 1 + len(_FUNCTION)], b""
        fields = payload[0] - _MAP - 2
        if self._head[1:] != _FUNCTION or not 0 < fields <= _LARGEST_MAP - _MAP:
            return
        found = _between(payload, len(self._head))
        if found is None:
            return
        tail = payload[found[1] :]
        others: dict[Any, Any] = Reader(bytes((_MAP + fields,)) + tail).whole()
        if _READ.isdisjoint(others):
            self._tail = tail


def _between(payload: bytes, start: int) -> tuple[Request, int] | None:
    """Return function and arguments of a message, and where they end; None if they have another form."""
    reader = Reader(payload, start)
    try:
        function = reader.item(1)
        if not payload.startswith(_ARGUMENTS, reader.place):
            return None
        reader.place += len(_ARGUMENTS)
        arguments = reader.item(1)
    except (WireError, struct.error, IndexError):
        return None
    if not function or function.__class__ is not bytes or len(function) > LONGEST_NAME:
        return None
    if arguments.__class__ is not list:
        return None
    return Request(function.decode("utf-8", "replace"), arguments), reader.place
