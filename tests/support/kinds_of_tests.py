"""The marker of tests that start real processes: imports of their files show which do."""

from __future__ import annotations

import ast
import functools
from pathlib import Path

import pytest

TESTS = Path(__file__).parents[1]
HELPERS = tuple(
    TESTS / "support" / folder for folder in ("", "worlds", "gateways", "viewer", "vrep_files", "stock")
)

_PROCESSES = {"server", "spawn", "finished", "running"}
"""Functions of tests/processes.py that start processes; the others are for all tests."""


def add_marker(item: pytest.Item) -> None:
    """Add the marker ``system``, if the item's file starts processes."""
    if _starts_processes(item.path):
        item.add_marker(pytest.mark.system)


@functools.cache
def _starts_processes(path: Path) -> bool:
    """Whether a file imports `subprocess`, or another file of the tests which does."""
    waiting, seen = [path], {path}
    while waiting:
        for module, name in _imports(waiting.pop()):
            if module.partition(".")[0] in ("subprocess", "multiprocessing"):
                return True
            if module == "processes":
                if name in _PROCESSES:
                    return True
                continue
            helpers = set(_helpers(module, {path.parent, *HELPERS})) - seen
            waiting.extend(helpers)
            seen |= helpers
    return False


@functools.cache
def _imports(path: Path) -> tuple[tuple[str, str], ...]:
    """The module of every absolute import, and the name that is taken from it."""
    found: list[tuple[str, str]] = []
    for node in ast.walk(ast.parse(path.read_bytes())):
        if isinstance(node, ast.Import):
            found.extend((alias.name, "") for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            found.extend((node.module, alias.name) for alias in node.names)
    return tuple(found)


def _helpers(module: str, folders: set[Path]) -> list[Path]:
    """The file of the tests that an import means, if it is one."""
    return [file for folder in folders if (file := folder / f"{module}.py").is_file()]
