"""A script and the modules that lie beside it, as syntax trees; nothing of it is run."""

from __future__ import annotations

import ast
import logging
from dataclasses import dataclass, field
from pathlib import Path

from ..errors import SimxError
from ..launch.bindings import CONSTANTS_ONLY, FUNCTIONS_AND_CONSTANTS, is_legacy_binding
from ..launch.python2.convert import decode
from ..launch.python2.loading import IsPython2, convert_if_python2
from ..protocol.nearest import file_like

logger = logging.getLogger(__name__)

BINDINGS = (*FUNCTIONS_AND_CONSTANTS, *CONSTANTS_ONLY)


class CannotRead(SimxError):
    """The file is not there, or no Python of any version."""


@dataclass(frozen=True)
class Source:
    """One file."""

    path: Path
    tree: ast.Module
    is_python2: bool


@dataclass
class Program:
    """The script, first, and its own modules."""

    sources: list[Source] = field(default_factory=list[Source])
    imports: dict[str, int] = field(default_factory=dict[str, int])
    """Top-level names of modules that are not its own, and the line of the script that brings them."""

    trouble: list[tuple[Path, str]] = field(default_factory=list[tuple[Path, str]])
    """Its own modules that cannot be read, and why."""

    @property
    def script(self) -> Source:
        return self.sources[0]


def read_program(path: Path) -> Program:
    """Read the script, and what it imports from its own folder, but no binding that it carries.

    Raises:
        CannotRead: the script itself cannot be read; the text says why and what to do.
    """
    program = Program([read_source(path, for_sure=False)])
    seen = {path.resolve()}
    waiting = list(program.sources)
    while waiting:
        source = waiting.pop()
        for name, line, is_own in _imported(source.tree):
            file = _beside(source.path.parent if is_own else path.parent, name)
            if file is None:
                if is_own:  # a name within a module of its own package
                    continue
                top = name.partition(".")[0]
                if not _beside(path.parent, top) and not (path.parent / top).is_dir():
                    program.imports.setdefault(top, line)
            elif file.resolve() not in seen:
                seen.add(file.resolve())
                try:
                    if is_legacy_binding(file.read_bytes()):
                        continue
                    found = read_source(file, for_sure=program.script.is_python2)
                except (CannotRead, OSError) as error:
                    program.trouble.append((file, str(error)))
                    continue
                program.sources.append(found)
                waiting.append(found)
    return program


def read_source(path: Path, *, for_sure: bool) -> Source:
    """One file; converted if it is Python 2 (`for_sure`: even if Python 3 could run it). Raises CannotRead."""
    try:
        source = path.read_bytes()
    except OSError as error:
        meant = file_like(path, (".py",)) or ";"
        raise CannotRead(f"cannot open {path}: {error.strerror}{meant} name the script's .py file") from error
    try:
        converted = convert_if_python2(source, str(path), for_sure=for_sure)
        if converted is None:
            return Source(path, ast.parse(decode(source), str(path)), is_python2=False)
        return Source(path, _placed(converted.text), is_python2=True)
    except IsPython2 as error:
        raise CannotRead(str(error)) from error
    except (SyntaxError, ValueError, RecursionError) as error:  # ValueError: a NUL in the source
        line = getattr(error, "lineno", None)
        where = f"{path}, line {line}" if line else str(path)
        raise CannotRead(
            f"{where}, is no Python: {getattr(error, 'msg', error)}; mend the line, then check again"
        ) from error


def _placed(text: str) -> ast.Module:
    """The tree of a converted text, its nodes with the lines of the original, which lacks a few."""
    tree = ast.parse(text)
    added = [
        number
        for number, line in enumerate(text.split("\n"), 1)
        if line.startswith("from simx_client.python2 import ") or "= xxx_todo_changeme" in line
    ]
    for node in ast.walk(tree):
        if isinstance(node, (ast.stmt, ast.expr)):
            node.lineno -= sum(each < node.lineno for each in added)
    return tree


def _imported(tree: ast.Module) -> list[tuple[str, int, bool]]:
    """(module, line, whether it is looked for in the package of the file that imports it)."""
    found: list[tuple[str, int, bool]] = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found += [(alias.name, node.lineno, False) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base, is_own = node.module or "", bool(node.level)
            if base:
                found.append((base, node.lineno, is_own))
            if is_own and not base:
                found += [(each.name, node.lineno, True) for each in node.names]
    return found


def _beside(folder: Path, module: str) -> Path | None:
    """The file of a module in the script's folder, else None."""
    base = folder.joinpath(*module.split("."))
    for file in (base.with_name(base.name + ".py"), base / "__init__.py"):
        if file.is_file():
            return file
    return None
