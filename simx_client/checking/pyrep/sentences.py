"""How to run a program of PyRep or RLBench, what to install for it, and what is missing."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from pathlib import Path

from simx_client.protocol.cli.installing import extra_line, package_line, pyrep_line
from simx_client.protocol.nearest import did_you_mean, file_like

from ..places import Place
from ..program import PYREP, PYREP_PACKAGES, RLBENCH, Program
from ..search import is_installed
from .calls import PyRepCalls

_TITLES = {PYREP: "PyRep", RLBENCH: "RLBench"}
_SCENE = "task_design.ttt"
"""RLBench's base scene, in its package."""

_RLBENCH_NEEDS = {"PIL": "Pillow", "pyquaternion": "pyquaternion", "scipy": "scipy", "natsort": "natsort"}
"""Packages by the modules that RLBench imports; they are missing where RLBench is a checkout."""


def notes(program: Program) -> Iterator[tuple[Place, str]]:
    """Yield (place, sentence): how to run it, and each package that is not here, with how to install it."""
    used = [name for name in PYREP_PACKAGES if name in program.imports]
    place = Place(*program.imports[used[0]])
    script = shlex.quote(str(program.script.path))
    titles = " and ".join(_TITLES[name] for name in used)
    yield (
        place,
        f"it uses {titles}: run it with simx-run --pyrep {script}, or with the variable SIMX_PYREP=1 (docs/pyrep.md)",
    )
    # RLBench's installation brings PyRep.
    missing = [
        name for name in reversed(PYREP_PACKAGES) if name in (*used, PYREP) and name not in program.packages
    ]
    for name in missing[:1]:
        yield (
            place,
            f"{_TITLES[name]} is not installed here: {pyrep_line(name)}; or put a checkout of it on PYTHONPATH, which "
            "needs no compiler",
        )
    if not is_installed("cffi"):
        yield place, f"PyRep needs cffi, which is not installed here: {extra_line('pyrep')}"
    if RLBENCH in used and RLBENCH in program.packages:
        needs = [package for module, package in _RLBENCH_NEEDS.items() if not is_installed(module)]
        if needs:
            yield place, f"RLBench needs packages that are not installed here: {package_line(*needs)}"


def problems(program: Program, calls: PyRepCalls) -> Iterator[tuple[Place, str]]:
    """Yield (place, sentence) for each function that is not provided, and each file that is not there."""
    yield from _functions(calls)
    for each in calls.files:
        folders = Path(), program.script.path.parent
        if not any(_is_file(folder / path) for folder in folders for path in each.paths):
            first = each.paths[0]
            meant = file_like(folders[1] / first, (".ttt", ".ttm")) or "; name a file that exists"
            yield each.place, f"there is no {each.kind} {first}{meant}"
    folder = program.packages.get(RLBENCH)
    if folder is not None and RLBENCH in program.imports and not _is_file(folder / _SCENE):
        text = (
            f"RLBench opens its scene {_SCENE}, and {folder} has none: copy it there from RLBench's repository, folder "
            f"{RLBENCH}"
        )
        yield Place(*program.imports[RLBENCH]), text


def _functions(calls: PyRepCalls) -> Iterator[tuple[Place, str]]:
    if not calls.functions:
        return
    # Imported here: it makes the stand-in ready in this process, for which other programs have no use.
    from simx_client.pyrep.library import function_names

    provided = sorted(function_names())
    for name, place in calls.functions.items():
        if name not in provided:
            meant = did_you_mean(name, provided) or "; docs/pyrep-functions.md lists what there is"
            yield place, f"the C library has no function {name} here{meant}"


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):  # a NUL, or too long a name
        return False
