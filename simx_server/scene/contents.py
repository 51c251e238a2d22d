"""What the files that a scene is made of hold, read once: MuJoCo gets these bytes and opens no file.

So what was tried (`trial`) is what is loaded, and what each later edit compiles again, whatever happens to the files.
"""

from __future__ import annotations

import errno
import hashlib
import os
import stat
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from simx_server.errors import CommandError


@dataclass(frozen=True)
class Contents:
    """Absolute paths to bytes; a file that is reached through a link is there under both paths."""

    texts: Mapping[str, bytes] = field(default_factory=dict[str, bytes])
    """XML: the scene and what it includes."""

    assets: Mapping[str, bytes] = field(default_factory=dict[str, bytes])
    """Meshes, textures and the like."""

    def find(self, file: Path) -> bytes | None:
        """Return the bytes of a file; None if it is not among these."""
        data = self.texts.get(str(file))
        return self.assets.get(str(file)) if data is None else data

    def read(self, file: Path) -> bytes:
        """As `find`. Raises FileNotFoundError."""
        data = self.find(file)
        if data is None:
            raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(file))
        return data


_TEXT, _ASSET = "text:", "asset:"


def digests(contents: Contents) -> dict[str, str]:
    """Return path to kind and SHA-256 of each file."""
    return {
        path: kind + hashlib.sha256(data).hexdigest()
        for kind, files in ((_TEXT, contents.texts), (_ASSET, contents.assets))
        for path, data in files.items()
    }


def contents_of(digests: Mapping[str, str]) -> Contents:
    """Read these files again.

    Raises:
        CommandError: one is not what it was.
    """
    texts: dict[str, bytes] = {}
    assets: dict[str, bytes] = {}
    for path, digest in digests.items():
        kind = _TEXT if digest.startswith(_TEXT) else _ASSET
        try:
            data = read_regular(Path(path))
        except OSError:
            data = b""
        if kind + hashlib.sha256(data).hexdigest() != digest:
            raise CommandError(f"'{Path(path).name}' was changed while it was being loaded; load it again")
        (texts if kind == _TEXT else assets)[path] = data
    return Contents(texts, assets)


def read_regular(file: Path) -> bytes:
    """Read a file that a client named; never wait for a pipe or a device.

    Raises:
        CommandError: it is no regular file.
        OSError: it cannot be read.
    """
    # Without this flag opening a pipe would wait for somebody who writes to it.
    descriptor = os.open(file, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    with os.fdopen(descriptor, "rb") as opened:
        if not stat.S_ISREG(os.fstat(descriptor).st_mode):
            raise CommandError(no_regular_file(file.name))
        return opened.read()


def no_regular_file(name: str) -> str:
    """The sentence that refuses a pipe, a device or a socket."""
    return f"'{name[:80]}' is a pipe, a device or a socket; give the name of a regular file"
