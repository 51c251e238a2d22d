"""Scopes, names and calls of a program: ``names`` finds them and the other modules read them."""

from __future__ import annotations

import ast
from collections import defaultdict
from dataclasses import dataclass, field
from pathlib import Path

from simx_client.checking.program import Program

Function = ast.FunctionDef | ast.AsyncFunctionDef
Loop = ast.For | ast.AsyncFor | ast.While


@dataclass(frozen=True, eq=False)
class Scope:
    """A function, or a module."""

    file: Path
    parent: Scope | None
    function: Function | None
    is_method: bool = False
    """The first parameter is the object, or the class, of the call."""

    owner: Class | None = None
    """Class of the method."""

    @property
    def module(self) -> Scope:
        return self if self.parent is None else self.parent.module


@dataclass(frozen=True, eq=False)
class Class:
    """A class of the program."""

    node: ast.ClassDef
    scope: Scope
    """Scope in which it is defined."""

    methods: dict[str, Scope] = field(default_factory=dict[str, Scope])


@dataclass(frozen=True)
class Import:
    """Name bound by an import statement: a module, or something of it."""

    level: int
    module: str
    attribute: str = ""


@dataclass(frozen=True)
class Bound:
    """A possible value of a name."""

    node: ast.expr | None
    """None: unknown."""

    scope: Scope
    is_element: bool = False
    """The value is an element of `node`; of a dictionary a key."""

    is_value: bool = False
    """The value is a value of a dictionary."""

    is_entered: bool = False
    """The value is the result of ``__enter__``."""


@dataclass(frozen=True)
class Called:
    """One call, and its position."""

    node: ast.Call
    scope: Scope
    loop: Loop | None = None
    """The innermost loop of its function around it."""

    @property
    def name(self) -> str:
        """Return the last part of the called expression."""
        return last_name(self.node.func)

    @property
    def line(self) -> int:
        return self.node.lineno


@dataclass
class Names:
    """All names of a program."""

    program: Program
    modules: dict[Path, Scope] = field(default_factory=dict[Path, Scope])
    bound: dict[tuple[Scope, str], list[Bound]] = field(default_factory=lambda: defaultdict(list[Bound]))
    """By scope and name."""

    attributes: dict[str, list[Bound]] = field(default_factory=lambda: defaultdict(list[Bound]))
    appended: dict[str, list[Bound]] = field(default_factory=lambda: defaultdict(list[Bound]))
    """Values that ``.append`` adds, by the list's last name."""

    calls: list[Called] = field(default_factory=list[Called])
    by_called: dict[str, list[Called]] = field(default_factory=lambda: defaultdict(list[Called]))
    functions: dict[str, list[Scope]] = field(default_factory=lambda: defaultdict(list[Scope]))
    """By the name in calls; a class's ``__init__`` under the class's name."""

    defined: dict[tuple[Scope, str], list[Scope | Class]] = field(
        default_factory=lambda: defaultdict(list[Scope | Class])
    )
    """Functions and classes by scope and name, without methods."""

    classes: list[Class] = field(default_factory=list[Class])
    returned: dict[Scope, list[ast.expr]] = field(default_factory=lambda: defaultdict(list[ast.expr]))
    imports: dict[tuple[Scope, str], list[Import]] = field(default_factory=lambda: defaultdict(list[Import]))
    stars: dict[Scope, list[Import]] = field(default_factory=lambda: defaultdict(list[Import]))
    """Modules from which a file imports all names."""

    lines: dict[Import, tuple[Path, int]] = field(default_factory=dict[Import, tuple[Path, int]])
    """First import of each."""

    aliases: dict[str, set[str]] = field(default_factory=lambda: defaultdict(set[str]))
    """Other names that are assigned to a function or class."""

    read: list[tuple[ast.Attribute, Scope]] = field(default_factory=list[tuple[ast.Attribute, Scope]])

    def all_names(self, name: str) -> set[str]:
        """Return a name with its aliases, and theirs."""
        found: set[str] = set()
        waiting = [name]
        while waiting:
            each = waiting.pop()
            if each not in found:
                found.add(each)
                waiting += self.aliases.get(each, ())
        return found


def last_name(node: ast.expr) -> str:
    """Return ``c`` for ``a.b.c``; empty for an expression without a name."""
    if isinstance(node, ast.Attribute):
        return node.attr
    return node.id if isinstance(node, ast.Name) else ""
