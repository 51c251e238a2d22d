"""Runs scratch scripts through simx-run in a separate process, in a separate folder.

Its processes, and servers that it starts, are forks. Tests of what only a new interpreter shows ask for one."""

from __future__ import annotations

import os
import subprocess
import sys
import textwrap
from collections.abc import Callable
from pathlib import Path

from forked import Forked, of_scripts
from processes import running

ROOT = Path(__file__).parents[2]
MODULE_PATH = os.environ.get("PYTHONPATH")
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


def forked(folder: Path, *arguments: str, stdin: str = "") -> Finished:
    """Do as `python`, in a fork. It has imported the client already, and the module path is that of the tests."""
    assert os.environ.get("PYTHONPATH") == MODULE_PATH, "a fork cannot have another one: start an interpreter"
    pipe = subprocess.PIPE
    with running(
        Forked(
            arguments,
            stdin=pipe,
            stdout=pipe,
            stderr=pipe,
            cwd=folder,
            env=environment(),
            origin=of_scripts(),
        )
    ) as process:
        output, errors = process.communicate(stdin, timeout=60)
    return Finished(process.args, process.wait(), output, errors)


def simx_run(
    folder: Path,
    text: str,
    *arguments: str,
    flags: tuple[str, ...] = (),
    stdin: str = "",
    start: Callable[..., Finished] = forked,
) -> Finished:
    """Write `text` as script.py into `folder` and run it there; the exit code is the caller's to judge.

    `start` is `python` where a new interpreter is the point.
    """
    write_script(folder, text)
    return start(folder, "-m", "simx_client", "run", *flags, "script.py", *arguments, stdin=stdin)


def output_of(folder: Path, text: str, *arguments: str, flags: tuple[str, ...] = ()) -> str:
    """The output of a script that succeeds."""
    finished = simx_run(folder, text, *arguments, flags=flags)
    assert finished.returncode == 0, finished.stderr
    return finished.stdout.strip()
