"""Who assigns what to which name, and who calls whom with what: as much of a program as its texts need.

The order of statements is not followed: a name may be anything that is assigned to it somewhere in its function.
An attribute may be anything that is assigned to one of that name anywhere.
"""

from __future__ import annotations

import ast
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

from .program import Program


@dataclass(frozen=True, eq=False)
class Scope:
    """A function, or a module."""

    file: Path
    parent: Scope | None
    function: ast.FunctionDef | ast.AsyncFunctionDef | None
    is_method: bool = False


@dataclass(frozen=True)
class Bound:
    """Something that a name may be."""

    node: ast.expr | None
    """None: it is not known what."""

    scope: Scope
    is_element: bool = False
    """An element of `node` is meant; of a dictionary a key."""

    is_value: bool = False
    """A value of a dictionary is meant."""


@dataclass(frozen=True)
class Called:
    """One call, and where it stands."""

    node: ast.Call
    scope: Scope

    @property
    def name(self) -> str:
        """The last part of what is called."""
        return _last(self.node.func)

    @property
    def line(self) -> int:
        return self.node.lineno


@dataclass
class Names:
    """All names of a program."""

    bound: dict[tuple[Scope, str], list[Bound]] = field(default_factory=lambda: defaultdict(list[Bound]))
    """By scope and name."""

    attributes: dict[str, list[Bound]] = field(default_factory=lambda: defaultdict(list[Bound]))
    appended: dict[str, list[Bound]] = field(default_factory=lambda: defaultdict(list[Bound]))
    """By the list's last name: what ``.append`` adds."""

    calls: list[Called] = field(default_factory=list[Called])
    by_called: dict[str, list[Called]] = field(default_factory=lambda: defaultdict(list[Called]))
    functions: dict[str, list[Scope]] = field(default_factory=lambda: defaultdict(list[Scope]))
    """By the name under which they are called; a class's ``__init__`` under the class's."""

    read: list[tuple[ast.Attribute, Scope]] = field(default_factory=list[tuple[ast.Attribute, Scope]])
    modules: dict[str, str] = field(default_factory=dict[str, str])
    """What a name stands for that an import made."""


def names_of(program: Program) -> Names:
    """Walk all files of a program."""
    names = Names()
    for source in program.sources:
        _Walk(names, Scope(source.path, None, None)).visit(source.tree)
    for call in names.calls:
        names.by_called[call.name].append(call)
    return names


def _last(node: ast.expr) -> str:
    if isinstance(node, ast.Attribute):
        return node.attr
    return node.id if isinstance(node, ast.Name) else ""


class _Walk(ast.NodeVisitor):
    def __init__(self, names: Names, scope: Scope) -> None:
        self._names = names
        self._scope: Scope = scope
        self._class: ast.ClassDef | None = None

    def visit_Import(self, node: ast.Import) -> None:
        for alias in node.names:
            self._names.modules[alias.asname or alias.name.partition(".")[0]] = alias.name

    def visit_ImportFrom(self, node: ast.ImportFrom) -> None:
        for alias in node.names:
            self._names.modules[alias.asname or alias.name] = alias.name

    def visit_ClassDef(self, node: ast.ClassDef) -> None:
        outer, self._class = self._class, node
        self.generic_visit(node)
        self._class = outer

    def visit_FunctionDef(self, node: ast.FunctionDef | ast.AsyncFunctionDef) -> None:
        owner = self._class
        outer = self._scope
        self._scope = Scope(outer.file, outer, node, is_method=owner is not None)
        self._class = None
        called = owner.name if owner is not None and node.name == "__init__" else node.name
        self._names.functions[called].append(self._scope)
        self.generic_visit(node)
        self._scope, self._class = outer, owner

    visit_AsyncFunctionDef = visit_FunctionDef

    def visit_Assign(self, node: ast.Assign) -> None:
        for target in node.targets:
            self._bind(target, Bound(node.value, self._scope))
        self.generic_visit(node)

    def visit_AnnAssign(self, node: ast.AnnAssign) -> None:
        if node.value is not None:
            self._bind(node.target, Bound(node.value, self._scope))
        self.generic_visit(node)

    def visit_AugAssign(self, node: ast.AugAssign) -> None:
        self._bind(node.target, Bound(None, self._scope))
        self.generic_visit(node)

    def visit_For(self, node: ast.For) -> None:
        self._loop(node.target, node.iter)
        self.generic_visit(node)

    def visit_comprehension(self, node: ast.comprehension) -> None:
        self._loop(node.target, node.iter)
        self.generic_visit(node)

    def visit_Call(self, node: ast.Call) -> None:
        self._names.calls.append(Called(node, self._scope))
        if isinstance(node.func, ast.Attribute) and node.func.attr == "append" and len(node.args) == 1:
            self._names.appended[_last(node.func.value)].append(Bound(node.args[0], self._scope))
        self.generic_visit(node)

    def visit_Attribute(self, node: ast.Attribute) -> None:
        if isinstance(node.ctx, ast.Load):
            self._names.read.append((node, self._scope))
        self.generic_visit(node)

    def _loop(self, target: ast.expr, values: ast.expr) -> None:
        bounds = [Bound(values, self._scope, is_element=True)]
        if isinstance(target, (ast.Tuple, ast.List)):
            self._bind_all(target.elts, _parts(values, len(target.elts), self._scope))
        else:
            self._bind(target, bounds[0])

    def _bind(self, target: ast.expr, bound: Bound) -> None:
        if isinstance(target, ast.Name):
            if self._class is not None:  # a class's own variable is reached as an attribute
                self._names.attributes[target.id].append(bound)
            self._names.bound[self._scope, target.id].append(bound)
        elif isinstance(target, ast.Attribute):
            self._names.attributes[target.attr].append(bound)
        elif isinstance(target, ast.Subscript):  # names[3] = 'x': one more element
            self._names.appended[_last(target.value)].append(bound)
        elif isinstance(target, (ast.Tuple, ast.List)):
            value = bound.node
            if isinstance(value, (ast.Tuple, ast.List)) and len(value.elts) == len(target.elts):
                self._bind_all(target.elts, [Bound(each, bound.scope) for each in value.elts])
            else:
                self._bind_all(target.elts, [Bound(None, bound.scope)] * len(target.elts))

    def _bind_all(self, targets: Iterable[ast.expr], bounds: Iterable[Bound]) -> None:
        for target, bound in zip(targets, bounds, strict=False):
            self._bind(target, bound)


def _parts(values: ast.expr, count: int, scope: Scope) -> list[Bound]:
    """What ``for a, b in values`` gives to each."""
    unknown = [Bound(None, scope)] * count
    if not isinstance(values, ast.Call):
        return unknown
    called = _last(values.func)
    if called == "enumerate" and count == 2 and values.args:
        return [unknown[0], Bound(values.args[0], scope, is_element=True)]
    if called == "zip" and len(values.args) == count:
        return [Bound(each, scope, is_element=True) for each in values.args]
    if called in ("items", "iteritems") and count == 2 and isinstance(values.func, ast.Attribute):
        base = values.func.value
        return [Bound(base, scope, is_element=True), Bound(base, scope, is_value=True)]
    return unknown
