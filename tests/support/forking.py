"""Lets code that starts a server fork it in the tests: a new interpreter costs a second of a processor."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from forked import Forked
from processes import finished


class ForkingSubprocess:
    """Stands in for `subprocess` in a module that runs a server to its end, or starts a process of worlds."""

    def __getattr__(self, name: str) -> Any:
        return getattr(subprocess, name)

    @staticmethod
    def run(
        command: list[str], *, stdin: int, capture_output: bool, text: bool, timeout: float
    ) -> subprocess.CompletedProcess[str]:
        """Fork the program, in the present folder."""
        assert stdin == subprocess.DEVNULL
        assert capture_output
        assert text
        assert command[:2] == [sys.executable, "-P"], command
        return finished(*command[2:], folder=Path.cwd(), timeout=timeout)

    @staticmethod
    def Popen(command: Sequence[str], *, stdin: int, pass_fds: Sequence[int]) -> Forked:
        """Fork ``python -m …`` in the present folder."""
        assert command[:2] == [sys.executable, "-m"], command
        return Forked(command[1:], stdin=stdin, cwd=Path.cwd(), pass_fds=pass_fds)
