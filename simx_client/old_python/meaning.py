"""Restore the old meaning of words that Python 3 kept with another meaning.

Works on a text with the spelling of Python 3. The syntax tree gives the places; edits are made in the text,
within a line, so that comments, blanks and line numbers stay.

Division matters most: ``7 / 2`` was 3, and old scripts index and count with it. If the text shows that an
operand is a float, ``/`` stays; if both are whole, it becomes ``//``; otherwise the program decides at run
time.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable
from dataclasses import dataclass

_BEFORE_OPERATOR = re.compile(rb"(?:[^/#]|#[^\n]*)*")
_INTS = {"len", "int", "ord"}
_WHOLE_IN_MATH = {"factorial", "gcd", "isnan", "isinf"}
_ROUNDING = {"floor", "ceil"}
_ARRAY_PACKAGES = {"numpy", "pylab", "scipy", "matplotlib"}
_MOVED = {"reduce", "reload", "intern"}  # former built-ins; the header imports them under the same name
_RENAMED = {"raw_input": "input", "xrange": "range"}  # where they are not called, so that fissix leaves them
_DIVISIONS = {"__div__": "__truediv__", "__rdiv__": "__rtruediv__", "__idiv__": "__itruediv__"}
_SAME_AS_METHOD = (
    *("split", "replace", "strip", "lstrip", "rstrip", "upper", "lower", "capitalize", "zfill", "maketrans"),
    *("find", "rfind", "count", "index", "ljust", "rjust", "center"),
)
_STRING: dict[str, str] = {
    **dict.fromkeys(("join", "joinfields"), "py2_join"),
    **{name: f"str.{name}" for name in _SAME_AS_METHOD},
    **{name: f"string.ascii_{name}" for name in ("letters", "lowercase", "uppercase")},
    "atoi": "int",
    "atol": "int",
    "atof": "float",
}


def restore(text: str, is_beside: Callable[[str], bool] | None = None) -> tuple[str, list[str]]:
    """Return the text with the old meanings, and the names of ``simx_client.python2`` that it uses, sorted.

    Args:
        is_beside: tells for a name whether such a module lies beside the file, which is in a package; an import
            means that module. None: the file is in no package.
    """
    tree = ast.parse(text)
    source = text.encode()
    editor = _Editor(source, _known_names(tree), is_beside)
    editor.visit(tree)
    text = _rendered(source, 0, len(source), editor.edits).decode()
    return text, sorted(editor.helpers)


@dataclass(frozen=True, slots=True)
class _Edit:
    """Replacement of the bytes from `start` to `end` of the text."""

    start: int
    end: int
    text: str
    rank: tuple[int, int] = (2, 0)
    """Order at one position: closing brackets first, the inner one first; then opening ones, the outer one
    first."""


def _rendered(source: bytes, start: int, end: int, edits: list[_Edit]) -> bytes:
    parts: list[bytes] = []
    at = start
    for edit in sorted(edits, key=lambda edit: (edit.start, edit.rank)):
        parts += source[at : edit.start], edit.text.encode()
        at = edit.end
    return b"".join([*parts, source[at:end]])


@dataclass(frozen=True, slots=True)
class _Known:
    """Meanings of names in this file."""

    bound: set[str]
    """Names that the file binds; they are not the built-ins."""

    from_math: set[str]
    comparisons: set[str]
    """Functions of two arguments, which may be comparisons for ``sort``."""

    true_division: bool
    absolute_import: bool


def _known_names(tree: ast.Module) -> _Known:
    bound: set[str] = set()
    from_math: set[str] = set()
    comparisons = {"py2_cmp", "cmp"}
    true_division = absolute_import = False
    for node in ast.walk(tree):
        if isinstance(node, ast.Name) and not isinstance(node.ctx, ast.Load):
            bound.add(node.id)
        elif isinstance(node, ast.FunctionDef | ast.ClassDef):
            bound.add(node.name)
            if isinstance(node, ast.FunctionDef) and len(node.args.args) == 2:
                comparisons.add(node.name)
        elif isinstance(node, ast.arg):
            bound.add(node.arg)
        elif isinstance(node, ast.Import):
            bound.update(alias.asname or alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            names = {alias.asname or alias.name for alias in node.names}
            package = (node.module or "").partition(".")[0]
            true_division |= package == "__future__" and "division" in names
            absolute_import |= package == "__future__" and "absolute_import" in names
            if package == "math":
                from_math |= _ROUNDING if "*" in names else names & _ROUNDING
            elif package in _ARRAY_PACKAGES and "*" in names:
                names.add("round")
            bound |= names
    return _Known(bound, from_math, comparisons, true_division, absolute_import)


def _alias(alias: ast.alias) -> str:
    return f"{alias.name} as {alias.asname}" if alias.asname else alias.name


def _relative(alias: ast.alias) -> str:
    """Return the import of a module beside the file; the name that it binds stays the same."""
    package, _, inner = alias.name.rpartition(".")
    if alias.asname or not package:
        return f"from .{package} import {inner}" + (f" as {alias.asname}" if alias.asname else "")
    return f"from . import {alias.name.partition('.')[0]}; __import__(__package__ + '.{alias.name}')"


class _Editor(ast.NodeVisitor):
    """Collects edits."""

    def __init__(self, source: bytes, known: _Known, is_beside: Callable[[str], bool] | None) -> None:
        self.edits: list[_Edit] = []
        self.helpers: set[str] = set()
        self._source = source
        self._known = known
        self._is_beside = None if known.absolute_import else is_beside
        lines = source.splitlines(keepends=True)
        self._line_starts = [sum(map(len, lines[:number])) for number in range(len(lines) + 1)]

    # --- imports within a package -----------------------------------------------------------------

    def visit_Import(self, node: ast.Import) -> None:
        if any(self._means_neighbour(alias.name) for alias in node.names):
            parts = [
                _relative(alias) if self._means_neighbour(alias.name) else f"import {_alias(alias)}"
                for alias in node.names
            ]
            self._replace(self._start(node), self._end(node), "; ".join(parts))

    def visit_ImportFrom(self, node: ast.ImportFrom) -> None:
        if node.level == 0 and node.module and self._means_neighbour(node.module):
            module = self._source.index(node.module.encode(), self._start(node) + len("from"))
            self._replace(module, module, ".")

    def _means_neighbour(self, module: str) -> bool:
        return self._is_beside is not None and self._is_beside(module.partition(".")[0])

    # --- division --------------------------------------------------------------------------------

    def visit_BinOp(self, node: ast.BinOp) -> None:
        if not isinstance(node.op, ast.Div) or self._known.true_division:
            self.generic_visit(node)
            return
        kinds = {self._kind(node.left), self._kind(node.right)}
        slash = self._operator_after(node.left)
        if "float" in kinds:
            self.generic_visit(node)
        elif kinds == {"int"}:
            self._replace(slash, slash + 1, "//")
            self.generic_visit(node)
        else:
            self._wrap(node, self._helper("py2_divide"))
            blank = "" if self._source[slash + 1 : slash + 2].isspace() else " "
            self._replace(len(self._source[:slash].rstrip(b" ")), slash + 1, "," + blank)
            self.generic_visit(node)

    def visit_AugAssign(self, node: ast.AugAssign) -> None:
        self.visit(node.target)
        if (
            isinstance(node.op, ast.Div)
            and not self._known.true_division
            and self._kind(node.value) != "float"
        ):
            start, end = self._start(node.target), self._end(node.target)
            inside = [edit for edit in self.edits if start <= edit.start < end]
            target = _rendered(self._source, start, end, inside).decode()
            slash = self._operator_after(node.target)
            self._replace(slash, slash + 2, f"= {self._helper('py2_idivide')}({target},")
            self.edits.append(_Edit(self._end(node), self._end(node), ")", (0, -slash)))
        self.visit(node.value)

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        if node.name in _DIVISIONS:
            start = self._source.index(node.name.encode(), self._start(node))
            self._replace(start, start + len(node.name), _DIVISIONS[node.name])
        self.generic_visit(node)

    def _kind(self, node: ast.expr) -> str:
        """Return "int" or "float" if the text alone shows it, else an empty text."""
        match node:
            case ast.Constant(value=bool()):
                return ""
            case ast.Constant(value=int()):
                return "int"
            case ast.Constant(value=float() | complex()):
                return "float"
            case ast.UnaryOp(operand=operand):
                return self._kind(operand)
            case ast.BinOp(
                left=left, op=ast.Add() | ast.Sub() | ast.Mult() | ast.Div() | ast.Pow(), right=right
            ):
                kinds = {self._kind(left), self._kind(right)}
                whole = kinds == {"int"} and not isinstance(node.op, ast.Pow)
                return "float" if "float" in kinds else "int" if whole else ""
            case ast.Attribute(value=ast.Name(id="math"), attr="pi" | "e"):
                return "float"
            case ast.Call(func=ast.Attribute(value=ast.Name(id="math"), attr=name)):
                return "" if name in _WHOLE_IN_MATH else "float"
            case ast.Call(func=ast.Attribute(value=ast.Name(id="time"), attr="time" | "clock")):
                return "float"
            case ast.Call(func=ast.Name(id=name)) if name not in self._known.bound:
                return "float" if name in ("float", "round") else "int" if name in _INTS else ""
            case _:
                return ""

    # --- calls and names -------------------------------------------------------------------------

    def visit_Call(self, node: ast.Call) -> None:
        known = self._known
        match node.func:
            case ast.Name(id="int") if len(node.args) == 1 and self._is_rounding(node.args[0]):
                for part in ast.iter_child_nodes(node.args[0]):  # which may stay unchanged inside int()
                    self.visit(part)
                return
            case ast.Attribute(value=ast.Name(id="sys"), attr="setdefaultencoding"):
                self._replace(self._start(node), self._end(node), "None")
                return
            case ast.Name(id="round") if "round" not in known.bound:
                self._rename(node.func, self._helper("py2_round"))
            case ast.Name(id="file") if "file" not in known.bound:
                self._rename(node.func, "open")
            case ast.Name(id="exec") if node.args:
                self._wrap(node.args[0], self._helper("py2_code"))
            case ast.Name(id="execfile") if node.args and "execfile" not in known.bound:
                self._rename(node.func, "exec")
                self._wrap(node.args[0], self._helper("py2_file"))
            case ast.Attribute(attr="sort") if len(node.args) == 1 and self._is_comparison(node.args[0]):
                self._wrap(node.args[0], f"key={self._helper('py2_key')}")
            case ast.Name(id="sorted") if len(node.args) == 2 and self._is_comparison(node.args[1]):
                self._wrap(node.args[1], f"key={self._helper('py2_key')}")
            case _ if self._is_rounding(node):
                self._wrap(node, "float")
            case _:
                pass
        self._replace_cmp(node)
        self.generic_visit(node)

    def _replace_cmp(self, node: ast.Call) -> None:
        """Replace the argument ``cmp`` of a call by ``key``."""
        for keyword in node.keywords:
            if keyword.arg == "cmp":
                self._replace(self._start(keyword), self._start(keyword) + len("cmp"), "key")
                self._wrap(keyword.value, self._helper("py2_key"))

    def _is_rounding(self, node: ast.expr) -> bool:
        match node:
            case ast.Call(func=ast.Attribute(value=ast.Name(id="math"), attr=name)):
                return name in _ROUNDING
            case ast.Call(func=ast.Name(id=name)):
                return name in self._known.from_math
            case _:
                return False

    def _is_comparison(self, node: ast.expr) -> bool:
        match node:
            case ast.Lambda(args=ast.arguments(args=[_, _])):
                return True
            case ast.Name(id=name):
                return name in self._known.comparisons
            case _:
                return False

    def visit_Name(self, node: ast.Name) -> None:
        if isinstance(node.ctx, ast.Load) and node.id not in self._known.bound:
            if node.id == "cmp":
                self._rename(node, self._helper("py2_cmp"))
            elif node.id in _MOVED:
                self._helper(node.id)
            elif node.id in _RENAMED:
                self._rename(node, _RENAMED[node.id])

    def visit_Attribute(self, node: ast.Attribute) -> None:
        if node.attr == "__next__":  # fissix takes each attribute "next" for the method of an iterator
            dot = self._source.rindex(b".", self._end(node.value), self._end(node))
            if isinstance(node.ctx, ast.Load):
                start = self._start(node)
                self.edits.append(_Edit(start, start, self._helper("py2_next") + "(", (1, -self._end(node))))
                self._replace(dot, self._end(node), ")")
            else:
                self._replace(dot, self._end(node), ".next")
        if isinstance(node.value, ast.Name) and node.value.id == "string" and node.attr in _STRING:
            new = _STRING[node.attr]
            self._rename(node, self._helper(new) if new.startswith("py2_") else new)
        else:
            self.generic_visit(node)

    # --- the text --------------------------------------------------------------------------------

    def _helper(self, name: str) -> str:
        self.helpers.add(name)
        return name

    def _replace(self, start: int, end: int, text: str) -> None:
        self.edits.append(_Edit(start, end, text))

    def _rename(self, node: ast.expr, name: str) -> None:
        self._replace(self._start(node), self._end(node), name)

    def _wrap(self, node: ast.expr, function: str) -> None:
        """Insert a call with `node` as its argument."""
        start, end = self._start(node), self._end(node)
        self.edits.append(_Edit(start, start, function + "(", (1, -end)))
        self.edits.append(_Edit(end, end, ")", (0, -start)))

    def _start(self, node: ast.expr | ast.stmt | ast.keyword) -> int:
        return self._line_starts[node.lineno - 1] + node.col_offset

    def _end(self, node: ast.expr | ast.stmt | ast.keyword) -> int:
        assert node.end_lineno is not None
        assert node.end_col_offset is not None
        return self._line_starts[node.end_lineno - 1] + node.end_col_offset

    def _operator_after(self, left: ast.expr) -> int:
        """Return the position of the ``/`` after this operand; only brackets, blanks and comments may come
        before it."""
        found = _BEFORE_OPERATOR.match(self._source, self._end(left))
        assert found is not None
        return found.end()
