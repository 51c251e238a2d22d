"""Settings of the editor, and how texts of flags become them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from simx_server.confined.program import ProgramLimits
from simx_server.settings.rules import Rule

MOST_TEXT = 200_000
"""Bytes of a program's text."""

LIMITS = ProgramLimits(wall=600.0, processor=300.0, memory=1500, disk=50)
"""Of a run. A program with NumPy and OpenCV takes 450 MB of address space, and 60 MB of memory."""

_BOUNDS: Mapping[str, tuple[int, int]] = {
    "wall": (1, 86_400),
    "processor": (1, 86_400),
    "memory": (300, 1_000_000),
    "disk": (1, 100_000),
}
USUAL_NAME = "program.py"


@dataclass(frozen=True)
class EditorPlan:
    """The editor of a class."""

    name: str
    """File name of each seat's program."""

    start: str
    """The text that a seat's program has at first; empty: an example for the scene."""

    limits: ProgramLimits
    folder: Path
    """Holds a folder for each seat's program."""

    libraries: Path
    """A folder for a link to the client's package, which programs import."""

    view_ports: tuple[int, ...]
    """Ports of the 3-D views, in the order of the seats; empty: there are none."""

    views: int
    """3-D views at the same time."""

    host: str = "127.0.0.1"
    """IP address at which views listen."""


def limits_of(texts: list[str]) -> ProgramLimits:
    """Return the limits of a run that these texts ``NAME=N`` change; `LIMIT` has checked them."""
    return replace(LIMITS, **{name: int(number) for name, number in (text.split("=") for text in texts)})


def _limit(text: str) -> str:
    name, _, number = text.partition("=")
    least, most = _BOUNDS.get(name, (1, 0))
    if not (number.isascii() and number.isdecimal() and len(number) < 9 and least <= int(number) <= most):
        raise ValueError(text)
    return text


LIMIT = Rule(
    "NAME=N with " + ", ".join(f"{name} from {least} to {most}" for name, (least, most) in _BOUNDS.items()),
    _limit,
    "NAME=N",
    tuple(_BOUNDS),
)
"""A limit of a run: ``wall=600``; seconds, or megabytes."""


def _program(text: str) -> tuple[str, str]:
    path = Path(text).expanduser()
    if (
        not re.fullmatch(r"[A-Za-z0-9_][A-Za-z0-9_.-]{0,60}\.py", path.name)
        or path.stat().st_size > MOST_TEXT
    ):
        raise ValueError(text)
    return path.name, path.read_bytes().decode("utf-8-sig")


def _readable(text: str) -> tuple[str, str]:
    try:
        return _program(text)
    except OSError as problem:
        raise ValueError(str(problem)) from None


PROGRAM = Rule(
    f"a Python file in UTF-8 of at most {MOST_TEXT} bytes, whose name has letters, digits, '_', '-' and '.'",
    _readable,
    "FILE",
)
"""The text that programs start with, and its name."""


def example(joints: list[str]) -> str:
    """Return a program for a scene with these joints, by their names."""
    return _MOVE.replace("JOINT", joints[0]) if joints else _LOOK


_START = """\
import sim

client = sim.simxStart("127.0.0.1", 19997, True, True, 5000, 5)
sim.simxStartSimulation(client, sim.simx_opmode_blocking)
"""

_MOVE = f"""\
import math
import time

{_START}
_, joint = sim.simxGetObjectHandle(client, "JOINT", sim.simx_opmode_blocking)

for step in range(100):
    angle = 0.5 * math.sin(2 * math.pi * step / 50)
    sim.simxSetJointTargetPosition(client, joint, angle, sim.simx_opmode_oneshot)
    _, position = sim.simxGetJointPosition(client, joint, sim.simx_opmode_blocking)
    print(f"{{step}}: {{position:.3f}}")
    time.sleep(0.05)

sim.simxStopSimulation(client, sim.simx_opmode_blocking)
"""

_LOOK = f"""\
{_START}
_, handles, _, _, names = sim.simxGetObjectGroupData(
    client, sim.sim_appobj_object_type, 0, sim.simx_opmode_blocking
)
for handle, name in zip(handles, names):
    _, position = sim.simxGetObjectPosition(client, handle, -1, sim.simx_opmode_blocking)
    print(name, [round(each, 3) for each in position])

sim.simxStopSimulation(client, sim.simx_opmode_blocking)
"""
