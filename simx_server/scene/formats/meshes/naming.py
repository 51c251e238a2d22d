"""Names of the files that a mesh file names: images, and libraries of materials."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path, PurePosixPath
from urllib.parse import unquote, urlsplit

from simx_server.scene.formats.sources import Sources

from .obj_materials import library_of, read_materials

_MOST_BYTES = 1 << 20
"""Of a library of materials."""

_IMAGE = re.compile(rb"<init_from>\s*(?:<ref>\s*)?([^<]{1,1000}?)\s*<")

Beside = Callable[[str], Path | None]
"""Maps a file's name, as another file writes it, to the file; None: it is not there, or must not be read."""


def beside(file: Path, sources: Sources) -> Beside:
    """Return where the files are that a mesh file names: as written, or in its own folder."""

    def find(name: str) -> Path | None:
        plain = plain_name(name)
        if not plain:
            return None
        places = (file.parent / plain, file.parent / PurePosixPath(plain).name)
        return sources.first(places)

    return find


def files_named(file: Path, data: bytes, sources: Sources) -> Iterator[Path]:
    """Yield the files that a mesh file names and that are there."""
    find = beside(file, sources)
    ending = file.suffix.lower()
    if ending == ".dae":
        names = (found[1].decode("utf-8", "replace") for found in _IMAGE.finditer(data))
        yield from _existing(names, find)
    elif ending == ".obj" and (library := find(library_of(data))) is not None:
        yield library
        materials = read_materials(library_bytes(library, sources))
        yield from _existing((each.image for each in materials.values()), beside(library, sources))


def library_bytes(file: Path, sources: Sources) -> bytes:
    """Return a library of materials; nothing of one that is too large or cannot be read."""
    try:
        data = sources.read(file)
    except OSError:
        return b""
    return data if len(data) <= _MOST_BYTES else b""


def _existing(names: Iterable[str], find: Beside) -> Iterator[Path]:
    for name in dict.fromkeys(names):
        if (path := find(name)) is not None:
            yield path


def plain_name(name: str) -> str:
    """Return a name as a path; COLLADA has URIs, and some programs write those of Windows."""
    text = name.strip().replace("\\", "/")
    if text.startswith("file:"):
        text = urlsplit(text).path
    return "" if "\0" in text else unquote(text)
