"""The worker processes of `Worlds`."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path
from typing import Any

from forked import Forked
from processes import ForkingSubprocess


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


class NotingSubprocess(ForkingSubprocess):
    """Stands in for `subprocess` in the module that starts these processes: it forks them, and lists them."""

    started: list[Forked]

    def __init__(self) -> None:
        self.started = []

    def Popen(self, *arguments: Any, **options: Any) -> Forked:
        self.started.append(super().Popen(*arguments, **options))
        return self.started[-1]

    def have_ended(self) -> bool:
        return all(each.poll() is not None for each in self.started)
