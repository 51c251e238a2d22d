"""Folders that a program adds to ``sys.path``, as far as its text shows."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

from .paths import Paths, elements, is_sys_path

_ADDING = ("append", "insert", "extend")


def added_folders(tree: ast.Module, file: Path) -> list[str]:
    """Return folders, possibly relative, that are appended to, inserted into or assigned to ``sys.path``."""
    return list(dict.fromkeys(_added(tree, Paths(tree, file))))


def _added(tree: ast.Module, paths: Paths) -> Iterator[str]:
    for node in ast.walk(tree):
        found: list[ast.expr] = []
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.args:
            if node.func.attr in _ADDING and is_sys_path(node.func.value):
                found = [node.args[-1]]
            elif node.func.attr == "addsitedir":
                found = node.args[:1]
        elif isinstance(node, (ast.Assign, ast.AugAssign)):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            found = [node.value] if any(map(is_sys_path, targets)) else []
        for each in found:
            for element in elements(each):
                yield from paths.values(element)
