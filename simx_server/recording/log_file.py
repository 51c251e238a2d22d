"""The file of a recording: a line that names the format, then blocks of records. ::

    simxlog 1\\n
    block: length of its content (uint32), CRC-32 of its content (uint32), both little-endian; content
    content: msgpack values one after the other, each a record: [kind, ...]

A separate thread writes the collected records twice per second, so the physics thread never waits for a disk. The
reader detects a block that a kill or a full disk has cut off; all blocks before it are good.
"""

from __future__ import annotations

import contextlib
import struct
import zlib
from collections import deque
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO

import msgpack

from simx_server.errors import StartError
from simx_server.outputs.file_thread import FileThread
from simx_server.outputs.packages import NewFile

from .records import Record, checked

MAGIC = b"simxlog 1\n"
"""The number counts up when an older reader could misread a recording."""

MOST_WAITING = 512 << 20
"""Bytes that may wait for a slow disk."""

_MOST_BLOCK = 1 << 30
_HEAD = struct.Struct("<II")


class LogError(StartError):
    """A recording that cannot be read or replayed; the text gives the reason."""


class LogWriter(FileThread[None]):
    """Appends records; for one thread. `_waiting` collects them, so that a record does not wake the writing thread."""

    KIND, REMAINS, LONGEST_WAIT = "recording", "replayed", 600.0

    def __init__(self, path: Path, *, goes_on: bool = False) -> None:
        """Start a recording.

        Args:
            goes_on: write behind the last whole block of the recording that is there.

        Raises:
            OutputError: it cannot be written there, or it exists already.
        """
        # For its owner alone: it contains everything that clients have sent.
        self._size = _whole_size(path) if goes_on else 0
        super().__init__(NewFile(path, "--record", begin=MAGIC, is_private=True, keep=self._size))
        self.is_empty = self._size <= len(MAGIC)
        """No block was there."""

        self._size = max(self._size, len(MAGIC))
        self._pack = msgpack.Packer(unicode_errors="surrogateescape").pack
        self._waiting: deque[bytes] = deque()
        self._start()

    def put(self, *record: Any) -> None:
        """Write a record within `PERIOD`."""
        self.put_packed(self._pack(record))

    def put_packed(self, record: bytes) -> None:
        if self.has_failed:
            return
        self._come += len(record)
        self._waiting.append(record)
        if self.waiting > MOST_WAITING:
            self._fail(f"the disk is too slow: {MOST_WAITING >> 20} MiB wait for it")

    def close(self) -> None:
        super().close()
        self._waiting.clear()

    def _flush(self) -> None:
        while (count := len(self._waiting)) and not self.has_failed:
            records: list[bytes] = []
            size = 0
            while len(records) < count and size < MOST_WAITING:
                records.append(self._waiting.popleft())
                size += len(records[-1])
            content = b"".join(records)
            try:
                self._file.write(_HEAD.pack(len(content), zlib.crc32(content)) + content)
            except OSError:
                with contextlib.suppress(OSError):  # a torn block does no harm either
                    self._file.truncate(self._size)
                raise
            self._size += _HEAD.size + size
            self._gone += size

    _finish = _flush


def _whole_size(path: Path) -> int:
    """Return the bytes of a recording up to the end of its last whole block; 0 without a recording."""
    try:
        with path.open("rb") as file:
            end = file.seek(0, 2)
            file.seek(0)
            if file.read(len(MAGIC)) != MAGIC:
                return 0
            size = len(MAGIC)
            while size + _HEAD.size <= end:
                file.seek(size)
                length, check = _HEAD.unpack(file.read(_HEAD.size))
                following = size + _HEAD.size + length
                # Only the last block can be torn, so the others need not be read.
                if following > end or (following == end and zlib.crc32(file.read(length)) != check):
                    break
                size = following
            return size
    except OSError:
        return 0


class LogReader:
    """The records of a file, in order."""

    def __init__(self, path: Path) -> None:
        """Open a recording. Raises LogError: the file is not a recording."""
        self.path = path
        self.damage = ""
        """After the last record: the reason why the rest could not be read, if the file does not end with a whole
        block.
        """

        try:
            with path.open("rb") as file:
                begin = file.read(len(MAGIC))
        except OSError as error:
            raise LogError(f"'{path}' cannot be read: {error.strerror}") from None
        if begin != MAGIC:
            known = MAGIC.decode().strip()
            if begin.startswith(MAGIC[:8]):
                raise LogError(
                    f"'{path}' is a recording in another format; this server reads '{known}': replay it with the "
                    "version that made it"
                )
            raise LogError(f"'{path}' is no recording: those begin with '{known}' and are made with --record")

    def __iter__(self) -> Iterator[Record]:
        """Yield the records. Raises LogError for a whole block with content other than records."""
        with self.path.open("rb") as file:
            file.seek(len(MAGIC))
            while content := self._block(file):
                unpacker = msgpack.Unpacker(
                    unicode_errors="surrogateescape", strict_map_key=False, max_buffer_size=len(content)
                )
                unpacker.feed(content)
                try:
                    for record in unpacker:
                        yield checked(record)
                except (ValueError, msgpack.UnpackException) as error:
                    raise LogError(f"'{self.path}' holds something else than records: {error}") from None

    def _block(self, file: BinaryIO) -> bytes:
        """Return the next block; empty at the end."""
        place = file.tell()
        head = file.read(_HEAD.size)
        if not head:
            return b""
        if len(head) == _HEAD.size:
            length, check = _HEAD.unpack(head)
            content = file.read(length) if 0 < length <= _MOST_BLOCK else b""
            if content and len(content) == length and zlib.crc32(content) == check:
                return content
        self.damage = f"what begins at byte {place} is torn off or damaged"
        return b""
