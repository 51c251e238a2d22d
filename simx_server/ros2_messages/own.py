"""Definitions of the user's own packages: `.msg`, `.srv` and `.action` files. All of them are hostile: each is limited.

A package is a folder with `msg/`, `srv/` or `action/`; its name is that in `package.xml`, else that of the folder.
"""

from __future__ import annotations

import logging
import os
import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from .grammar import PARTS, DefinitionError, read_interface, unknown_type
from .hashing import TypeHashes
from .layouts import Layout

logger = logging.getLogger(__name__)

MOST_FOLDERS = 20_000
"""Folders that are searched."""

MOST_FILES = 5_000
MOST_TEXT = 256 << 10
"""Bytes of one file."""

MOST_DEPTH = 40
"""Messages within each other."""

MOST_FIELDS = 10_000
"""Fields of a message, with those of the messages within it."""

MOST_VALUES = 1_000_000
"""Values of a message in which all sequences are empty."""

_PASSED_OVER = ("build", "log")
"""Folders of a workspace that have copies."""

_PACKAGE = re.compile(r"[a-z](?:_?[a-z0-9])*")
_TYPE = re.compile(r"[A-Z][A-Za-z0-9]*")
_NAME_IN_XML = re.compile(r"<name>\s*([^<\s]{1,200})\s*</name>")


def read_packages(folders: Iterable[Path]) -> dict[str, str]:
    """Return the texts of all definitions by name, such as `my_msgs/msg/Thing`.

    Args:
        folders: packages, or folders that contain packages, such as a workspace.

    Raises:
        DefinitionError: a folder has no definitions, too many, or two different ones of one name.
    """
    found: dict[str, str] = {}
    for folder in folders:
        before = len(found)
        is_empty = True
        for name, path in _files(folder):
            text = _read(name, path)
            is_empty = False
            if found.setdefault(name, text) != text:
                raise DefinitionError(
                    f"{name} is defined twice, and differently, the second time by '{path}'; give one of both folders"
                )
            if len(found) > MOST_FILES:
                raise DefinitionError(
                    f"'{folder}' has more than {MOST_FILES:,} definitions; give single packages"
                )
        if is_empty and len(found) == before:
            raise DefinitionError(
                f"'{folder}' has no definition; valid is the folder of a package, with .msg, .srv or .action files in "
                "folders of these names, or one that contains such packages"
            )
    return found


def _files(folder: Path) -> Iterator[tuple[str, Path]]:
    """Yield the full name and the path of each definition."""
    for number, (path, folders, files) in enumerate(os.walk(folder)):
        if number >= MOST_FOLDERS:
            raise DefinitionError(f"'{folder}' has more than {MOST_FOLDERS:,} folders; give single packages")
        folders[:] = sorted(each for each in folders if each not in _PASSED_OVER and not each.startswith("."))
        here = Path(path)
        kind = here.name
        wanted = sorted(each for each in files if each.endswith(f".{kind}")) if kind in PARTS else ()
        if wanted:
            package = _package(here.parent)
            for file in wanted:
                name = file.removesuffix(f".{kind}")
                if not _TYPE.fullmatch(name):
                    raise DefinitionError(
                        f"'{here / file}' does not name a type; valid are letters and digits, the first one upper case"
                    )
                yield f"{package}/{kind}/{name}", here / file


def _package(folder: Path) -> str:
    described = folder / "package.xml"
    name = folder.name
    if described.is_file():
        with described.open("rb") as file:
            match = _NAME_IN_XML.search(file.read(MOST_TEXT).decode(errors="replace"))
        name = match[1] if match else name
    if not _PACKAGE.fullmatch(name):
        raise DefinitionError(
            f"'{folder}': '{name}' does not name a package; valid are lower case letters, digits and single underscores"
        )
    return name


def _read(name: str, path: Path) -> str:
    try:
        with path.open("rb") as file:
            data = file.read(MOST_TEXT + 1)
        if len(data) > MOST_TEXT:
            raise DefinitionError(f"{name}: '{path}' has more than {MOST_TEXT:,} bytes")
        return data.decode()
    except OSError as error:
        raise DefinitionError(f"{name}: '{path}' cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise DefinitionError(f"{name}: '{path}' is not UTF-8") from None


def add_own(texts: Mapping[str, str], known: Mapping[str, Layout]) -> dict[str, Layout]:
    """Return the layouts that are known, and those of these definitions.

    A definition of a type that is known does not replace it.

    Args:
        texts: of definitions, by name.

    Raises:
        DefinitionError: a text is not a definition, needs an unknown type, contains itself, or is too large.
    """
    reader = _Reader(texts, known)
    for name in texts:
        reader.read(name)
    mine, its = TypeHashes({**known, **reader.found}), TypeHashes(known)
    for name in sorted(reader.found.keys() & known.keys()):
        if mine.of(name) != its.of(name):
            logger.warning("%s differs from the server's own definition, which is kept", name)
    return {**reader.found, **known}


class _Reader:
    """Reads definitions in the order in which they need each other."""

    def __init__(self, texts: Mapping[str, str], known: Mapping[str, Layout]) -> None:
        self._texts, self._known = texts, known
        self.found: dict[str, Layout] = {}
        self._sizes: dict[str, tuple[int, int]] = {}
        self._under_way: list[str] = []

    def read(self, name: str) -> None:
        """Read a definition, unless it has been read."""
        package, kind, short = name.split("/")
        if f"{name}{PARTS[kind][0]}" in self.found:
            return
        if name in self._under_way:
            way = " -> ".join([*self._under_way[self._under_way.index(name) :], name])
            raise DefinitionError(f"{name} contains itself, which no message can: {way[:500]}")
        if len(self._under_way) >= MOST_DEPTH:
            raise DefinitionError(
                f"{self._under_way[0]} has more than {MOST_DEPTH} messages within each other"
            )
        self._under_way.append(name)
        for layout in read_interface(package, kind, short, self._texts[name].splitlines(), self._find):
            self._check_size(layout)
            self.found[layout.name] = layout
        self._under_way.pop()

    def _check_size(self, layout: Layout) -> None:
        fields, values = self._size(layout)
        if fields > MOST_FIELDS or values > MOST_VALUES:
            raise DefinitionError(
                f"{layout.name} has {fields:,} fields and {values:,} values with all that is in it, and at most "
                f"{MOST_FIELDS:,} and {MOST_VALUES:,} are possible"
            )

    def _find(self, name: str) -> Layout:
        if name in self._known:
            return self._known[name]
        if name in self._texts:
            self.read(name)
        if name not in self.found:
            owner = self._under_way[-1] if self._under_way else ""
            raise unknown_type(name, [*self._known, *self._texts], owner)
        return self.found[name]

    def _size(self, layout: Layout) -> tuple[int, int]:
        """Return how many fields a message has, and how many values while its sequences are empty."""
        if layout.name not in self._sizes:
            fields = values = 0
            for field in layout.fields:
                inner = self._size(field.kind) if isinstance(field.kind, Layout) else (1, 1)
                fields += inner[0]
                values += inner[1] * (field.count or 1)
            self._sizes[layout.name] = max(fields, 1), max(values, 1)
        return self._sizes[layout.name]
