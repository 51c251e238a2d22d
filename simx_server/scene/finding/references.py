"""Check the references in a scene or model file before MuJoCo opens it, since a client may have written the file.

The file of every attribute that starts with `file` (meshes, textures, includes, sub-models, URDF meshes) must lie
in the folders that clients may access, even if the file changes its folder settings (`meshdir` and similar).
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

from simx_client.protocol.files import ARCHIVE_SUFFIXES, MAX_FILE, MESH_SUFFIXES
from simx_server.errors import CommandError
from simx_server.files.library import shipped_scenes
from simx_server.files.regular_files import no_regular_file, read_of_client
from simx_server.scene.formats.contents import Contents
from simx_server.scene.formats.urdf.recognising import is_urdf
from simx_server.scene.formats.whole_files import is_whole

_PACKAGE = "package://"
"""Prefix of file names in URDF; MuJoCo uses the rest."""

_MOST_UNPACKED = 4 * MAX_FILE
"""Maximum size of an unpacked archive in bytes."""

_MOST_ELEMENTS = 100_000
"""Maximum number of elements in a file, counted with those that `replicate` and `composite` create."""

_MOST_PIXELS = 1 << 24
"""Maximum size of a texture that is not read from a file, in pixels; of a height field, in points."""

_DEEPEST = 16
"""Maximum depth of nested includes."""


Read = Callable[[Path], bytes]
"""Reads a file; raises CommandError."""


def check_references(file: Path, folders: Collection[Path], contents: Contents | None = None) -> None:
    """Refuse a file that references others outside the folders (resolved), or is not well-formed XML.

    Meshes of a URDF are not checked here: `Sources.confined` finds them in these folders only.

    Args:
        file: the scene or model.
        folders: the folders that clients may access.
        contents: the files as they were read; None reads them here.

    Raises:
        CommandError: a reference is not allowed, or the file cannot be parsed.
    """
    if file.suffix.lower() in MESH_SUFFIXES:
        return
    read = partial(_read, contents=contents)
    seen: set[Path] = set()
    content = read(file)
    if is_whole(content, file.name):
        return  # it contains everything, and names no files
    if file.suffix.lower() in ARCHIVE_SUFFIXES:
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
    """Check one file and, recursively, its includes.

    Args:
        content: the bytes of the file.
        file: its path.
        folder: the folder of the outermost file, which MuJoCo searches before the folder of the file itself.
        folders: the folders that clients may access.
        seen: the files that were checked already.
        depth: how many includes are nested.
        read: reads an included file.
        skipped: tags of elements that may reference any file.
    """
    name = file.name
    try:
        # MuJoCo reads every file as UTF-8, whatever encoding it declares. Another decoding here would see a
        # different text.
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
            ):  # a client must not find out which files exist elsewhere
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
    """Refuse short texts that MuJoCo would expand beyond the memory or for a very long time."""
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
    """Return a count as MuJoCo reads it; 1 for a word that is not a count."""
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
