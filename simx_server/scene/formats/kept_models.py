"""Model files of V-REP that were read: a program that loads one again gets it without another reading.

Programs change their scene by loading and removing the same few models. Reading one takes up to seconds, most of it
for meshes; its objects, as a spec, take some times as much memory as the file.
"""

from __future__ import annotations

import hashlib
from collections import OrderedDict
from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING

from .sources import Sources
from .vrep.recognising import is_vrep

if TYPE_CHECKING:
    from .model_files import Model

_MOST_BYTES = 32 << 20
"""Of all kept files together."""

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
        # Models of other formats name further files, and tried ones have theirs in `contents`.
        if sources is not None and sources.contents is not None:
            return read_model(path, name, sources)
        try:
            data = path.read_bytes()
        except OSError:
            return read_model(path, name, sources)  # which has a message for that
        if not is_vrep(data, path.name):
            return read_model(path, name, sources)
        key = name, path, hashlib.blake2b(data, digest_size=32).digest()
        with self._lock:
            if key in self._kept:
                self._kept.move_to_end(key)
                return self._kept[key][0]
        model = read_model(path, name, sources)
        self._keep(key, model, len(data))
        return model

    def _keep(self, key: _Key, model: Model, size: int) -> None:
        with self._lock:
            self._kept[key] = model, size
            while self._kept and sum(size for _, size in self._kept.values()) > _MOST_BYTES:
                self._kept.popitem(last=False)
