"""Other programs that tools start: they end in time, with all that they have started."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from .answers import Refused, limited

MOST_ANSWER_WAIT = 300.0
"""Seconds that a tool waits for its program."""


def run_program(
    module: str, *words: str, folder: Path, flags: Sequence[str] = (), timeout: float = MOST_ANSWER_WAIT
) -> tuple[int, str]:
    """Run a program of this project; return its exit code and its output.

    Args:
        folder: its working folder.
        flags: for Python.

    Raises:
        Refused: it takes too long.
    """
    with subprocess.Popen(
        [sys.executable, *flags, "-m", module, *words],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
        cwd=folder,
        start_new_session=os.name == "posix",
    ) as process:
        try:
            output, _ = process.communicate(timeout=timeout)
        except subprocess.TimeoutExpired:
            _end(process)
            raise Refused(f"it did not end within {timeout:g} s") from None
    return process.returncode, limited(output)


def _end(process: subprocess.Popen[str]) -> None:
    """End a program and its children, which have its output too: their end would be awaited."""
    if sys.platform == "win32":
        subprocess.run(["taskkill", "/F", "/T", "/PID", str(process.pid)], capture_output=True)
    else:
        os.killpg(process.pid, signal.SIGKILL)
