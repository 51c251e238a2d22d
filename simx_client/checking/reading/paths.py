"""Paths that an expression of a file may mean, as far as its text shows: evaluated, not run."""

from __future__ import annotations

import ast
import itertools
import os
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

_MOST = 20
"""Maximum number of values of one expression."""

_DEEPEST = 12

_ONE_PATH: Mapping[str, Callable[[str], str]] = {
    "dirname": os.path.dirname,
    "basename": os.path.basename,
    "expanduser": os.path.expanduser,
    "expandvars": os.path.expandvars,
} | dict.fromkeys(
    (
        "abspath",
        "realpath",
        "normpath",
        "str",
        "fspath",
        "Path",
        "PurePath",
        "resolve",
        "absolute",
        "as_posix",
    ),
    str,
)
"""Functions and methods of one path; the last ones return it unchanged, since only existing files count here.
"""

_JOINING = ("join", "joinpath", "Path", "PurePath")


class Paths:
    """Evaluates paths in one file, from its constants, assignments, loops and functions of paths."""

    def __init__(self, tree: ast.Module, file: Path) -> None:
        self._file = str(file.absolute())
        self._bound: dict[str, list[ast.expr]] = defaultdict(list)
        for node in ast.walk(tree):
            if isinstance(node, ast.Assign):
                for target in node.targets:
                    if isinstance(target, ast.Name):
                        self._bound[target.id].append(node.value)
            elif isinstance(node, (ast.For, ast.comprehension)) and isinstance(node.target, ast.Name):
                self._bound[node.target.id] += elements(node.iter)

    def values(self, node: ast.expr, depth: int = 0) -> list[str]:
        """Return the possible values of an expression of the file; empty if unknown."""
        if depth > _DEEPEST:
            return []
        return list(itertools.islice(self._of(node, depth + 1), _MOST))

    def _of(self, node: ast.expr, depth: int) -> Iterable[str]:
        if isinstance(node, ast.Constant):
            return [node.value] if isinstance(node.value, str) else []
        if isinstance(node, ast.Name):
            if node.id == "__file__":
                return [self._file]
            return [each for value in self._bound.get(node.id, ()) for each in self.values(value, depth)]
        if isinstance(node, ast.JoinedStr):
            return self._joined([self._piece(each, depth) for each in node.values], "".join)
        if isinstance(node, ast.BinOp) and isinstance(node.op, (ast.Add, ast.Div)):
            sides = [self.values(node.left, depth), self.values(node.right, depth)]
            return self._joined(sides, "".join if isinstance(node.op, ast.Add) else _join)
        if isinstance(node, ast.Attribute):
            if node.attr == "parent":
                return map(os.path.dirname, self.values(node.value, depth))
            return {"pardir": [os.pardir], "curdir": [os.curdir], "sep": [os.sep]}.get(node.attr, [])
        if isinstance(node, ast.Subscript):
            return self._subscript(node, depth)
        return self._call(node, depth) if isinstance(node, ast.Call) else []

    def _piece(self, node: ast.expr, depth: int) -> list[str]:
        return self.values(node.value if isinstance(node, ast.FormattedValue) else node, depth)

    def _subscript(self, node: ast.Subscript, depth: int) -> Iterable[str]:
        number = node.slice.value if isinstance(node.slice, ast.Constant) else None
        if not isinstance(number, int):
            return []
        if is_sys_path(node.value):
            return [os.path.dirname(self._file)] if number == 0 else []
        if isinstance(node.value, ast.Attribute) and node.value.attr == "parents" and 0 <= number < _MOST:
            found = self.values(node.value.value, depth)
            for _ in range(number + 1):
                found = list(map(os.path.dirname, found))
            return found
        if isinstance(node.value, ast.Call) and name_of(node.value.func) == "split" and number in (0, 1):
            return [
                os.path.split(each)[number] for value in node.value.args for each in self.values(value, depth)
            ]
        return []

    def _call(self, node: ast.Call, depth: int) -> Iterable[str]:
        name, arguments = name_of(node.func), list(node.args)
        if name in ("getcwd", "cwd"):
            return [os.getcwd()]
        if name in ("get", "getenv") and arguments and isinstance(arguments[0], ast.Constant):
            set_to = os.environ.get(str(arguments[0].value))
            return [set_to] if set_to else self.values(arguments[1], depth) if len(arguments) > 1 else []
        method = isinstance(node.func, ast.Attribute) and name in (
            "joinpath",
            "resolve",
            "absolute",
            "as_posix",
            "expanduser",
        )
        if method and isinstance(node.func, ast.Attribute) and not (name == "expanduser" and arguments):
            arguments.insert(0, node.func.value)
        if name in _JOINING and len(arguments) > 1:
            return self._joined([self.values(each, depth) for each in arguments], _join)
        if name in _ONE_PATH and arguments:
            return map(_ONE_PATH[name], self.values(arguments[0], depth))
        return []

    def _joined(self, parts: list[list[str]], join: Callable[[Iterable[str]], str]) -> Iterable[str]:
        return (join(each) for each in itertools.product(*parts))


def _join(parts: Iterable[str]) -> str:
    return os.path.join(*parts)


def elements(node: ast.expr) -> list[ast.expr]:
    """Return the elements of a list in the source, also of ``[…] + sys.path``; another expression as its only
    element."""
    if isinstance(node, (ast.List, ast.Tuple)):
        return [each.value if isinstance(each, ast.Starred) else each for each in node.elts]
    if isinstance(node, ast.BinOp) and isinstance(node.left, ast.List):
        return node.left.elts
    if isinstance(node, ast.BinOp) and isinstance(node.right, ast.List):
        return node.right.elts
    return [node]


def is_sys_path(node: ast.expr) -> bool:
    """Return whether an expression means ``sys.path``, or a part of it."""
    if isinstance(node, ast.Subscript):  # sys.path[0:0] = ['…']
        node = node.value
    return isinstance(node, ast.Attribute) and node.attr == "path" and name_of(node.value) in ("sys", "_sys")


def name_of(node: ast.expr) -> str:
    """Return ``c`` for ``a.b.c``; empty for an expression without a name."""
    return node.attr if isinstance(node, ast.Attribute) else node.id if isinstance(node, ast.Name) else ""
