"""The one folder where clients may access files: check names, write, erase and lend files."""

from __future__ import annotations

import logging
import os
import random
import tempfile
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path, PurePosixPath, PureWindowsPath

from simx_server.errors import CommandError

from .regular_files import no_regular_file

logger = logging.getLogger(__name__)

_LENT = "REMOTE_API_TEMPFILE_"
"""V-REP's name prefix of a client-side file while it is loaded; four digits and the extension follow."""

_LONGEST_PART, _LONGEST_PATH = 255, 4095
"""Maximum lengths in bytes on Linux and most file systems."""

LONGEST_STORED = 255
"""Maximum bytes of the path of a file that clients store, within the workspace: the list of such files has it."""


def check_name(name: str) -> str:
    """Return a file name or path in a form that means the same on every system: `\\` becomes `/`.

    Raises:
        CommandError: the name is empty, contains NUL or a drive letter, names a folder or is too long for a file
            system.
    """
    if len(os.fsencode(name)) > _LONGEST_PATH or any(
        len(os.fsencode(part)) > _LONGEST_PART for part in name.replace("\\", "/").split("/")
    ):
        raise CommandError(
            f"{name[:80]!r}... is too long: a file name has at most {_LONGEST_PART} bytes, a path {_LONGEST_PATH}"
        )
    if not name.strip() or "\0" in name:
        raise CommandError(f"{name[:80]!r} is no file name; give a path within the server's workspace")
    if PureWindowsPath(name).drive:
        raise CommandError(
            f"{name[:80]!r} names a drive or a share, which the server does not open; "
            "give a path within its workspace"
        )
    name = name.replace("\\", "/")
    if name.rpartition("/")[2] in ("", ".", ".."):
        raise CommandError(f"{name[:80]!r} names a folder; give a file's path within the server's workspace")
    return name


def check_plain_name(name: str) -> str:
    """Return a plain file name in a form that means the same on every system.

    Raises:
        CommandError: as `check_name`, and for a path.
    """
    if "/" in check_name(name):
        raise CommandError(f"{name[:80]!r} is a path; give the file's name alone")
    return name


def path_within(folder: Path, name: str) -> Path:
    """Return the path of a file in the folder.

    Raises:
        CommandError: the name leads out of the folder, also through a link.
    """
    pure = PurePosixPath(check_name(name))
    if pure.is_absolute() or ".." in pure.parts or not pure.name:
        raise CommandError(
            f"{name[:80]!r} is not allowed: a file is named relative to the server's workspace {folder}, without '..'"
        )
    try:
        path = (folder / pure).resolve()
    except (OSError, RuntimeError) as error:
        raise CommandError(f"{name[:80]!r} cannot be used as a file name: {error}") from None
    if not path.is_relative_to(folder.resolve()):
        raise CommandError(f"{name[:80]!r} leads out of the server's workspace {folder} through a link")
    return path


def check_stored_name(name: str) -> None:
    """Refuse the name of a file to store that is longer than `LONGEST_STORED`. Raises CommandError."""
    length = len(os.fsencode(name))
    if length > LONGEST_STORED:
        raise CommandError(
            f"{name[:80]!r}... has {length} bytes; the path of a file that is stored has at most {LONGEST_STORED}"
        )


def store(folder: Path, name: str, data: bytes) -> Path:
    """Write a file atomically: readers see the old one or the new one. Missing folders are created.

    Raises:
        CommandError: the name is not allowed, or the system reports an error.
    """
    path = path_within(folder, name)
    if path.is_dir():
        raise CommandError(f"'{name}' is a folder of the workspace; choose another file name")
    if path.exists() and not path.is_file():
        raise CommandError(no_regular_file(name))
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, temporary = tempfile.mkstemp(prefix=f".{_LENT}", dir=path.parent)
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(data)
            Path(temporary).replace(path)
        except BaseException:
            Path(temporary).unlink(missing_ok=True)
            raise
    except OSError as error:
        raise CommandError(f"'{name}' cannot be written into {folder}: {error.strerror}") from None
    return path


def missing_folders(path: Path) -> set[Path]:
    """Return the folders that `store` makes for a file."""
    return {each for each in path.parents if not each.exists()}


def remove_empty_folders(path: Path, among: set[Path]) -> None:
    """Remove the folders above an erased file that are empty and belong to `among`, from there too."""
    for folder in path.parents:
        if folder not in among:
            return
        try:
            folder.rmdir()
        except OSError:  # it has other files
            return
        among.discard(folder)


def erase(folder: Path, name: str) -> Path:
    """Delete a file and return its path.

    Raises:
        CommandError: the file does not exist.
    """
    path = path_within(folder, name)
    if path.exists() and not (path.is_file() or path.is_dir()):
        raise CommandError(no_regular_file(name))
    if not path.is_file():
        raise CommandError(f"there is no file '{name}' in the server's workspace {folder}")
    try:
        path.unlink()
    except OSError as error:
        raise CommandError(f"'{name}' cannot be erased from {folder}: {error.strerror}") from None
    return path


def is_lent(path: Path) -> bool:
    """Return whether a file name marks a temporary file of a client, even one left by a killed server."""
    return _LENT in path.name


@contextmanager
def lent(folder: Path, name: str, data: bytes) -> Generator[Path]:
    """Keep a file under a unique name inside the context.

    Raises:
        CommandError: the file cannot be written.
    """
    suffix = PurePosixPath(check_name(name)).suffix
    numbers = random.sample(range(10_000), 100)
    free = [n for n in numbers if not (folder / f"{_LENT}{n:04}{suffix}").exists()]
    if not free:
        raise CommandError(f"the workspace {folder} is full of files named {_LENT}...; erase them")
    path = store(folder, f"{_LENT}{free[0]:04}{suffix}", data)
    try:
        yield path
    finally:
        path.unlink(missing_ok=True)
