"""Find windows of OpenCV in a program, which the package that comes with the server cannot open."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from ..launch.windows.patch import FUNCTIONS
from .places import Place
from .program import Program

_NAMES = {*FUNCTIONS, "selectROI", "selectROIs"}

_TEXT = (
    "it opens windows with cv2.{}: run it with simx-run, which gives windows to an OpenCV without them "
    "(opencv-python-headless), on the display or in the web viewer (docs/porting.md)"
)


def windows_of(program: Program) -> Iterator[tuple[Place, str]]:
    """Yield the first call that needs a window, with what to do; nothing for a program without windows."""
    for source in program.sources:
        modules, functions = _names_of_cv2(source.tree)
        for node in ast.walk(source.tree):
            if not isinstance(node, ast.Call):
                continue
            called = node.func
            if isinstance(called, ast.Attribute) and isinstance(called.value, ast.Name):
                name = called.attr if called.value.id in modules else ""
            else:
                name = functions.get(called.id, "") if isinstance(called, ast.Name) else ""
            if name in _NAMES:
                yield Place(source.path, node.lineno), _TEXT.format(name)
                return


def _names_of_cv2(tree: ast.Module) -> tuple[set[str], dict[str, str]]:
    """Return the names that mean the module, and those that mean a function of it."""
    modules: set[str] = set()
    functions: dict[str, str] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            modules |= {each.asname or "cv2" for each in node.names if each.name in ("cv2", "cv2.cv2")}
        elif isinstance(node, ast.ImportFrom) and node.module == "cv2":
            for each in node.names:
                if each.name == "cv2":
                    modules.add(each.asname or "cv2")
                elif each.name == "*":
                    functions |= {name: name for name in _NAMES}
                else:
                    functions[each.asname or each.name] = each.name
    return modules, functions
