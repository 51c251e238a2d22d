"""Write files for the operator: films, images, state logs; and import the packages that these need."""

from __future__ import annotations

import os
from importlib import import_module
from io import FileIO
from pathlib import Path
from typing import Any

from simx_client.protocol.cli.installing import extra_line
from simx_server.errors import StartError


class OutputError(StartError):
    """The output of a flag cannot be written; the text gives the reason and the next step."""


def package(name: str, flag: str, extra: str) -> Any:
    """Import and return an optional package. Raises OutputError, with the line that installs it."""
    try:
        return import_module(name)
    except ModuleNotFoundError as error:
        raise OutputError(
            f"{flag} needs the package {error.name}, which is not installed; {extra_line(extra)}"
        ) from None


class NewFile:
    """A file that only grows. Each write goes to the system at once, so a kill of the process loses none of it."""

    def __init__(
        self, path: Path, flag: str, *, begin: bytes = b"", is_private: bool = False, keep: int = 0
    ) -> None:
        """Open the file and write its first bytes.

        Args:
            keep: bytes of an existing file that stay, in place of the first bytes; 0: there must be no such file.

        Raises:
            OutputError: it cannot be written, or it exists already.
        """
        self.path = path
        try:
            if not keep and path.is_file() and path.stat().st_size:
                raise OutputError(
                    f"'{path}' exists already and is not written over; give another {flag}, or delete it"
                )
            mode = 0o600 if is_private else 0o666
            self._file = FileIO(
                path, "r+b" if keep else "wb", opener=lambda name, flags: os.open(name, flags, mode)
            )
            try:
                if keep:
                    self._file.truncate(keep)
                    self._file.seek(keep)
                else:
                    self.write(begin)
            except OSError:
                self.close()
                raise
        except OSError as error:
            raise OutputError(
                f"'{path}' cannot be written: {error.strerror}; give {flag} a file in a folder that may be written"
            ) from None

    def write(self, data: bytes) -> int:
        """Write all of the data. Raises OSError."""
        rest = memoryview(data)
        while rest:
            rest = rest[self._file.write(rest) :]
        return len(data)

    def truncate(self, size: int) -> None:
        self._file.truncate(size)

    def tell(self) -> int:
        return self._file.tell()

    def flush(self) -> None:
        """Do nothing, because writes are not buffered."""

    def close(self) -> None:
        self._file.close()
