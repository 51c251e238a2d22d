"""Follow the frames of a WebSocket, to know how much of a message has come: viser keeps it until it is complete."""

from __future__ import annotations

LARGEST_MESSAGE = 32 << 20
"""Bytes of a browser's message; the largest are images of the page that a recording asks for."""


class TooLong(ValueError):
    """A message has more than `LARGEST_MESSAGE` bytes."""


class MessageSize:
    """Counts one direction of a connection."""

    def __init__(self) -> None:
        """Start with the first byte behind the heads."""
        self._head = bytearray()
        self._left = 0
        """Bytes of the present frame that are still to come."""

        self._is_last = True
        """The present frame is the last one of its message."""

        self._announced = 0
        """Bytes of the frames of the present message, with the present one."""

        self.count = 0
        """Complete messages, without empty ones."""

    def add(self, data: bytes) -> int:
        """Return how many bytes have come of the message that is not complete. Raises TooLong."""
        place = 0
        while True:
            taken = min(self._left, len(data) - place)
            self._left -= taken
            place += taken
            if self._announced and not self._left and self._is_last:
                self._announced = 0
                self.count += 1
            if place == len(data):
                return self._announced - self._left + len(self._head)
            self._head.append(data[place])
            place += 1
            self._begin()

    def _begin(self) -> None:
        """Read the head of a frame, if it is complete."""
        head = self._head
        if len(head) < 2:
            return
        code, length_end = head[1] & 0x7F, 2 + {126: 2, 127: 8}.get(head[1] & 0x7F, 0)
        if len(head) < length_end + (4 if head[1] & 0x80 else 0):
            return
        self._left = code if length_end == 2 else int.from_bytes(head[2:length_end], "big")
        is_control = bool(head[0] & 0x08)  # comes between the frames of a message, and has 125 bytes at most
        if not is_control or self._announced == 0:
            self._is_last = bool(head[0] & 0x80)
            self._announced += self._left
        head.clear()
        if self._announced > LARGEST_MESSAGE or (is_control and self._left > 125):
            raise TooLong(f"a message of more than {LARGEST_MESSAGE} bytes")
