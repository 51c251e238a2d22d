"""Run checks that may crash or hang in separate processes: a broken driver must not end the doctor."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import textwrap
from pathlib import Path
from typing import Any

_PACKAGE_ROOT = Path(__file__).resolve().parents[3]


class ProbeFailed(Exception):
    """The probe did not finish; the text says how it ended."""


def run_probe(module: str, *arguments: str, timeout: float) -> dict[str, Any]:
    """Run ``python -m MODULE ARGUMENTS`` and return the JSON object that it prints last.

    Args:
        timeout: seconds.

    Raises:
        ProbeFailed: it crashed, failed, or took too long.
    """
    environment = os.environ.copy()
    environment["PYTHONPATH"] = os.pathsep.join(
        filter(None, (str(_PACKAGE_ROOT), environment.get("PYTHONPATH")))
    )
    try:
        done = subprocess.run(
            [sys.executable, "-P", "-m", module, *arguments],
            env=environment,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=timeout,
        )
    except subprocess.TimeoutExpired:
        raise ProbeFailed(f"no answer within {timeout:g} s") from None
    if done.returncode < 0:
        raise ProbeFailed(f"its process was ended by signal {-done.returncode}")
    lines = done.stdout.strip().splitlines()
    if done.returncode or not lines:
        said = done.stderr.strip().splitlines()
        raise ProbeFailed(textwrap.shorten(said[-1], 200) if said else f"exit status {done.returncode}")
    return json.loads(lines[-1])
