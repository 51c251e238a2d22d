"""Bound the messages of browsers before viser makes values of them.

A byte of msgpack may be a list, which takes 250 ns and 90 bytes, and viser keeps the parts of files that nothing has
asked for. The page's messages have a few dozen values each; images of the page are one long one.
"""

from __future__ import annotations

from collections.abc import Mapping

MOST_VALUES = 4096
"""Values of a message, those within others too."""

REFUSED = frozenset(("FileTransferStartUpload", "FileTransferPart"))
"""Types of messages that no part of the page asks for, and that fill the memory."""


class BadMessage(ValueError):
    """A message that the page never sends."""


def check(data: bytes) -> None:
    """Look at a message of msgpack without making its values.

    Raises:
        BadMessage: it has too many values, or ends too early.
    """
    if len(data) <= MOST_VALUES:
        return
    place, left, end = 0, 1, len(data)
    seen = 0
    while left:
        if place >= end:
            raise BadMessage("a message that ends within a value")
        left -= 1
        seen += 1
        code = data[place]
        place += 1
        if code < 0x80 or code >= 0xE0:  # a small number
            continue
        if code < 0xA0:
            left += (code & 0x0F) << (code < 0x90)  # a map has two values for each of its entries
        elif code < 0xC0:
            place += code & 0x1F
        elif code in _FIXED:
            place += _FIXED[code]
        elif code in _LENGTHS:
            width, more, values = _LENGTHS[code]
            length = int.from_bytes(data[place : place + width], "big")
            place += width + more
            if values:
                left += values * length
            else:
                place += length
        if seen + left > MOST_VALUES:
            raise BadMessage(f"a message of more than {MOST_VALUES} values")


_FIXED: Mapping[int, int] = {
    0xCA: 4, 0xCB: 8, 0xCC: 1, 0xCD: 2, 0xCE: 4, 0xCF: 8, 0xD0: 1, 0xD1: 2, 0xD2: 4, 0xD3: 8,
    0xD4: 2, 0xD5: 3, 0xD6: 5, 0xD7: 9, 0xD8: 17,
}  # fmt: skip
"""Bytes behind the code of numbers and of short extension types."""

_LENGTHS: Mapping[int, tuple[int, int, int]] = {
    0xC4: (1, 0, 0), 0xC5: (2, 0, 0), 0xC6: (4, 0, 0),
    0xC7: (1, 1, 0), 0xC8: (2, 1, 0), 0xC9: (4, 1, 0),
    0xD9: (1, 0, 0), 0xDA: (2, 0, 0), 0xDB: (4, 0, 0),
    0xDC: (2, 0, 1), 0xDD: (4, 0, 1), 0xDE: (2, 0, 2), 0xDF: (4, 0, 2),
}  # fmt: skip
"""By code: bytes of the length, bytes behind it that it does not count, and values for each of what it counts."""
