"""Blocks of bytes in memory that outlives the process that writes them.

A server writes, and the process that started it holds the same memory: two anonymous files, of which one is in use.
When it has grown, the writer copies the blocks that are still needed to the other one, and writes the head of that file
last. So the file in use is always complete. The reader drops a block that was cut off.
"""

from __future__ import annotations

import os
import struct
import tempfile
import zlib
from collections.abc import Iterable, Iterator
from typing import NamedTuple

_HEAD = struct.Struct("<8sQ")
_MARK = b"simxkept"
_BLOCK = struct.Struct("<IIBq")


class Block(NamedTuple):
    """One block."""

    kind: int
    number: int
    """Chosen by the writer: a step, for example."""

    content: bytes


class Journal:
    """The memory. Forks of the process that made it share it; one process writes at a time."""

    def __init__(self) -> None:
        self._files = [_anonymous_file(f"simx-journal-{number}") for number in range(2)]
        self._use, self._turn, self._size = 0, 0, _HEAD.size

    @property
    def size(self) -> int:
        """Return how many bytes the file has that this process writes."""
        return self._size

    def restart(self, blocks: Iterable[Block]) -> None:
        """Replace all blocks by these."""
        self._use, self._turn = self._newest()
        self._use, self._turn = 1 - self._use, self._turn + 1
        file, self._size = self._files[self._use], _HEAD.size
        os.ftruncate(file, 0)
        for block in blocks:
            self.append(block)
        os.pwrite(file, _HEAD.pack(_MARK, self._turn), 0)
        os.ftruncate(self._files[1 - self._use], _HEAD.size)  # gives its memory back

    def append(self, block: Block) -> None:
        """Write a block behind the others; this process must have called `restart`."""
        head = _BLOCK.pack(len(block.content), zlib.crc32(block.content), block.kind, block.number)
        data = head + block.content
        written = os.pwrite(self._files[self._use], data, self._size)
        if written != len(data):
            raise OSError(f"only {written} of {len(data)} bytes could be kept")
        self._size += written

    def read(self) -> list[Block]:
        """Return all whole blocks."""
        data = self._content()
        blocks: list[Block] = []
        for place, length, check, kind, number in _heads(data):
            content = data[place : place + length]
            if zlib.crc32(content) != check:
                break
            blocks.append(Block(kind, number, content))
        return blocks

    def heads(self) -> list[tuple[int, int]]:
        """Return kind and number of all blocks, whole or not."""
        return [(kind, number) for _, _, _, kind, number in _heads(self._content())]

    def _content(self) -> bytes:
        use, turn = self._newest()
        file = self._files[use]
        return os.pread(file, os.fstat(file).st_size, 0) if turn else b""

    def clear(self) -> None:
        """Forget everything."""
        for file in self._files:
            os.ftruncate(file, 0)

    def close(self) -> None:
        """Give the memory back, as far as this process holds it."""
        while self._files:
            os.close(self._files.pop())

    def _newest(self) -> tuple[int, int]:
        """Return which file is in use, and how often the files took turns; 0: nothing was written yet."""
        turns: list[int] = []
        for file in self._files:
            head = os.pread(file, _HEAD.size, 0)
            mark, turn = _HEAD.unpack(head) if len(head) == _HEAD.size else (b"", 0)
            turns.append(turn if mark == _MARK else 0)
        use = max(range(2), key=turns.__getitem__)
        return use, turns[use]


def _anonymous_file(name: str) -> int:
    if hasattr(os, "memfd_create"):
        return os.memfd_create(name)
    with tempfile.TemporaryFile() as file:
        return os.dup(file.fileno())


def _heads(data: bytes) -> Iterator[tuple[int, int, int, int, int]]:
    """Yield place, length and checksum of the content, kind and number of each block that is not cut off."""
    place = _HEAD.size
    while place + _BLOCK.size <= len(data):
        length, check, kind, number = _BLOCK.unpack_from(data, place)
        place += _BLOCK.size
        if place + length > len(data):
            return
        yield place, length, check, kind, number
        place += length
