"""Scopes, names and calls of a program: what ``names`` finds and the others read."""

from __future__ import annotations

import ast
from collections import defaultdict
from dataclasses import dataclass, field
from pathlib import Path

from .program import Program

Function = ast.FunctionDef | ast.AsyncFunctionDef
Loop = ast.For | ast.AsyncFor | ast.While


@dataclass(frozen=True, eq=False)
class Scope:
    """A function, or a module."""

    file: Path
    parent: Scope | None
    function: Function | None
    is_method: bool = False
    """Its first parameter is the object, or the class, that it is called of."""

    owner: Class | None = None
    """Whose method it is."""

    @property
    def module(self) -> Scope:
        return self if self.parent is None else self.parent.module


@dataclass(frozen=True, eq=False)
class Class:
    """A class of the program."""

    node: ast.ClassDef
    scope: Scope
    """Where it is defined."""

    methods: dict[str, Scope] = field(default_factory=dict[str, Scope])


@dataclass(frozen=True)
class Import:
    """What an import statement gives to a name: a module, or something of it."""

    level: int
    module: str
    attribute: str = ""


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

    is_entered: bool = False
    """What its ``__enter__`` gives is meant."""


@dataclass(frozen=True)
class Called:
    """One call, and where it stands."""

    node: ast.Call
    scope: Scope
    loop: Loop | None = None
    """The innermost loop of its function around it."""

    @property
    def name(self) -> str:
        """The last part of what is called."""
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
    """By the list's last name: what ``.append`` adds."""

    calls: list[Called] = field(default_factory=list[Called])
    by_called: dict[str, list[Called]] = field(default_factory=lambda: defaultdict(list[Called]))
    functions: dict[str, list[Scope]] = field(default_factory=lambda: defaultdict(list[Scope]))
    """By the name under which they are called; a class's ``__init__`` under the class's."""

    defined: dict[tuple[Scope, str], list[Scope | Class]] = field(
        default_factory=lambda: defaultdict(list[Scope | Class])
    )
    """Functions and classes by scope and name; not the methods."""

    classes: list[Class] = field(default_factory=list[Class])
    returned: dict[Scope, list[ast.expr]] = field(default_factory=lambda: defaultdict(list[ast.expr]))
    imports: dict[tuple[Scope, str], list[Import]] = field(default_factory=lambda: defaultdict(list[Import]))
    stars: dict[Scope, list[Import]] = field(default_factory=lambda: defaultdict(list[Import]))
    """Modules all of whose names a file imports."""

    lines: dict[Import, tuple[Path, int]] = field(default_factory=dict[Import, tuple[Path, int]])
    """Where something is first imported."""

    aliases: dict[str, set[str]] = field(default_factory=lambda: defaultdict(set[str]))
    """Other names that a function or class is given somewhere."""

    read: list[tuple[ast.Attribute, Scope]] = field(default_factory=list[tuple[ast.Attribute, Scope]])

    def all_names(self, name: str) -> set[str]:
        """A name with its aliases, and theirs."""
        found: set[str] = set()
        waiting = [name]
        while waiting:
            each = waiting.pop()
            if each not in found:
                found.add(each)
                waiting += self.aliases.get(each, ())
        return found


def last_name(node: ast.expr) -> str:
    """``c`` of ``a.b.c``; empty for what has no name."""
    if isinstance(node, ast.Attribute):
        return node.attr
    return node.id if isinstance(node, ast.Name) else ""
