"""Contents of the files of a scene, read once: MuJoCo gets these bytes and opens no file.

The bytes of the trial (`trial`) are therefore the ones that are loaded, and compiled again by each later edit, even
if the files change.
"""

from __future__ import annotations

import errno
import hashlib
import os
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from dataclasses import field
from pathlib import Path

import mujoco

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import CommandError
from simx_server.files.regular_files import read_regular


@dataclass(frozen=True)
class Contents:
    """Bytes of files by absolute path; a file that is reached through a link is stored under both paths."""

    texts: Mapping[str, bytes] = field(default_factory=dict[str, bytes])
    """XML: the scene and its includes."""

    assets: Mapping[str, bytes] = field(default_factory=dict[str, bytes])
    """Meshes, textures and the like."""

    @contextmanager
    def as_files(self, others: Mapping[str, bytes] | None = None) -> Generator[mujoco.MjVfs]:
        """Show the texts to MuJoCo as files. `others`: relative names to more texts, which lie beside each of these."""
        texts = dict(self.texts)
        for folder in {os.path.dirname(path) for path in self.texts}:
            for name, data in (others or {}).items():
                texts.setdefault(os.path.normpath(os.path.join(folder, name)), data)
        files = mujoco.MjVfs()
        try:
            for path, data in texts.items():
                files[path] = data
            yield files
        finally:
            files.close()

    def find(self, file: Path) -> bytes | None:
        """Return the bytes of a file; None for other files."""
        data = self.texts.get(str(file))
        return self.assets.get(str(file)) if data is None else data

    def read(self, file: Path) -> bytes:
        """Return the bytes of a file. Raises FileNotFoundError."""
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
        CommandError: a file has changed.
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
