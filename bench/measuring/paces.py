"""The machine's paces: idle, all cores busy with other programs, all on one core; and the figures of aims at each.

A full run on an idle machine makes the report. Runs at another pace add a column to its table of aims.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Generator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

from .report import Findings
from .resources import on_one_core
from .scheduling import cores

IDLE, BUSY, ONE_CORE = "idle", "all cores busy", "all on one core"

PACES = {"idle": IDLE, "busy": BUSY, "one-core": ONE_CORE}
"""By the word of the command line."""


@contextmanager
def kept(pace: str) -> Generator[None]:
    """Keep the machine at a pace within the block, for this process and all that it starts."""
    if pace == BUSY:
        with endless_loops():
            yield
    elif pace == ONE_CORE:
        with on_one_core(os.getpid()):
            yield
    else:
        yield


@contextmanager
def endless_loops() -> Generator[None]:
    """Keep all cores busy within the block."""
    with ExitStack() as stack:
        for _ in range(cores()):
            loop = subprocess.Popen([sys.executable, "-c", "while True: pass"])
            stack.callback(loop.wait)
            stack.callback(loop.kill)
        yield


@dataclass(frozen=True)
class AtPace:
    """The figures of aims at a pace."""

    pace: str
    condition: str
    """When and how long it was measured."""

    found: Mapping[str, float]
    """By the name of the aim."""


def load(path: Path) -> list[AtPace]:
    """Return the figures of earlier runs at other paces; none if there is no file."""
    if not path.is_file():
        return []
    return [AtPace(**each) for each in json.loads(path.read_text(encoding="utf-8"))]


def store(path: Path, pace: str, condition: str, findings: Sequence[Findings]) -> None:
    """Add the figures of a run at another pace, in place of those of an earlier one."""
    found = {
        ratio.what: float(f"{ratio.value:.3g}")
        for each in findings
        for ratio in each.ratios
        if ratio.target is not None
    }
    new = AtPace(pace, f"{time.strftime('%Y-%m-%d %H:%M', time.gmtime())} UTC, {condition}", found)
    every = [*(each for each in load(path) if each.pace != pace), new]
    every.sort(key=lambda each: list(PACES.values()).index(each.pace))
    path.write_text(json.dumps([vars(each) for each in every], indent=1) + "\n", encoding="utf-8")
