"""Recognise a Python 2 script: by the line at which Python 3 stops, or by a removed built-in.

Only unambiguous constructs count, so that a typing error is still shown as Python shows it, and a script for
both versions is not converted.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib.util import find_spec

_SYNTAX = (
    (re.compile(r"\bexcept\b[^:#]*,\s*\w+\s*:"), "except X, e"),
    (re.compile(r"\braise\s+[\w.]+\s*,"), "raise X, text"),
    (re.compile(r"\b(lambda\s*\(\s*\w+\s*,|def\s+\w+\s*\([^()]*\()"), "a tuple as parameter"),
    (re.compile(r"\b(0[xX][0-9a-fA-F]+|\d+)[lL]\b"), "a long number such as 10L"),
    (re.compile(r"(?<![\w.])0[0-7]+\b(?!\.)"), "an octal number such as 0777"),
    (re.compile(r"\b[uU][rR]['\"]"), 'a text such as ur"..."'),
    (re.compile(r"<>"), "<> for unequal"),
    (re.compile(r"`[^`]+`"), "backquotes for repr"),
)
_STRINGS = re.compile(r"'[^']*'|\"[^\"]*\"")
_GONE_BUILTINS = frozenset({"raw_input", "xrange", "unicode", "unichr", "basestring", "execfile"})
_SERVES_BOTH = re.compile(r"sys\s*\.\s*version|version_info|NameError|\bsix\b|\bfuture\b|\bPY[23]\b")


@dataclass(frozen=True, slots=True)
class Finding:
    """Where a source is Python 2, and by which construct."""

    line: int
    construct: str


def from_syntax_error(error: SyntaxError, source: str) -> Finding | None:
    """Return the Python 2 construct at which the compiler stopped, if it is one."""
    if isinstance(error, TabError):
        return Finding(error.lineno or 1, "tabs and blanks mixed in the indentation")
    for statement in ("print", "exec"):
        if error.msg.startswith(f"Missing parentheses in call to '{statement}'"):
            return Finding(error.lineno or 1, f"the {statement} statement")
    lines = source.splitlines()
    if error.lineno is None or not 0 < error.lineno <= len(lines):
        return None
    text = _STRINGS.sub("''", lines[error.lineno - 1]).partition("#")[0]
    return next((Finding(error.lineno, name) for pattern, name in _SYNTAX if pattern.search(text)), None)


def from_names(tree: ast.Module, source: str) -> Finding | None:
    """Return the first use of something Python 3 compiles but cannot run; None if the script handles it."""
    for node in ast.walk(tree):
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.RShift) and _is_name(node.left, "print"):
            return Finding(node.lineno, "print >>file")
    if _SERVES_BOTH.search(source):
        return None
    used: dict[str, int] = {}
    bound: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Name):
            if isinstance(node.ctx, ast.Load):
                used.setdefault(node.id, node.lineno)
            else:
                bound.add(node.id)
        elif isinstance(node, ast.FunctionDef | ast.ClassDef):
            bound.add(node.name)
        elif isinstance(node, ast.arg):
            bound.add(node.arg)
        elif isinstance(node, ast.Import | ast.ImportFrom):
            bound.update(alias.asname or alias.name for alias in node.names)
    if "*" in bound:  # from somewhere import *: it may import them
        return None
    gone = [(used[name], name) for name in _GONE_BUILTINS & (used.keys() - bound)]
    return Finding(min(gone)[0], f"the built-in {min(gone)[1]}") if gone else None


def from_imports(tree: ast.Module, source: str, is_beside: Callable[[str], bool]) -> Finding | None:
    """Return the first import in a package that only Python 2 finds, beside the module; None if it handles both."""
    if _SERVES_BOTH.search(source):
        return None
    for node in _outside_of_attempts(tree):
        names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        if isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            names.append(node.module)
        for name in names:
            top = name.partition(".")[0]
            if is_beside(top) and find_spec(top) is None:
                return Finding(node.lineno, f"import {name}, a module beside it")
    return None


def _outside_of_attempts(tree: ast.AST) -> Iterator[ast.Import | ast.ImportFrom]:
    """Yield the imports that no ``try`` guards."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.Import | ast.ImportFrom):
            yield node
        elif not isinstance(node, ast.Try):
            yield from _outside_of_attempts(node)


def _is_name(node: ast.expr, name: str) -> bool:
    return isinstance(node, ast.Name) and node.id == name
