"""Files of the workspace that scripts write with Lua's `io.open`.

The server stores a file when the script flushes or closes it, after each `_CHUNK` bytes, at the end of the
run, and at once while the simulation is stopped. Each time it stores the whole file as a file of a client: with the
same checks and limits.
"""

from __future__ import annotations

import itertools
from dataclasses import field
from pathlib import PurePosixPath, PureWindowsPath
from typing import TYPE_CHECKING

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import CommandError
from simx_server.files import workspace
from simx_server.files.regular_files import read_of_client
from simx_server.simulation.part import Part

if TYPE_CHECKING:
    from collections.abc import Callable

    from simx_server.simulation.simulation import Simulation

    from .status_bar import StatusBar

_CHUNK = 1 << 16
_MOST_OPEN = 64


@dataclass
class _Written:
    name: str
    content: bytearray = field(default_factory=bytearray)
    stored: int = 0
    """Bytes that are on the disk."""


class WrittenFiles(Part):
    """The files that scripts have open, by number."""

    def __init__(self, sim: Simulation, store: Callable[[str, bytes], None], status_bar: StatusBar) -> None:
        """Use `store` for the files; it raises CommandError."""
        self._sim = sim
        self._store_file = store
        self._status_bar = status_bar
        self._open: dict[int, _Written] = {}
        self._numbers = itertools.count(1)

    def open(self, path: str, *, append: bool) -> int:
        """Open a file for writing and return its number.

        Args:
            path: within the workspace; of one that leads elsewhere only the last part counts, as of scenes.
            append: keep what the file has.

        Raises:
            CommandError: the name is not allowed, or too many files are open.
        """
        if len(self._open) >= _MOST_OPEN:
            raise CommandError(f"at most {_MOST_OPEN} files are open at a time: close some")
        folder = self._sim.files.workspace
        file = _Written(_name_within(path))
        known = next((each for each in self._open.values() if each.name == file.name), None)
        target = workspace.path_within(folder, file.name)
        if append:
            if known is not None:
                self._store(known)
            file.content += read_of_client(target) if target.exists() else b""
        file.stored = -1
        self._store(file)
        number = next(self._numbers)
        self._open[number] = file
        return number

    def write(self, number: int, data: bytes) -> None:
        """Add bytes at the end. Raises CommandError: the file is closed, or has reached a limit."""
        file = self._file(number)
        limits = self._sim.limits
        limits.check("file", len(file.content) + len(data), f"'{file.name[:80]}' is full")
        file.content += data
        if not self._sim.is_running or len(file.content) - file.stored >= _CHUNK:
            self._store(file)

    def flush(self, number: int) -> None:
        """Store what was written. Raises CommandError."""
        self._store(self._file(number))

    def close(self, number: int) -> None:
        """Store what was written and close the file. Raises CommandError."""
        self._store(self._file(number))
        del self._open[number]

    def run_stopped(self) -> None:
        self._close_all()

    def scene_closing(self) -> None:
        self._close_all()

    def _file(self, number: int) -> _Written:
        if number not in self._open:
            raise CommandError("the file is closed; the end of a run closes all files of scripts")
        return self._open[number]

    def _store(self, file: _Written) -> None:
        if file.stored != len(file.content):
            self._store_file(file.name, bytes(file.content))
            file.stored = len(file.content)

    def _close_all(self) -> None:
        files, self._open = self._open, {}
        for file in files.values():
            try:
                self._store(file)
            except CommandError as problem:
                self._status_bar.add(f"'{file.name}' is not complete: {problem}")


def _name_within(path: str) -> str:
    """Return a path within the workspace: the path itself if it is one, else its last part."""
    pure = PurePosixPath(path.replace("\\", "/"))
    if pure.is_absolute() or ".." in pure.parts or PureWindowsPath(path).drive:
        return pure.name
    return str(pure)
