"""The short way between a client and a server of one user on one host.

Calls and replies are frames on a UNIX socket: a length and a message. The newest values of the streams are in shared
memory, which is read without a system call and never holds a backlog. The server offers both in its welcome.
"""

from __future__ import annotations

import mmap
import struct
import zlib
from collections import deque

VALUES_SIZE = 1 << 18
"""Bytes of the shared memory; messages that do not fit travel over Zenoh."""

MAX_FRAME = 256 << 20
"""Longest frame in bytes."""

READY = b"ready"
"""First frame of the server, with the descriptor of the shared memory; the client has sent its token before."""

_LENGTH = struct.Struct("<I")
_COUNT = struct.Struct("<Q")
_COUNT_AT = VALUES_SIZE - _COUNT.size
"""Where the memory holds the number of frames that the server has sent: a client need not read the socket in vain."""

_HEAD = struct.Struct("<QII")
"""Number of the message (odd while it is written), its length, its checksum."""


class BadFrame(ValueError):
    """The bytes are not frames, or one is too long."""


def frame(payload: bytes) -> bytes:
    """Return a message with its length in front."""
    return _LENGTH.pack(len(payload)) + payload


class Frames:
    """Divides arriving bytes into frames."""

    def __init__(self, longest: int = MAX_FRAME) -> None:
        """Make it empty; `longest` is the most bytes that a frame may have."""
        self._longest = longest
        self._data = bytearray()
        self.whole: deque[bytes] = deque()
        """Complete frames that nobody has taken yet."""

        self.count = 0
        """Complete frames that have arrived."""

    @property
    def missing(self) -> int:
        """Return how many bytes the frame that has begun still needs; 0 if that is not known."""
        if len(self._data) < _LENGTH.size:
            return 0
        return _LENGTH.size + _LENGTH.unpack_from(self._data)[0] - len(self._data)

    def add(self, data: bytes) -> None:
        """Add bytes as they arrived. Raises BadFrame."""
        if not self._data and len(data) >= _LENGTH.size:
            (length,) = _LENGTH.unpack_from(data)
            if length == len(data) - _LENGTH.size:  # one whole frame, as mostly
                if length > self._longest:
                    raise BadFrame(f"a frame of {length} bytes; at most {self._longest} are read")
                self.whole.append(data[_LENGTH.size :])
                self.count += 1
                return
        self._data += data
        while len(self._data) >= _LENGTH.size:
            (length,) = _LENGTH.unpack_from(self._data)
            if length > self._longest:
                raise BadFrame(f"a frame of {length} bytes; at most {self._longest} are read")
            end = _LENGTH.size + length
            if len(self._data) < end:
                return
            self.whole.append(bytes(self._data[_LENGTH.size : end]))
            self.count += 1
            del self._data[:end]


class ValuesWriter:
    """The server's side of the shared memory. For one thread."""

    def __init__(self, file: int) -> None:
        """Map the memory behind a file descriptor of `VALUES_SIZE` bytes."""
        self._memory = mmap.mmap(file, VALUES_SIZE)
        self._number = self._sent = 0

    def write(self, payload: bytes) -> bool:
        """Replace the newest message; return False if it does not fit."""
        end = _HEAD.size + len(payload)
        if end > _COUNT_AT:
            return False
        memory = self._memory
        _HEAD.pack_into(memory, 0, self._number + 1, 0, 0)
        memory[_HEAD.size : end] = payload
        self._number += 2
        _HEAD.pack_into(memory, 0, self._number, len(payload), zlib.crc32(payload))
        return True

    def count_frame(self) -> None:
        """Count a frame that was sent."""
        self._sent += 1
        _COUNT.pack_into(self._memory, _COUNT_AT, self._sent)

    def close(self) -> None:
        """Note the end for the reader, and unmap the memory."""
        _COUNT.pack_into(self._memory, _COUNT_AT, _ENDED)
        self._memory.close()


class ValuesReader:
    """The client's side of the shared memory."""

    def __init__(self, file: int) -> None:
        """Map the memory behind a file descriptor. Raises OSError, ValueError if it is too small."""
        self._memory = mmap.mmap(file, VALUES_SIZE, access=mmap.ACCESS_READ)
        self._seen = 0

    def newest(self) -> bytes | None:
        """Return the newest message; None if it was returned before.

        A message that is replaced meanwhile has another checksum; the next one is there at once.
        """
        memory = self._memory
        for _ in range(_MOST_TRIES):
            number, length, checksum = _HEAD.unpack_from(memory, 0)
            if number == self._seen or not number:
                return None
            if number & 1 or length > _COUNT_AT - _HEAD.size:
                continue
            payload = memory[_HEAD.size : _HEAD.size + length]
            if zlib.crc32(payload) == checksum and _HEAD.unpack_from(memory, 0)[0] == number:
                self._seen = number
                return payload
        return None

    @property
    def has_ended(self) -> bool:
        """Return whether the server has closed the connection."""
        return self.sent == _ENDED

    @property
    def sent(self) -> int:
        """Return how many frames the server has sent."""
        return _COUNT.unpack_from(self._memory, _COUNT_AT)[0]

    def close(self) -> None:
        """Unmap the memory."""
        self._memory.close()


_ENDED = (1 << 64) - 1
"""Number of sent frames after the end."""

_MOST_TRIES = 100
"""Attempts to read while the server writes; it needs microseconds, unless the system stops it in the middle."""
