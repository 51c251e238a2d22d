"""Follow the frames of a WebSocket, to know how much of a message has come: viser keeps it until it is complete."""

from __future__ import annotations

LARGEST_MESSAGE = 32 << 20
"""Bytes of a browser's message; the largest are images of the page that a recording asks for."""

_CODES = frozenset((0, 2, 8, 9, 10))
"""Continued, binary, end, ping, pong. viser takes no text."""

_LONGEST_HEAD = 14
_LENGTH_END = {126: 4, 127: 10}


class BadFrame(ValueError):
    """A frame that no browser sends to viser, or a message of more than `LARGEST_MESSAGE` bytes."""


class MessageSize:
    """Counts one direction of a connection."""

    def __init__(self) -> None:
        """Start with the first byte behind the heads."""
        self._head = b""
        """A part of a frame's head."""

        self._left = 0
        """Bytes of the present frame that are still to come."""

        self._is_last = True
        """The present frame is the last one of its message."""

        self._announced = 0
        """Bytes of the frames of the present message, with the present one."""

        self.count = 0
        """Complete messages, without empty ones."""

        self.frames = 0

    def add(self, data: bytes) -> int:
        """Return how many bytes have come of the message that is not complete. Raises BadFrame."""
        data, self._head = self._head + data, b""
        place, end = 0, len(data)
        while True:
            taken = min(self._left, end - place)
            self._left -= taken
            place += taken
            if self._announced and not self._left and self._is_last:
                self._announced = 0
                self.count += 1
            if self._left or place == end:
                break
            size = self._begin(data, place)
            if not size:
                self._head = data[place:]
                break
            place += size
        return self._announced - self._left + len(self._head)

    def _begin(self, data: bytes, place: int) -> int:
        """Read the head of a frame; return its bytes, 0 if it is not complete. Raises BadFrame."""
        left = len(data) - place
        if left < 2:
            return 0
        first, second = data[place], data[place + 1]
        length = second & 0x7F
        length_end = _LENGTH_END.get(length, 2)
        size = length_end + (4 if second & 0x80 else 0)
        if left < size:
            return 0
        if length_end > 2:
            length = int.from_bytes(data[place + 2 : place + length_end], "big")
        if first & 0x7F not in _CODES:  # bits above the code mean compression, to which viser does not agree
            raise BadFrame("a frame of text or of compressed data")
        is_control = first & 0x08
        if is_control and length > 125:
            raise BadFrame("a control frame of more than 125 bytes")
        self.frames += 1
        self._left = length
        if not is_control or not self._announced:  # it comes between the frames of a message
            self._is_last = bool(first & 0x80)
            self._announced += length
            if self._announced > LARGEST_MESSAGE:
                raise BadFrame(f"a message of more than {LARGEST_MESSAGE} bytes")
        return size
