"""Record which files hold bytes that a client sent.

Scripts in such files are a client's code, which runs with ``--allow-code`` only.

A list in the workspace holds them, one file per line in the format of ``sha256sum``; an erased file gets a line with
`_ERASED`. The list outlives the server,
because the files of a client are still the client's when the next server starts. A file is on the list by its
content: when an operator edits a file, its content changes and the file becomes the operator's. Links and other
spellings of a name are the same file. Files that are lent for one loading need no line, because their name is
enough.
"""

from __future__ import annotations

import hashlib
import logging
import os
import re
from collections.abc import Generator, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import RLock
from typing import IO
from urllib.parse import quote, unquote_to_bytes
from xml.etree import ElementTree

from simx_client.protocol.files import ARCHIVE_SUFFIXES, MESH_SUFFIXES, VREP_FILES
from simx_server.errors import CommandError
from simx_server.files import workspace
from simx_server.scene.formats.sources import Sources

try:
    import fcntl
except ImportError:  # Windows: two servers that share a workspace could lose each other's newest line there
    fcntl = None

logger = logging.getLogger(__name__)

LEDGER = ".simx-from-clients"

_SLACK = 1000
"""Minimum number of outdated lines before the list is rewritten."""

_ERASED = "0" * 64
"""In place of a hash: the line takes back those above it with this name."""

_PARTS = ("include", "model")
"""Elements of MJCF that include the elements of another file, and its scripts."""

_NAMED = re.compile(rb"""<\s*(?:include|model)\b[^>]*?\bfile\s*=\s*["']([^"']*)""")


class ClientFiles:
    """The list of one workspace. Any thread; other servers may use the same workspace."""

    def __init__(self, folder: Path | None = None) -> None:
        """Use the list in the workspace `folder`; without one (None) no file is a client's."""
        self._folder = folder
        self._lock = RLock()
        """Of all below; files are read beside the physics thread too."""
        self._entries: dict[str, str] = {}
        """Maps a path as `_quoted` to the hash of its content, as last read."""
        self._lines = 0
        self._read_at: tuple[int, int, int] | None = None

    @property
    def _ledger(self) -> Path | None:
        return None if self._folder is None else self._folder / LEDGER

    def check_name(self, path: Path) -> None:
        """Refuse the name of the list itself for writing or erasing.

        Raises:
            CommandError: the path is the list.
        """
        ledger = self._ledger
        if ledger is not None and (LEDGER in map(str.casefold, path.parts) or _is_same(path, ledger)):
            raise CommandError(
                f"'{path.name}' is the server's own list of what clients have stored; use another file name"
            )

    def note(self, path: Path, data: bytes) -> None:
        """Note that a client is about to store a file.

        The list stays as it is when the file belongs to the operator and has this content already.

        Raises:
            CommandError: the list cannot be written; the file must not be stored then.
        """
        if self._folder is None or self._ledger is None:
            return
        if path.is_file() and path.stat().st_size == len(data) and path.read_bytes() == data:
            return  # whether it is a client's or the operator's
        name, content = self._quoted(path), _hash(data)
        try:
            with self._lock, _open_locked(self._ledger) as ledger:
                self._read()
                if self._entries.get(name) == content:
                    return
                self._entries = {**self._entries, name: content}
                self._add(ledger, content, name)
        except OSError as error:
            raise CommandError(
                f"{self._ledger} cannot be written ({error.strerror}); without that list nothing is stored"
            ) from None

    def count_with(self, path: Path, most: int) -> int:
        """Return how many files the list has, with one more at `path`; missing ones do not count beyond `most`."""
        if self._folder is None or self._ledger is None:
            return 0
        with self._lock:
            self._read()
            name = self._quoted(path)
            count = len(self._entries) + (name not in self._entries)
            if count > most and self._entries:
                try:
                    with _open_locked(self._ledger):
                        self._read()
                        self._write_anew()
                except OSError as error:
                    logger.warning("%s cannot be written: %s", self._ledger, error.strerror)
                count = len(self._entries) + (name not in self._entries)
            return count

    def forget(self, path: Path) -> None:
        """Remove a file that a client has erased. The list is deleted with its last file."""
        if self._ledger is None or self._quoted(path) not in self._noted():
            return
        try:
            with self._lock, _open_locked(self._ledger) as ledger:
                self._read()
                gone = self._quoted(path)
                self._entries = {name: content for name, content in self._entries.items() if name != gone}
                if self._entries:
                    self._add(ledger, _ERASED, gone)
                else:
                    self._write_anew()
        except OSError as error:  # the extra line is removed the next time
            logger.warning("%s cannot be written: %s", self._ledger, error.strerror)

    def holds(self, path: Path, data: bytes | None = None) -> bool:
        """Return whether a file exists with bytes that a client sent.

        Args:
            path: the file.
            data: its content, if it was read already.
        """
        if self._folder is None:
            return False
        if workspace.is_lent(path) and path.resolve().parent == self._folder:
            return True
        entries = self._noted()
        if not entries:
            return False
        try:
            content = _hash(path.read_bytes() if data is None else data)
        except OSError:
            return False
        resolved = path.resolve()
        if entries.get(self._quoted(resolved)) == content:
            return True
        place = _place(resolved)
        same = [name for name, noted in entries.items() if noted == content]
        return place is not None and any(each == place for each in self._places(same))

    def made(self, file: Path) -> bool:
        """Return whether a client sent a scene or model file, or a file that it includes."""
        return self._folder is not None and any(self.holds(part) for part in _parts(file))

    def are_named_by(self, file: Path, sources: Sources) -> bool:
        """Return whether a client sent a file or any file that it references, meshes and textures included.

        Only files that `sources` allows are examined.
        """
        if self._folder is None:
            return False
        if workspace.is_lent(file):
            return True
        entries = self._noted()
        if not entries:
            return False
        from simx_server.scene.trial.gathering import files_named  # with it all readers of files

        noted = set(self._places(entries))
        return any(
            (workspace.is_lent(part) or _place(part) in noted) and self.holds(part)
            for part in files_named(file, sources)
        )

    # --- the list --------------------------------------------------------------------------------

    def _quoted(self, path: Path) -> str:
        assert self._folder is not None
        return quote(os.fsencode(os.path.relpath(path, self._folder)), safe="/ ")

    def _places(self, names: Iterable[str]) -> Iterator[tuple[int, int]]:
        """Yield the places of those of these files that exist; there may be thousands, so without `Path`."""
        assert self._folder is not None
        folder = os.fsencode(self._folder) + b"/"
        for name in names:
            place = _place(folder + unquote_to_bytes(name))
            if place is not None:
                yield place

    def _path(self, name: str) -> Path:
        assert self._folder is not None
        return self._folder / os.fsdecode(unquote_to_bytes(name))

    def _noted(self) -> dict[str, str]:
        """Return the newest entries, which do not change any more: each change makes a new dictionary."""
        with self._lock:
            if self._ledger is not None:
                self._read()
            return self._entries

    def _read(self) -> None:
        """Read the list, unless it has not changed."""
        assert self._ledger is not None
        try:
            found = _state(self._ledger.stat())
            if found == self._read_at:
                return
            lines = self._ledger.read_text(encoding="ascii", errors="replace").splitlines()
        except FileNotFoundError:
            found, lines = None, []
        except OSError as error:
            # The list counts as lost: the entries read before stay valid.
            logger.warning("%s cannot be read: %s", self._ledger, error.strerror)
            return
        entries: dict[str, str] = {}
        for content, sign, name in (line.partition("  ") for line in lines):
            if content == _ERASED:
                entries.pop(name, None)
            elif sign:
                entries[name] = content
        self._entries = entries
        self._lines, self._read_at = len(lines), found

    def _add(self, ledger: IO[bytes], content: str, name: str) -> None:
        """Write the newest line into the open, locked list, which was just read and so need not be read again."""
        if self._lines > 2 * len(self._entries) + _SLACK:
            self._write_anew(name)
            return
        ledger.write(f"{content}  {name}\n".encode())
        ledger.flush()
        self._lines += 1
        self._read_at = _state(os.fstat(ledger.fileno()))

    def _write_anew(self, newest: str = "") -> None:
        """Rewrite the list without outdated lines and missing files, and append `newest`."""
        assert self._ledger is not None
        self._entries = {
            name: content
            for name, content in self._entries.items()
            if name == newest or self._path(name).exists()
        }
        self._lines, self._read_at = len(self._entries), None
        if not self._entries:
            self._ledger.unlink()
            return
        text = "".join(f"{content}  {name}\n" for name, content in self._entries.items())
        temporary = self._ledger.with_name(f"{LEDGER}.{os.getpid()}")
        temporary.write_text(text, encoding="ascii")
        found = _state(temporary.stat())  # another server may write as soon as the list has its name
        temporary.replace(self._ledger)
        self._read_at = found


@contextmanager
def _open_locked(path: Path) -> Generator[IO[bytes]]:
    """Open a file for appending, locked against other servers.

    While this process waits for the lock, another one may replace the file; the new file is opened then.
    """
    while True:
        file = path.open("ab")
        with file:
            if fcntl is not None:
                fcntl.flock(file, fcntl.LOCK_EX)
            if fcntl is None or _is_open_at(file, path):
                yield file
                return


def _is_open_at(file: IO[bytes], path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(file.fileno()), path.stat())
    except FileNotFoundError:
        return False


def _state(found: os.stat_result) -> tuple[int, int, int]:
    return found.st_ino, found.st_size, found.st_mtime_ns


def _hash(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def _place(path: Path | bytes) -> tuple[int, int] | None:
    """Return what identifies a file under all its names; None if it does not exist."""
    try:
        found = os.stat(path)
    except (OSError, ValueError):
        return None
    return found.st_dev, found.st_ino


def _is_same(path: Path, other: Path) -> bool:
    try:
        return path.samefile(other)
    except OSError:
        return False


def _parts(file: Path) -> Iterator[Path]:
    """Yield a scene or model file and the existing files whose elements it includes."""
    seen: set[Path] = set()
    waiting = [file.resolve()]
    folder = waiting[0].parent
    while waiting:
        path = waiting.pop()
        if path in seen:
            continue
        seen.add(path)
        yield path
        # MuJoCo searches one of these; an extra file does no harm.
        for name in _named(path):
            found = (base / name for base in dict.fromkeys((folder, path.parent)))
            waiting += [each.resolve() for each in found if each.is_file()]


def _named(file: Path) -> Iterator[str]:
    """Yield the names of included files; none for a file that is not XML (a zip, a mesh, a V-REP file)."""
    if file.suffix.lower() in (*MESH_SUFFIXES, *VREP_FILES, *ARCHIVE_SUFFIXES):
        return
    try:
        data = file.read_bytes()
    except OSError:
        return
    try:
        elements = ElementTree.fromstring(data).iter()
    except (ElementTree.ParseError, ValueError, LookupError):  # MuJoCo is less strict
        yield from map(os.fsdecode, _NAMED.findall(data))
        return
    for element in elements:
        if element.tag in _PARTS and "file" in element.attrib:
            yield element.attrib["file"]
