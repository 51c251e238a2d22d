"""Convert the text of a Python 2 file to Python 3.

fissix, the maintained copy of the 2to3 that Python 3.13 no longer has, converts the spelling (print, except,
raise, exec, octal numbers, renamed modules, lists instead of iterators). `meaning` converts what spelling
cannot express. The code keeps the line numbers of the file, so that a traceback shows the lines of the file.
"""

from __future__ import annotations

import ast
import bisect
import functools
import io
import logging
import re
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from types import CodeType
from typing import Any

from simx_client.protocol.cli.installing import package_line

from . import meaning

_INDENTATION = re.compile(r"[ \t\f]*\t[ \t\f]*")
_TAKES_APART = re.compile(r"\s*\(.*\) = xxx_todo_changeme\d*$")
_LONG_OCTAL = re.compile(r"\b0[0-7]+[lL]\b")
_CODING = re.compile(rb"^[ \t\f]*#.*?coding[:=][ \t]*([-\w.]+)")
_LEFT_OUT = (
    # only for looks, or a matter of taste
    *("idioms", "set_literal", "ws_comma", "buffer", "asserts", "sorted"),
    "import",  # meaning writes relative imports, also those of submodules and of several modules
    "future",  # meaning reads the line for division, and Python 3 accepts it
    "execfile",  # the file is Python 2 as well
    *("reduce", "reload", "intern"),  # each would add a line; they share the header instead
)


class CannotConvert(ValueError):
    """The text is not Python 2 either, or has no equivalent in Python 3."""


class NoConverter(CannotConvert):
    """fissix is not installed; the text says how to install it."""


@dataclass(frozen=True, slots=True)
class Converted:
    """A converted text that can be saved and run, and its code, with the line numbers of the original."""

    text: str
    code: CodeType


def to_python3(source: str, path: str, *, in_package: bool = False) -> Converted:
    """Convert a whole file.

    Args:
        in_package: ``import neighbour`` means the file beside this one, as in Python 2's packages.

    Raises:
        CannotConvert: with the error and its line, as far as known.
        NoConverter: fissix is not installed.
    """
    if find_spec("fissix") is None:  # the client's own wheel does not require it
        raise NoConverter(f"install it and run it again: {package_line('fissix')}")
    try:
        text = _respell(_without_tabs(source.replace("\r\n", "\n") + "\n"), path)
        text, names = meaning.restore(text, beside(path) if in_package else None)
        text, added = _with_header(text, names)
        tree = ast.parse(text, path)
        _place_as_in_the_file(tree, added)
        return Converted(text.removesuffix("\n"), compile(tree, path, "exec", dont_inherit=True))
    except (SyntaxError, ValueError, *_fissix().errors) as error:
        raise CannotConvert(str(error)) from error


def beside(path: str) -> Callable[[str], bool]:
    """Return a function that returns whether a module of a name lies beside a file."""
    folder = Path(path).parent

    def is_beside(name: str) -> bool:
        return (folder / f"{name}.py").is_file() or (folder / name / "__init__.py").is_file()

    return is_beside


def decode(source: bytes) -> str:
    """Decode a file: as its coding line says, else UTF-8, else Latin-1, as half of the old files."""
    first_lines = source.split(b"\n", 2)[:2]
    declared = next(
        (found[1].decode() for line in first_lines if (found := _CODING.match(line))), "utf-8-sig"
    )
    try:
        return source.decode(declared)
    except (UnicodeDecodeError, LookupError):
        return source.decode("latin-1")


def _with_header(text: str, names: list[str]) -> tuple[str, list[int]]:
    """Import `names` before the first statement that may follow an import.

    Returns:
        The text, and the numbers of the lines that the file does not have: this one, and those in which
            fissix unpacks a tuple parameter.
    """
    lines = text.split("\n")
    if names:
        tree = ast.parse(text)
        has_docstring = ast.get_docstring(tree, clean=False) is not None
        first = next(
            statement
            for statement in tree.body[has_docstring:]
            if not (isinstance(statement, ast.ImportFrom) and statement.module == "__future__")
        )
        decorators: list[ast.expr] = getattr(first, "decorator_list", [])
        line = min(node.lineno for node in (first, *decorators))
        lines.insert(line - 1, f"from simx_client.python2 import {', '.join(names)}")
        return "\n".join(lines), sorted([line, *_taking_apart(lines)])
    return text, _taking_apart(lines)


def _taking_apart(lines: list[str]) -> list[int]:
    return [number for number, line in enumerate(lines, start=1) if _TAKES_APART.match(line)]


def _place_as_in_the_file(tree: ast.Module, added: list[int]) -> None:
    """Set the line numbers of the file in the nodes, without columns, which a traceback would show in the
    wrong place."""
    for node in ast.walk(tree):
        if isinstance(node, ast.stmt | ast.expr | ast.excepthandler | ast.arg | ast.keyword | ast.alias):
            node.lineno -= bisect.bisect_left(added, node.lineno)
            node.end_lineno = node.lineno
            node.col_offset = node.end_col_offset = -1


def _without_tabs(source: str) -> str:
    """Replace tabs at the left edge by blanks up to the next multiple of 8, as Python 2 read them."""
    if "\t" not in source:
        return source
    lines = source.split("\n")
    in_strings: set[int] = set()
    for _, _, (first, _), (last, _), _ in _fissix().tokens(source):
        in_strings.update(range(first + 1, last + 1))
    for number, line in enumerate(lines, start=1):
        edge = _INDENTATION.match(line)
        if edge and number not in in_strings:
            lines[number - 1] = edge[0].replace("\f", "").expandtabs(8) + line[edge.end() :]
    return "\n".join(lines)


def _respell(source: str, path: str) -> str:
    fissix = _fissix()
    text = str(fissix.speller().refactor_string(source, path))
    if _LONG_OCTAL.search(source):  # such a number is both octal and long, and each fixer handles one of them
        text = str(fissix.number_speller().refactor_string(text, path))
    return text


class _Fissix:
    """The parts of fissix that are used here. It has no types, so no other code uses it."""

    def __init__(self) -> None:
        driver, pgen = import_module("fissix.pgen2.driver"), import_module("fissix.pgen2.pgen")
        # The default writes a pickle into the user's home; making the tables takes 40 ms.
        vars(driver)["load_grammar"] = pgen.generate_grammar
        refactor: Any = import_module("fissix.refactor")
        tokenize: Any = import_module("fissix.pgen2.tokenize")
        parse: Any = import_module("fissix.pgen2.parse")
        logging.getLogger("RefactoringTool").setLevel(logging.WARNING)  # a script may log at all levels
        self._tool = refactor.RefactoringTool
        self._every: list[str] = refactor.get_fixers_from_package("fissix.fixes")
        self._tokenize = tokenize.generate_tokens
        self.errors: tuple[type[Exception], ...] = (parse.ParseError, tokenize.TokenError, AssertionError)

    @functools.cache  # noqa: B019 - there is one of this class, and making a tool takes 80 ms
    def speller(self) -> Any:
        """Return the fixer of all spellings."""
        return self._tool([name for name in self._every if name.rpartition("fix_")[2] not in _LEFT_OUT])

    @functools.cache  # noqa: B019
    def number_speller(self) -> Any:
        """Return the fixer of numbers, for a text whose prints are calls already."""
        return self._tool(["fissix.fixes.fix_numliterals"], {"print_function": True})

    def tokens(self, source: str) -> Any:
        return self._tokenize(io.StringIO(source).readline)


@functools.cache
def _fissix() -> _Fissix:
    return _Fissix()
