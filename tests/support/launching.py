"""Runs scratch scripts through simx-run in a separate process, in a separate folder."""

from __future__ import annotations

import os
import subprocess
import sys
import textwrap
from pathlib import Path

ROOT = Path(__file__).parents[2]
Finished = subprocess.CompletedProcess[str]

LEGACY_BINDING = """\
import platform
import struct
import sys
import os
import ctypes as ct
from {constants} import *

libsimx = None
try:
    libsimx = ct.CDLL(os.path.join(os.path.dirname(__file__), 'remoteApi.so'))
except:
    print ('remoteApi library could not be loaded')
    raise RuntimeError('the carried binding was run')

c_GetJointPosition = ct.CFUNCTYPE(ct.c_int32, ct.c_int32)(("simxGetJointPosition", libsimx))

def simxStart(connectionAddress, connectionPort):
    return c_GetJointPosition(0)
"""
LEGACY_CONSTANTS = """\
sim_object_shape_type           =0
simx_opmode_oneshot             =0x000000
raise RuntimeError('the carried constants were run')
"""


def carry_binding(folder: Path, names: tuple[str, str] = ("vrep", "vrepConst")) -> None:
    """Put files with the marks of the original binding into `folder`; they raise when they are really run."""
    folder.mkdir(parents=True, exist_ok=True)
    module, constants = names
    (folder / f"{module}.py").write_text(LEGACY_BINDING.format(constants=constants))
    (folder / f"{constants}.py").write_text(LEGACY_CONSTANTS)


def write_script(folder: Path, text: str, name: str = "script.py") -> Path:
    path = folder / name
    path.write_text(textwrap.dedent(text), encoding="utf-8")
    return path


def environment() -> dict[str, str]:
    path = filter(None, [os.environ.get("PYTHONPATH"), str(ROOT)])
    return {**os.environ, "PYTHONPATH": os.pathsep.join(path), "PYTHONDONTWRITEBYTECODE": "1"}


def python(folder: Path, *arguments: str, stdin: str = "") -> Finished:
    command = [sys.executable, *arguments]
    return subprocess.run(
        command,
        cwd=folder,
        env=environment(),
        input=stdin,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )


def simx_run(
    folder: Path, text: str, *arguments: str, flags: tuple[str, ...] = (), stdin: str = ""
) -> Finished:
    """Write `text` as script.py into `folder` and run it there; the exit code is the caller's to judge."""
    write_script(folder, text)
    return python(folder, "-m", "simx_client", "run", *flags, "script.py", *arguments, stdin=stdin)


def output_of(folder: Path, text: str, *arguments: str, flags: tuple[str, ...] = ()) -> str:
    """The output of a script that succeeds."""
    finished = simx_run(folder, text, *arguments, flags=flags)
    assert finished.returncode == 0, finished.stderr
    return finished.stdout.strip()
