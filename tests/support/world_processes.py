"""The worker processes of `Worlds`."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path


def children(parent: int | None = None) -> set[int]:
    """Process ids of the worker processes of a process."""
    found: set[int] = set()
    for folder in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            status = (folder / "status").read_text()
            if (
                f"PPid:\t{parent or os.getpid()}\n" in status
                and b"worlds.process" in (folder / "cmdline").read_bytes()
            ):
                found.add(int(folder.name))
    return found
