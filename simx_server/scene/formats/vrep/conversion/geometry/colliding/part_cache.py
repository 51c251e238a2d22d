"""Convex parts of meshes on the disk, in the user's cache folder: a decomposition takes seconds.

An entry is plain numbers: a check sum, the number of parts, the number of points of each, and the points. One that is
damaged is ignored, and so is the whole cache where it cannot be used, or others can write into its folder.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import tempfile
from pathlib import Path

import numpy as np

from simx_server.scene.formats.vrep.conversion.geometry.topology import Points

VARIABLE = "SIMX_CACHE"
"""Environment variable: 0 turns the cache off, an absolute path is the folder of the entries."""

LARGEST = 64 << 20
"""Bytes of all entries together; the ones that were not used for the longest time are removed."""

_LARGEST_ENTRY = 4 << 20
_SUM = 16
"""Bytes of the check sum."""
_SUFFIX = ".parts"


def folder() -> Path:
    """Return the folder of the entries."""
    if os.path.isabs(chosen := os.environ.get(VARIABLE, "")):
        return Path(chosen)
    home = os.environ.get("XDG_CACHE_HOME")
    base = Path(home) if home and os.path.isabs(home) else Path.home() / ".cache"
    return base / "simx" / "convex-parts"


def stored(key: str) -> list[Points] | None:
    """Return the parts under a key; None where there are none, or damaged ones."""
    if not _is_on():
        return None
    try:
        path = folder() / f"{key}{_SUFFIX}"
        if not _is_ours(path.parent) or path.stat().st_size > _LARGEST_ENTRY:
            return None
        data = path.read_bytes()
        with contextlib.suppress(OSError):
            os.utime(path)
    except (OSError, RuntimeError):  # without a home
        return None
    return _decoded(data)


def store(key: str, parts: list[Points]) -> None:
    """Keep parts under a key, at once or not at all; do nothing where the folder cannot be used."""
    data = _encoded(parts)
    if len(data) > _LARGEST_ENTRY or not _is_on():
        return
    with contextlib.suppress(OSError, RuntimeError):
        place = folder()
        place.mkdir(mode=0o700, parents=True, exist_ok=True)
        if not _is_ours(place):
            return
        number, name = tempfile.mkstemp(dir=place)
        try:
            with open(number, "wb") as file:
                file.write(data)
            os.replace(name, place / f"{key}{_SUFFIX}")
        except OSError:
            os.unlink(name)
            raise
        _shrink(place)


def _is_on() -> bool:
    return os.environ.get(VARIABLE) != "0"


def _encoded(parts: list[Points]) -> bytes:
    counts = np.array([len(parts), *map(len, parts)], "<i4")
    body = counts.tobytes() + b"".join(each.astype("<f4").tobytes() for each in parts)
    return hashlib.blake2b(body, digest_size=_SUM).digest() + body


def _decoded(data: bytes) -> list[Points] | None:
    body = data[_SUM:]
    if len(body) < 4 or hashlib.blake2b(body, digest_size=_SUM).digest() != data[:_SUM]:
        return None
    count = int(np.frombuffer(body, "<i4", 1)[0])
    if count < 1 or len(body) < 4 * (count + 1):
        return None
    counts = np.frombuffer(body, "<i4", count, 4).astype(np.int64)
    if counts.min() < 4 or len(body) != 4 * (count + 1) + 12 * int(counts.sum()):
        return None
    points = np.frombuffer(body, "<f4", offset=4 * (count + 1)).astype(np.float32).reshape(-1, 3)
    return np.split(points, np.cumsum(counts)[:-1]) if np.isfinite(points).all() else None


def _shrink(place: Path) -> None:
    """Remove the oldest entries, as long as all together are too large."""
    entries = [(each.stat(), each) for each in place.iterdir() if each.is_file()]
    entries.sort(key=lambda entry: entry[0].st_mtime, reverse=True)
    total = 0
    for about, entry in entries:
        total += about.st_size
        if total > LARGEST:
            entry.unlink(missing_ok=True)


def _is_ours(place: Path) -> bool:
    """Return whether a folder belongs to this user, and other users cannot write into it."""
    if not hasattr(os, "getuid"):  # Windows, where the user's folders are private
        return place.is_dir()
    about = place.stat()
    return about.st_uid == os.getuid() and not about.st_mode & 0o022
