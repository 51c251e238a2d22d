"""The statements of Python files, for tests of the code: a tenth of the nodes of a syntax tree."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

from simx_client.protocol.python.garbage import no_collections

_HAVE_STATEMENTS = (ast.stmt, ast.excepthandler, ast.match_case)


def statements(tree: ast.AST) -> Iterator[ast.AST]:
    """Yield a module, a class or a function and its statements, also those inside others, without expressions."""
    waiting = [tree]
    while waiting:
        yield (node := waiting.pop())
        for name, value in vars(node).items():
            if name in ("body", "orelse", "finalbody", "handlers", "cases"):
                waiting += (child for child in value if isinstance(child, _HAVE_STATEMENTS))


def parsed(path: Path) -> ast.Module:
    """Return the syntax tree of a file. The garbage collector would take twice as long as the parser."""
    with no_collections():
        return ast.parse(path.read_bytes())
