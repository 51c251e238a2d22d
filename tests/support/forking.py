"""Lets code that starts a server fork it in the tests: a new interpreter costs a second of a processor."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

from processes import finished


class ForkingSubprocess:
    """Stands in for `subprocess` in a module that runs ``python -P -m simx_server …`` to its end."""

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
