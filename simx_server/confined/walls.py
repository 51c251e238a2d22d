"""Find out whether this system can confine a program, without starting one."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

_PROBE = Path(__file__).parents[1] / "scripting" / "python" / "python_program.py"

_TEXT = """
import sys
sys.path.insert(0, sys.argv[1])
import python_confine
lacks = python_confine.missing()
if not lacks and python_confine.landlock_version() < python_confine.WRITING_SINCE:
    lacks = ["landlock of version 3, Linux 6.2"]
print(" and no ".join(lacks))
"""


def lacking() -> str:
    """Return in words what this system lacks to confine a program that writes files; empty for nothing.

    Another process looks, since looking loads ctypes.
    """
    if sys.platform != "linux":
        return "programs of others run on Linux only"
    found = subprocess.run(
        [sys.executable, "-I", "-S", "-B", "-c", _TEXT, str(_PROBE.parent)],
        capture_output=True,
        text=True,
        check=False,
    )
    if found.returncode:
        return f"the walls cannot be examined: {found.stderr.strip()[-200:]}"
    return f"this kernel or container has no {found.stdout.strip()}" if found.stdout.strip() else ""
