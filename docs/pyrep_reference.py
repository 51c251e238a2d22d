"""Writes docs/pyrep-functions.md from the stand-in for PyRep's C library and its tests.

``python docs/pyrep_reference.py > docs/pyrep-functions.md``; a test fails when the page is stale, or a function has no
test.
"""

from __future__ import annotations

import ast
import inspect
import sys
import textwrap
from collections.abc import Iterator, Mapping
from pathlib import Path

from simx_client.pyrep.functions import special_functions
from simx_client.pyrep.library import Library, function_names
from simx_client.pyrep.plain import ROWS, sim_name

ROOT = Path(__file__).parents[1]
TESTS = ROOT / "tests" / "client" / "pyrep"
HELPERS = (TESTS / "conftest.py", ROOT / "tests" / "support" / "c_program.py")
"""Files whose functions the tests use."""

HERE = "this process"
"""For a function that needs nothing of the simulation's functions."""

PAGE = """\
# PyRep's C functions

Made by `python docs/pyrep_reference.py > docs/pyrep-functions.md`; a test holds it fresh. {count} functions: all that
PyRep's module `pyrep.backend.sim` names. [pyrep.md](pyrep.md) says how to use PyRep,
[script-functions.md](script-functions.md) what the functions of `sim` do. The tests are in `tests/client/pyrep/`.

|C function|served by|test|
|---|---|---|
{rows}
"""


def served_by(name: str) -> str:
    """The full name of the function of ``sim`` that a function calls; `HERE` without one."""
    if name in ROWS:
        return f"`{sim_name(name)}`"
    special = special_functions().get(name)
    function = special.function if special is not None else getattr(Library, name)
    for node in ast.walk(ast.parse(textwrap.dedent(inspect.getsource(function)))):
        if isinstance(node, ast.Call) and _last(node.func).strip("_") == "call" and node.args:
            called = node.args[0]
            if isinstance(called, ast.Constant) and isinstance(called.value, str):
                return f"`{called.value}`"
    return HERE


def tests() -> Mapping[str, str]:
    """For each function the first test that names it, or that calls a helper which does; its file and its name."""
    helpers = {name: found for file in HELPERS for name, found in _functions(file)}
    direct: dict[str, str] = {}
    indirect: dict[str, str] = {}
    for file in sorted(TESTS.glob("test_*.py")):
        own = dict(_functions(file))
        for test in (name for name in own if name.startswith("test_")):
            label = f"`{file.stem}::{test}`"
            named = _words(own[test])
            seen: set[str] = set()
            waiting = [*named]
            while waiting:
                if (each := waiting.pop()) not in seen:
                    seen.add(each)
                    if (found := own.get(each) or helpers.get(each)) is not None:
                        waiting += _words(found)
            for name in sorted(named):
                direct.setdefault(name, label)
            for name in sorted(seen):
                indirect.setdefault(name, label)
    return {name: direct.get(name) or indirect[name] for name in function_names() & indirect.keys()}


def untested() -> list[str]:
    """The functions without a test."""
    return sorted(function_names() - tests().keys())


def _functions(file: Path) -> Iterator[tuple[str, ast.AST]]:
    """The functions and methods of a file by name; ``__init__`` under the name of its class."""
    for node in ast.parse(file.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.FunctionDef):
            yield node.name, node
        if isinstance(node, ast.ClassDef):
            for each in node.body:
                if isinstance(each, ast.FunctionDef):
                    yield node.name if each.name == "__init__" else each.name, each


def _words(function: ast.AST) -> set[str]:
    """The names, attributes, parameters and texts in a function."""
    found: set[str] = set()
    for node in ast.walk(function):
        if isinstance(node, (ast.Name, ast.Attribute)):
            found.add(_last(node))
        elif isinstance(node, ast.arg):
            found.add(node.arg)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            found.add(node.value)
    return found


def _last(node: ast.expr) -> str:
    return node.attr if isinstance(node, ast.Attribute) else node.id if isinstance(node, ast.Name) else ""


def render() -> str:
    found = tests()
    names = sorted(function_names())
    rows = [f"|`{name}`|{served_by(name)}|{found.get(name, 'none')}|" for name in names]
    return PAGE.format(count=len(names), rows="\n".join(rows))


if __name__ == "__main__":
    sys.stdout.write(render())
