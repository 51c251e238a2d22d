"""Semaphores that all simulations of one user on a machine share: a locked file for each name.

The operating system releases the lock when the process ends, however it ends.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
from pathlib import Path

from simx_server.errors import CommandError

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None

_MOST = 64
"""Most semaphores that a simulation has at a time."""


class Semaphores:
    """The semaphores that this simulation has."""

    def __init__(self) -> None:
        self._held: dict[str, int] = {}
        """File descriptors by key."""

    def acquire(self, key: str) -> bool:
        """Take a semaphore; return False while this or another simulation has it. Raises CommandError."""
        if fcntl is None:
            raise CommandError("semaphores between simulations are not available on Windows")
        if key in self._held:
            return False
        if len(self._held) >= _MOST:
            raise CommandError(f"a simulation has at most {_MOST} semaphores at a time; release some")
        try:
            file = os.open(self._path(key), os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
        except OSError as error:
            raise CommandError(f"the semaphore has no file: {error.strerror}") from None
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(file)
            return False
        self._held[key] = file
        return True

    def release(self, key: str) -> None:
        """Give a semaphore back. Raises CommandError: this simulation has not acquired it."""
        file = self._held.pop(key, None)
        if file is None:
            raise CommandError(f"this simulation has not acquired the semaphore '{key[:80]}'")
        os.close(file)

    def __del__(self) -> None:
        for file in self._held.values():
            os.close(file)

    @staticmethod
    def _path(key: str) -> Path:
        """Return the file of a semaphore, in a folder that only this user may read."""
        user = os.getuid() if hasattr(os, "getuid") else 0
        folder = Path(tempfile.gettempdir()) / f"simx-semaphores-{user}"
        folder.mkdir(mode=0o700, exist_ok=True)
        if folder.is_symlink() or folder.stat().st_uid != user:
            raise CommandError(f"the folder '{folder.name}' for semaphores belongs to somebody else")
        return folder / hashlib.sha256(key.encode("utf-8", "surrogateescape")).hexdigest()
