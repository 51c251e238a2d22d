"""Messages on the socket of the lane: each is a frame of a length, a kind and its bytes."""

from __future__ import annotations

import array
import os
import socket
import struct
from collections import deque
from collections.abc import Sequence

MESSAGE = 0
"""Kind of a frame with a batch, a delivery or, as the first frame of a client, its token."""

MEMORY = 1
"""Kind of a frame with the number of a place, whose shared memory comes with it as a file descriptor."""

FILE = 2
"""Kind of a frame with the length of a large message, which comes with it as a file descriptor.

A client whose first frame has this kind takes such messages; older clients send their token as a `MESSAGE`.
"""

MAX_FRAME = 256 << 20
"""Maximum size of a server's message in bytes."""

_HEAD = struct.Struct("<IB")
_PLACE = struct.Struct("<I")
_LENGTH = struct.Struct("<Q")

_CLOSE_ON_EXEC = int(getattr(socket, "MSG_CMSG_CLOEXEC", 0))
"""A plain number: to combine flags of the module takes as long as the call."""

_NO_FILES: Sequence[int] = ()

_FILES_ROOM = 128
"""Bytes for the file descriptors that come with one read; the server sends one with each frame that has any."""


class BadFrame(ValueError):
    """The bytes are not frames, or a frame is too long."""


def frame(payload: bytes) -> bytes:
    """Return a message as a frame."""
    return _HEAD.pack(len(payload), MESSAGE) + payload


def token_frame(token: str) -> bytes:
    """Return the first frame of a client that takes large messages as files."""
    return _HEAD.pack(len(token), FILE) + token.encode()


def file_frame(length: int) -> bytes:
    """Return the frame that brings a message of this length as a file."""
    return _HEAD.pack(_LENGTH.size, FILE) + _LENGTH.pack(length)


def read_file(payload: bytes, file: int) -> bytes:
    """Return the message of a file frame.

    Args:
        payload: the frame's.
        file: the descriptor that came with it; it stays open.

    Raises:
        BadFrame: the length is missing, too large, or not that of the file.
        OSError: the file cannot be read.
    """
    if len(payload) != _LENGTH.size:
        raise BadFrame("a file frame without a length")
    length = int(_LENGTH.unpack(payload)[0])
    if length > MAX_FRAME:
        raise BadFrame(f"a file of {length} bytes; the limit is {MAX_FRAME}")
    message = os.pread(file, length, 0)
    if len(message) != length:
        raise BadFrame(f"a file of {len(message)} bytes in place of {length}")
    return message


def memory_frame(place: int) -> bytes:
    """Return the frame that brings the memory of a place."""
    return _HEAD.pack(_PLACE.size, MEMORY) + _PLACE.pack(place)


def place_of(payload: bytes) -> int:
    """Return the place in the payload of a memory frame. Raises BadFrame."""
    if len(payload) != _PLACE.size:
        raise BadFrame("a memory frame without a place")
    return int(_PLACE.unpack(payload)[0])


def send_with_file(connected: socket.socket, data: bytes, file: int, flags: int = 0) -> int:
    """Send bytes and a file descriptor; return how many bytes were sent. Raises OSError."""
    # socket.send_fds ignores its flags
    rights = (socket.SOL_SOCKET, socket.SCM_RIGHTS, array.array("i", [file]))
    return connected.sendmsg([data], [rights], flags)


def has_unread(connected: socket.socket) -> bool:
    """Return whether the other end has not read all that was sent to it; True if the system does not tell."""
    import fcntl  # Windows has neither this nor the lane
    import termios

    try:
        count = fcntl.ioctl(connected, termios.TIOCOUTQ, bytes(4))
    except OSError:
        return True
    return count != bytes(4)


def receive_with_files(connected: socket.socket, size: int, flags: int = 0) -> tuple[bytes, Sequence[int]]:
    """Receive at most `size` bytes, and the file descriptors that came with them. Raises OSError."""
    data, extra, _, _ = connected.recvmsg(size, _FILES_ROOM, flags | _CLOSE_ON_EXEC)
    if not extra:
        return data, _NO_FILES
    files = array.array("i")
    for level, kind, content in extra:
        if level == socket.SOL_SOCKET and kind == socket.SCM_RIGHTS:
            files.frombytes(content[: len(content) - len(content) % files.itemsize])
    return data, files


class Frames:
    """Divides arriving bytes into frames."""

    def __init__(self, longest: int = MAX_FRAME) -> None:
        """Start without bytes.

        Args:
            longest: maximum size of a payload in bytes.
        """
        self.longest = longest
        self._data = bytearray()
        self.whole: deque[tuple[int, bytes]] = deque()
        """Complete frames that were not taken yet: kind and payload."""

        self.count = 0
        """Complete frames that have arrived."""

    @property
    def held(self) -> int:
        """Return the bytes of the incomplete frame."""
        return len(self._data)

    @property
    def missing(self) -> int:
        """Return how many bytes the incomplete frame still needs; 0 without one, or if its length is unknown."""
        data = self._data
        if len(data) < _HEAD.size:
            return 0
        return _HEAD.size + _HEAD.unpack_from(data)[0] - len(data)

    def add(self, data: bytes) -> None:
        """Add bytes as they arrived.

        Raises:
            BadFrame: a frame has an unknown kind or is too long.
        """
        if not self._data and len(data) >= _HEAD.size:
            length, kind = self._head(data)
            if length == len(data) - _HEAD.size:  # one complete frame: the common case
                self.whole.append((kind, data[_HEAD.size :]))
                self.count += 1
                return
        self._data += data
        begin = 0
        try:
            while len(self._data) - begin >= _HEAD.size:
                length, kind = self._head(self._data, begin)
                end = begin + _HEAD.size + length
                if len(self._data) < end:
                    return
                self.whole.append((kind, bytes(self._data[begin + _HEAD.size : end])))
                self.count += 1
                begin = end
        finally:
            del self._data[:begin]

    def _head(self, data: bytes | bytearray, begin: int = 0) -> tuple[int, int]:
        length, kind = _HEAD.unpack_from(data, begin)
        if length > self.longest:
            raise BadFrame(f"a frame of {length} bytes; the limit is {self.longest}")
        if kind not in (MESSAGE, MEMORY, FILE):
            raise BadFrame(f"a frame of the unknown kind {kind}")
        return length, kind
