"""Assignments to names, and calls with their arguments: the part of a program that its texts need.

The order of statements is not followed: a name may be anything that is assigned to it in its function. An
attribute may be anything that is assigned to an attribute of that name anywhere.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Generator, Iterable
from contextlib import contextmanager

from simx_client.checking.program import CannotRead, Program, Source

from .scopes import Bound, Called, Class, Function, Import, Loop, Names, Scope, last_name

_DEEPEST = 20_000
"""Maximum nesting of one file; a sum of this number of terms is nested as deep."""


def names_of(program: Program) -> Names:
    """Walk all files of a program. Raises CannotRead for a file with too deep nesting."""
    names = Names(program)
    with _deep():
        for source in program.sources:
            scope = names.modules[source.path] = Scope(source.path, None, None)
            _walk(names, source, scope)
    for call in names.calls:
        names.by_called[call.name].append(call)
    return names


def _walk(names: Names, source: Source, scope: Scope) -> None:
    try:
        _Walk(names, scope).visit(source.tree)
    except RecursionError:
        raise CannotRead(
            f"{source.path} is nested too deeply to be read; shorten its longest expression"
        ) from None


@contextmanager
def _deep() -> Generator[None]:
    """Raise the recursion limit: each part of a long sum is nested in the next one."""
    before = sys.getrecursionlimit()
    sys.setrecursionlimit(max(before, _DEEPEST))
    try:
        yield
    finally:
        sys.setrecursionlimit(before)


class _Walk(ast.NodeVisitor):
    def __init__(self, names: Names, scope: Scope) -> None:
        self._names = names
        self._scope: Scope = scope
        self._class: Class | None = None
        self._loop: Loop | None = None
        self._global: set[tuple[Scope, str]] = set()

    def visit_Import(self, node: ast.Import) -> None:
        for alias in node.names:
            top = alias.name.partition(".")[0]
            self._import(alias.asname or top, Import(0, alias.name if alias.asname else top), node.lineno)

    def visit_ImportFrom(self, node: ast.ImportFrom) -> None:
        module = node.module or ""
        for alias in node.names:
            if alias.name == "*":
                self._names.stars[self._scope.module].append(Import(node.level, module))
            else:
                self._import(alias.asname or alias.name, Import(node.level, module, alias.name), node.lineno)
                if alias.asname:
                    self._names.aliases[alias.name].add(alias.asname)

    def _import(self, name: str, what: Import, line: int) -> None:
        self._names.imports[self._place_of(name), name].append(what)
        self._names.lines.setdefault(what, (self._scope.file, line))
        if self._class is not None:
            self._names.attributes[name].append(Bound(ast.Name(name, ast.Load()), self._scope))

    def visit_ClassDef(self, node: ast.ClassDef) -> None:
        outer = self._class
        self._class = Class(node, self._scope)
        self._names.classes.append(self._class)
        self._names.defined[self._scope, node.name].append(self._class)
        self.generic_visit(node)
        self._class = outer

    def visit_FunctionDef(self, node: Function) -> None:
        owner, outer, loop = self._class, self._scope, self._loop
        is_method = owner is not None and not any(
            last_name(each) == "staticmethod" for each in node.decorator_list
        )
        self._scope = Scope(outer.file, outer, node, is_method, owner)
        self._class = self._loop = None
        if owner is None:
            self._names.defined[outer, node.name].append(self._scope)
        else:
            owner.methods[node.name] = self._scope
        called = owner.node.name if owner is not None and node.name == "__init__" else node.name
        self._names.functions[called].append(self._scope)
        self.generic_visit(node)
        self._scope, self._class, self._loop = outer, owner, loop

    visit_AsyncFunctionDef = visit_FunctionDef

    def visit_Global(self, node: ast.Global | ast.Nonlocal) -> None:
        self._global.update((self._scope, name) for name in node.names)

    visit_Nonlocal = visit_Global

    def visit_Return(self, node: ast.Return) -> None:
        if node.value is not None:
            self._names.returned[self._scope].append(node.value)
        self.generic_visit(node)

    def visit_Assign(self, node: ast.Assign) -> None:
        for target in node.targets:
            self._bind(target, Bound(node.value, self._scope))
        self.generic_visit(node)

    def visit_AnnAssign(self, node: ast.AnnAssign) -> None:
        if node.value is not None:
            self._bind(node.target, Bound(node.value, self._scope))
        self.generic_visit(node)

    def visit_NamedExpr(self, node: ast.NamedExpr) -> None:
        self._bind(node.target, Bound(node.value, self._scope))
        self.generic_visit(node)

    def visit_AugAssign(self, node: ast.AugAssign) -> None:
        self._bind(node.target, Bound(None, self._scope))
        self.generic_visit(node)

    def visit_With(self, node: ast.With | ast.AsyncWith) -> None:
        for item in node.items:
            if item.optional_vars is not None:
                self._bind(item.optional_vars, Bound(item.context_expr, self._scope, is_entered=True))
        self.generic_visit(node)

    visit_AsyncWith = visit_With

    def visit_For(self, node: ast.For | ast.AsyncFor) -> None:
        self._loop_over(node.target, node.iter)
        self.visit(node.iter)
        self._in_loop(node)

    visit_AsyncFor = visit_For

    def visit_While(self, node: ast.While) -> None:
        self._in_loop(node)

    def _in_loop(self, node: Loop) -> None:
        outer, self._loop = self._loop, node
        for each in (node.test,) if isinstance(node, ast.While) else ():
            self.visit(each)
        for each in node.body:
            self.visit(each)
        self._loop = outer
        for each in node.orelse:
            self.visit(each)

    def visit_comprehension(self, node: ast.comprehension) -> None:
        self._loop_over(node.target, node.iter)
        self.generic_visit(node)

    def visit_Call(self, node: ast.Call) -> None:
        self._names.calls.append(Called(node, self._scope, self._loop))
        if isinstance(node.func, ast.Attribute) and node.func.attr == "append" and len(node.args) == 1:
            self._names.appended[last_name(node.func.value)].append(Bound(node.args[0], self._scope))
        if last_name(node.func) == "setattr" and len(node.args) == 3:
            name = node.args[1]
            if isinstance(name, ast.Constant) and isinstance(name.value, str):
                self._names.attributes[name.value].append(Bound(node.args[2], self._scope))
        self.generic_visit(node)

    def visit_Attribute(self, node: ast.Attribute) -> None:
        if isinstance(node.ctx, ast.Load):
            self._names.read.append((node, self._scope))
        self.generic_visit(node)

    def _loop_over(self, target: ast.expr, values: ast.expr) -> None:
        bounds = [Bound(values, self._scope, is_element=True)]
        if isinstance(target, (ast.Tuple, ast.List)):
            self._bind_all(target.elts, _parts(values, len(target.elts), self._scope))
        else:
            self._bind(target, bounds[0])

    def _place_of(self, name: str) -> Scope:
        """Return the scope that a name belongs to, which is another function's or the module's after
        ``global``."""
        return self._scope.module if (self._scope, name) in self._global else self._scope

    def _bind(self, target: ast.expr, bound: Bound) -> None:
        if isinstance(target, ast.Name):
            if self._class is not None:  # a class's variable is read as an attribute
                self._names.attributes[target.id].append(bound)
            self._names.bound[self._place_of(target.id), target.id].append(bound)
        elif isinstance(target, ast.Attribute):
            self._names.attributes[target.attr].append(bound)
        elif isinstance(target, ast.Subscript):  # names[3] = 'x': one more element
            self._names.appended[last_name(target.value)].append(bound)
        elif isinstance(target, (ast.Tuple, ast.List)):
            value = bound.node
            if isinstance(value, (ast.Tuple, ast.List)) and len(value.elts) == len(target.elts):
                self._bind_all(target.elts, [Bound(each, bound.scope) for each in value.elts])
            else:
                self._bind_all(target.elts, [Bound(None, bound.scope)] * len(target.elts))
        if bound.node is not None and (name := last_name(bound.node)):
            self._names.aliases[name].add(last_name(target))

    def _bind_all(self, targets: Iterable[ast.expr], bounds: Iterable[Bound]) -> None:
        for target, bound in zip(targets, bounds, strict=False):
            self._bind(target, bound)


def _parts(values: ast.expr, count: int, scope: Scope) -> list[Bound]:
    """Return the values that ``for a, b in values`` assigns to each name."""
    unknown = [Bound(None, scope)] * count
    if not isinstance(values, ast.Call):
        return unknown
    called = last_name(values.func)
    if called == "enumerate" and count == 2 and values.args:
        return [unknown[0], Bound(values.args[0], scope, is_element=True)]
    if called == "zip" and len(values.args) == count:
        return [Bound(each, scope, is_element=True) for each in values.args]
    if called in ("items", "iteritems") and count == 2 and isinstance(values.func, ast.Attribute):
        base = values.func.value
        return [Bound(base, scope, is_element=True), Bound(base, scope, is_value=True)]
    return unknown
