"""What a scene or model file names, checked before MuJoCo opens it: a client may have written that file.

Everything in an attribute that begins with `file` (meshes, textures, includes, sub-models, URDF meshes) must lie in the
folders that clients may touch, wherever the file's own folder settings (`meshdir` and the like) lead.
"""

from __future__ import annotations

import io
import math
import zipfile
import zlib
from collections.abc import Callable, Collection, Iterator
from functools import partial
from pathlib import Path
from xml.etree import ElementTree

from simx_client.protocol.files import MAX_FILE, MESH_SUFFIXES
from simx_server.errors import CommandError
from simx_server.scene.formats.contents import Contents
from simx_server.scene.formats.urdf import is_urdf

from .library import shipped_scenes
from .regular_files import no_regular_file, read_of_client

_PACKAGE = "package://"
"""Begins file names in URDF; MuJoCo goes on with the rest."""

_MOST_UNPACKED = 4 * MAX_FILE
"""Bytes."""

_MOST_ELEMENTS = 100_000
"""Of one file, counted with all that `replicate` and `composite` make of them."""

_MOST_PIXELS = 1 << 24
"""Of a texture that is not read from a file; points of a height field."""

_DEEPEST = 16
"""Includes within includes."""


Read = Callable[[Path], bytes]
"""Raises CommandError."""


def check_references(file: Path, folders: Collection[Path], contents: Contents | None = None) -> None:
    """Raises CommandError for a file that names others outside the folders (resolved), or is no well-formed XML.

    Meshes of a URDF are not looked at: `Sources.confined` finds them in these folders only.
    `contents`: the files as they were read; None: they are read here.
    """
    if file.suffix.lower() in MESH_SUFFIXES:
        return
    read = partial(_read, contents=contents)
    seen: set[Path] = set()
    content = read(file)
    if file.suffix.lower() == ".zip":
        _check_size(content, file.name)
        for name, member in _members(content, file.name):
            _check(member, file.parent / name, file.parent, folders, seen, 0, read)
    else:
        skipped = ("mesh",) if is_urdf(content) else ()
        _check(content, file, file.parent, folders, seen, 0, read, skipped)


def _check(
    content: bytes,
    file: Path,
    folder: Path,
    folders: Collection[Path],
    seen: set[Path],
    depth: int,
    read: Read,
    skipped: Collection[str] = (),
) -> None:
    """`folder`: that of the file which includes all others; MuJoCo looks there first, then beside the file itself.
    `skipped`: tags of elements that may name any file."""
    name = file.name
    try:
        # MuJoCo takes every file for UTF-8, whatever it says: read otherwise, it would say something else here.
        root = ElementTree.parse(io.BytesIO(content), ElementTree.XMLParser(encoding="utf-8")).getroot()
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise CommandError(f"cannot read '{name}': no well-formed XML: {error}") from None
    _check_growth(root, name)
    elements = list(root.iter())
    bases = [folder]
    for element in elements:
        bases += [folder / value for key, value in element.attrib.items() if key.endswith("dir")]
    for element in elements:
        for key, value in element.attrib.items():
            if not key.startswith("file") or element.tag in skipped:
                continue
            named = value.removeprefix(_PACKAGE)
            places = [base / named for base in bases]
            if depth and file.is_relative_to(
                shipped_scenes()
            ):  # nobody tries out there what exists elsewhere
                places = [place for place in places if place.is_file()] + [file.parent / named]
            for place in places:
                path = _within(place, folders, f"'{name}' names '{value}'")
                if path.exists() and not (path.is_file() or path.is_dir()):
                    raise CommandError(f"'{name}' names {no_regular_file(path.name)}")
                if path.suffix.lower() in (".xml", ".mjcf", ".urdf") and path not in seen and path.is_file():
                    seen.add(path)
                    if depth == _DEEPEST:
                        raise CommandError(f"'{name}' is included more than {_DEEPEST} files deep")
                    _check(read(path), path, folder, folders, seen, depth + 1, read)


def _check_growth(root: ElementTree.Element, name: str) -> None:
    """Refuse short texts of which MuJoCo would make more than fits into the memory, or into anybody's patience."""
    total, waiting = 0, [(root, 1)]
    while waiting:
        element, factor = waiting.pop()
        counts = [_whole(word) for word in element.get("count", "").split()]
        if element.tag == "replicate":
            factor *= math.prod(counts)
        elif element.tag in ("composite", "flexcomp"):
            total += factor * math.prod(counts)
        total += factor
        for wide, high in (("width", "height"), ("nrow", "ncol"), ("gridsize", "gridsize")):
            if _whole(element.get(wide, "")) * _whole(element.get(high, "")) > _MOST_PIXELS:
                raise CommandError(
                    f"'{name}' has a {element.tag} of more than {_MOST_PIXELS} {wide} x {high}"
                )
        if total > _MOST_ELEMENTS:
            raise CommandError(
                f"'{name}' makes more than {_MOST_ELEMENTS} elements, with what is replicated; make it smaller"
            )
        waiting += [(child, factor) for child in element]


def _whole(word: str) -> int:
    """A count as MuJoCo reads it; 1 for what is none."""
    try:
        return max(1, int(float(word)))
    except (ValueError, OverflowError):
        return 1


def _within(path: Path, folders: Collection[Path], what: str) -> Path:
    try:
        resolved = path.resolve()
    except (OSError, RuntimeError, ValueError) as error:
        raise CommandError(f"{what}, which is no file name: {error}") from None
    if not any(resolved.is_relative_to(folder) for folder in folders):
        raise CommandError(
            f"{what}, which lies outside the folders that clients may open; bring it into the server's workspace"
        )
    return resolved


def _read(file: Path, contents: Contents | None) -> bytes:
    try:
        return read_of_client(file) if contents is None else contents.read(file)
    except OSError as error:
        raise CommandError(f"cannot read '{file.name}': {error.strerror}") from None


def _check_size(content: bytes, name: str) -> None:
    """Refuse an archive that unpacks to more than `_MOST_UNPACKED` bytes."""
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            size = sum(info.file_size for info in archive.infolist())
    except zipfile.BadZipFile as error:
        raise CommandError(f"cannot read '{name}': {error}") from None
    if size > _MOST_UNPACKED:
        raise CommandError(f"'{name}' unpacks to {size} bytes; at most {_MOST_UNPACKED} are read")


def _members(content: bytes, name: str) -> Iterator[tuple[str, bytes]]:
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            for info in archive.infolist():
                if info.filename.lower().endswith((".xml", ".urdf", ".mjcf")):
                    yield info.filename, archive.read(info)
    except (zipfile.BadZipFile, OSError, RuntimeError, NotImplementedError, zlib.error) as error:
        raise CommandError(f"cannot read '{name}': {error}") from None
