"""A newest message in shared memory: one process replaces it, the other reads it whenever it likes.

The number of the message is odd while it is written. A reader that sees the same even number before and after copying
has copied one whole message; the checksum holds where a system or processor breaks that order.
"""

from __future__ import annotations

import mmap
import os
import platform
import struct
import threading
import zlib

_HEAD = struct.Struct("@QQQ")
"""Number of the message, its length, its checksum. Numbers in native order are written at once, others byte by byte."""

_SENT = struct.Struct("@Q")
_SENT_AT = _HEAD.size
"""Place of the number of frames that the server has sent: a client with as many need not read the socket."""

_ENDED = (1 << 64) - 1
"""That number after the end of the connection."""

_BEGIN = _SENT_AT + _SENT.size

HEAD = slice(0, _BEGIN)
"""Place of what changes with each message and each frame, and at the end of the connection."""

SENT, ENDED = slice(_SENT_AT, _BEGIN), _SENT.pack(_ENDED)
"""Place of the number of frames, and what is there after the end of the connection."""

_PAGE = mmap.PAGESIZE

_REORDERS = platform.machine().lower() not in ("x86_64", "amd64", "i386", "i686")
"""Whether processors of this kind may reorder accesses to memory; those of Intel and AMD keep the order of writes, and
that of reads."""

_MOST_TRIES = 1000
"""Attempts to read a message that is being replaced, which takes microseconds."""


class MemoryWriter:
    """The writing process's side. For one thread at a time."""

    def __init__(self, room: int) -> None:
        """Make the memory. Raises OSError: there is none, or no file descriptor.

        Args:
            room: size of the longest message in bytes, at least.
        """
        import fcntl  # Windows has neither this nor the lane

        size = -(-(_BEGIN + room) // _PAGE) * _PAGE
        self.room = size - _BEGIN
        self.file = os.memfd_create("simx", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
        """Descriptor for the other process; `pass_on` closes it here."""

        try:
            os.ftruncate(self.file, size)
            # A reader that shortens the memory would end the writer with a signal.
            fcntl.fcntl(
                self.file, fcntl.F_ADD_SEALS, fcntl.F_SEAL_SHRINK | fcntl.F_SEAL_GROW | fcntl.F_SEAL_SEAL
            )
            self._memory = mmap.mmap(self.file, size)
        except BaseException:
            os.close(self.file)
            raise
        self._order = threading.Lock()
        self._number = 0
        self.sent = 0
        """Frames that were counted."""

    def write(self, payload: bytes) -> None:
        """Replace the message; it must not be longer than `room`."""
        memory, length = self._memory, len(payload)
        checksum = zlib.crc32(payload)  # before the number is odd: readers have to wait while it is
        _HEAD.pack_into(memory, 0, self._number + 1, length, 0)
        if _REORDERS:
            _in_order(self._order)
        memory[_BEGIN : _BEGIN + length] = payload
        if _REORDERS:
            _in_order(self._order)
        self._number += 2
        _HEAD.pack_into(memory, 0, self._number, length, checksum)

    def count(self, frames: int) -> None:
        """Note how many frames have been sent."""
        self.sent = frames
        _SENT.pack_into(self._memory, _SENT_AT, frames)

    def end(self) -> None:
        """Note the end of the connection for the other process."""
        self.count(_ENDED)

    def close(self) -> None:
        """Unmap the memory; the other process keeps it."""
        self._memory.close()


class MemoryReader:
    """The reading process's side. For one thread at a time."""

    def __init__(self, file: int) -> None:
        """Map the memory behind a file descriptor, which can be closed then. Raises OSError, ValueError."""
        self.memory = mmap.mmap(file, 0, access=mmap.ACCESS_READ)
        """All of it; see `HEAD`."""

        if len(self.memory) <= _BEGIN:
            raise ValueError("the shared memory is too small")
        self._order = threading.Lock()
        self._seen = 0

    def newest(self) -> bytes | None:
        """Return the newest message; None if there is none, or it was returned before."""
        memory = self.memory
        for _ in range(_MOST_TRIES):
            number, length, checksum = _HEAD.unpack_from(memory, 0)
            if number == self._seen:
                return None
            if number & 1:
                continue
            if _REORDERS:
                _in_order(self._order)
            payload = memory[_BEGIN : _BEGIN + length]
            if _REORDERS:
                _in_order(self._order)
            if _HEAD.unpack_from(memory, 0)[0] == number and zlib.crc32(payload) == checksum:
                self._seen = number
                return payload
        return None  # the writer was stopped in the middle: the next call tries again

    def is_taken(self, head: bytes, frames: int) -> bool:
        """Return whether a head says that the newest message was returned, and that this many frames have been sent."""
        number: int = _HEAD.unpack_from(head)[0]
        sent: int = _SENT.unpack_from(head, _SENT_AT)[0]
        return number == self._seen and sent == frames

    @property
    def sent(self) -> int:
        """Return how many frames have been sent."""
        count: int = _SENT.unpack_from(self.memory, _SENT_AT)[0]
        return count

    @property
    def has_ended(self) -> bool:
        """Return whether the writing process has closed the connection."""
        return bool(_SENT.unpack_from(self.memory, _SENT_AT)[0] == _ENDED)


def _in_order(lock: threading.Lock) -> None:
    """Have other processors see all accesses to memory before this call before those after it.

    Processors of ARM reorder them. A lock orders what is inside it; the order of two uses of one lock orders the rest.
    """
    with lock:
        pass
    with lock:
        pass
