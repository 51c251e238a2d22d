"""Read files that clients name. Pipes, devices and sockets are refused, since reading them may never end."""

from __future__ import annotations

import os
import stat
from pathlib import Path

from simx_client.protocol.files import MAX_FILE
from simx_server.errors import CommandError


def read_regular(file: Path) -> bytes:
    """Read a file that a client named; never wait for a pipe or a device.

    Raises:
        CommandError: it is not a regular file.
        OSError: it cannot be read.
    """
    # Without this flag, opening a pipe would wait for a writer.
    descriptor = os.open(file, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    with os.fdopen(descriptor, "rb") as opened:
        if not stat.S_ISREG(os.fstat(descriptor).st_mode):
            raise CommandError(no_regular_file(file.name))
        return opened.read()


def read_of_client(file: Path) -> bytes:
    """Read a regular file of at most MAX_FILE bytes.

    Raises:
        CommandError: the file is too large, not regular or not readable.
    """
    try:
        if file.stat().st_size > MAX_FILE:
            raise CommandError(f"'{file.name}' is larger than {MAX_FILE} bytes")
        return read_regular(file)
    except OSError as error:
        raise CommandError(f"cannot read '{file.name}': {error.strerror}") from None


def is_file(path: Path) -> bool:
    """Return whether a path is a file; False for a path that the system refuses."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def no_regular_file(name: str) -> str:
    """Return the sentence that refuses a pipe, a device or a socket."""
    return f"'{name[:80]}' is a pipe, a device or a socket; give the name of a regular file"
