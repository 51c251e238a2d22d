"""The outside of a file: its header, its compression, and what is found under its name but is something else."""

from __future__ import annotations

import struct
from dataclasses import dataclass

from simx_server.scene.formats.annotations import SceneError

from .huffman import decompress

HEADER = 1021
"""Bytes before the body."""
NEWEST = 25
OLDEST = 16
"""Versions of the serialization that are read; none of 13 to 15 was ever seen."""
UNCOMPRESSED, HUFFMAN = 0, 1
SCENE, MODEL = 1, 2

_SUFFIXES = (".ttt", ".ttm")


@dataclass(frozen=True)
class Header:
    """Version, program and kind of a file."""

    serialization: int
    program: tuple[int, int, int]
    """Version of the program that saved the file: major, minor, patch."""
    revision: int
    is_model: bool | None
    """None where the file does not tell, before V-REP 3.6.1."""

    @property
    def writer(self) -> str:
        """Return the program, for messages."""
        major, minor, patch = self.program
        name = "V-REP" if major < 4 else "CoppeliaSim"
        return f"{name} {major}.{minor}.{patch} (format {self.serialization})"


def unpack(data: bytes) -> tuple[Header, memoryview]:
    """Return the header and the uncompressed body.

    Raises:
        SceneError: the bytes are not such a file, or of a version that is not read, or damaged.
    """
    if not data.startswith(b"VREP"):
        raise _foreign(data)
    if len(data) < HEADER:
        raise SceneError(f"it ends within the header, at byte {len(data)} of {HEADER}; the file is cut off")
    serialization, _, compression, length, _, program, _, revision, kind = struct.unpack_from(
        "<iiBIiHiBB", data, 4
    )
    version = program // 10000, program // 100 % 100, program % 100
    header = Header(serialization, version, revision, {SCENE: False, MODEL: True}.get(kind))
    if serialization > NEWEST:
        raise SceneError(
            f"it was saved by {header.writer}, which is newer than what is known, format {NEWEST} "
            "(CoppeliaSim 4.10); save it with an older version"
        )
    if serialization < OLDEST:
        raise SceneError(
            f"it has format {serialization}, from before V-REP 3.0; formats {OLDEST} to {NEWEST} can be read. "
            "Open it in V-REP 3 and save it again"
        )
    if compression == HUFFMAN:
        try:
            return header, decompress(data, HEADER, length)
        except SceneError as error:
            raise SceneError(f"{error}. It was saved by {header.writer}") from None
    if compression != UNCOMPRESSED:
        raise SceneError(
            f"it was saved by {header.writer} with compression {compression}; 0 (none) and 1 (Huffman) exist. "
            "The file is damaged"
        )
    if len(data) - HEADER != length:
        raise SceneError(
            f"its body has {len(data) - HEADER} bytes, but its header says {length}; the file is damaged"
        )
    return header, memoryview(data)[HEADER:]


def _foreign(data: bytes) -> SceneError:
    """Return the error that names what the bytes are."""
    start = data[:400].removeprefix(b"\xef\xbb\xbf").lstrip()
    if not data:
        return SceneError("the file is empty")
    if start.startswith(b"version https://git-lfs"):
        return SceneError(
            "it is a Git LFS pointer, not the file itself; run 'git lfs pull' in the repository it came from"
        )
    if start[:14].lower().startswith((b"<!doctype html", b"<html")):
        return SceneError("it is a web page, not the file itself; download the file that the page shows")
    if start.startswith(b"<"):
        return SceneError(
            "it is XML; CoppeliaSim's XML scenes and models are not read. Open it in CoppeliaSim and save it as "
            + " or ".join(_SUFFIXES)
        )
    if data[:4] == b"VREP"[: len(data)]:
        return SceneError("it ends within the header; the file is cut off")
    return SceneError(
        f"it begins with {data[:4].decode('latin-1')!r} instead of 'VREP', so it is not a file of V-REP or CoppeliaSim"
    )
