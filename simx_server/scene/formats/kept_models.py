"""Model files that were read: a program that loads one again gets it without another reading.

Programs change their scene by loading and removing the same few models. Reading one takes up to seconds, most of it
for meshes; its objects, as a spec, take some times as much memory as the file. Files that name others are read again:
those may have changed.
"""

from __future__ import annotations

import hashlib
from collections import OrderedDict
from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING

from .archives.archive import is_archive
from .sources import Sources
from .vrep.recognising import is_vrep

if TYPE_CHECKING:
    from .model_files import Model

_MOST_BYTES = 32 << 20
"""Of all kept files together; of a text its model counts, which may be much larger."""

_NAMING = (b"file", b"include")
"""Words without which no MJCF or URDF names another file."""

_Key = tuple[str, Path, bytes]
"""Name, folder and digest of the content."""


class KeptModels:
    """The models that were read last, by the content of their files. Any thread."""

    def __init__(self) -> None:
        self._kept: OrderedDict[_Key, tuple[Model, int]] = OrderedDict()
        """Model, and bytes of its file; the one that was used last is the last."""
        self._lock = Lock()

    def read(self, path: Path, name: str | None = None, sources: Sources | None = None) -> Model:
        """Return a model as `read_model` does, which must not be changed."""
        from .model_files import read_model  # with it all readers of meshes

        name = name or path.name
        # Tried models have their files in `contents`.
        if sources is not None and sources.contents is not None:
            return read_model(path, name, sources)
        try:
            data = path.read_bytes()
        except OSError:
            return read_model(path, name, sources)  # which has a message for that
        is_text = not is_vrep(data, path.name)
        if is_text and not _is_whole_text(data, path):
            return read_model(path, name, sources)
        key = name, path, hashlib.blake2b(data, digest_size=32).digest()
        with self._lock:
            if key in self._kept:
                self._kept.move_to_end(key)
                return self._kept[key][0]
        model = read_model(path, name, sources)
        self._keep(key, model, len(data) + (model.size if is_text else 0))
        return model

    def _keep(self, key: _Key, model: Model, size: int) -> None:
        with self._lock:
            self._kept[key] = model, size
            while self._kept and sum(size for _, size in self._kept.values()) > _MOST_BYTES:
                self._kept.popitem(last=False)


def _is_whole_text(data: bytes, path: Path) -> bool:
    """Return whether a file is MJCF or URDF that names no other file."""
    if path.suffix.lower() not in (".xml", ".urdf") or b"\0" in data or is_archive(data):
        return False
    return not any(word in data.lower() for word in _NAMING)
