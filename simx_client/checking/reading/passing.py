"""Find the arguments that callers pass to a function."""

from __future__ import annotations

import ast
from collections.abc import Callable, Collection

from .scopes import Bound, Called, Class, Names, Scope, last_name


class Passing:
    """Finds the possible arguments of a parameter."""

    def __init__(self, names: Names, of: Callable[[ast.expr, Scope], Collection[object]]) -> None:
        """Prepare.

        Args:
            names: names and calls of the program.
            of: returns the meanings of an expression; empty if unknown.
        """
        self._names = names
        self._of = of

    def passed(self, name: str, scope: Scope) -> list[Bound]:
        """Return the arguments that callers pass as this parameter; empty without a parameter of this name."""
        function = scope.function
        if function is None:
            return []
        order = [*function.args.posonlyargs, *function.args.args]
        parameters = [each.arg for each in order]
        if name not in parameters and name not in [each.arg for each in function.args.kwonlyargs]:
            return []
        place = parameters.index(name) if name in parameters else None
        if place == 0 and scope.is_method:
            return []
        found: list[Bound] = []
        for call, shift in self._callers(scope):
            named = [each.value for each in call.node.keywords if each.arg == name]
            if named:
                found.append(Bound(named[0], call.scope))
            elif place is not None and 0 <= place - shift < len(call.node.args):
                value = call.node.args[place - shift]
                found.append(Bound(None if isinstance(value, ast.Starred) else value, call.scope))
        defaults = dict(zip(reversed(parameters), reversed(function.args.defaults), strict=False))
        if name in defaults:
            found.append(Bound(defaults[name], scope.parent or scope))
        return found or [Bound(None, scope)]

    def _callers(self, scope: Scope) -> list[tuple[Called, int]]:
        """Return possible calls of a function, and how many of its parameters they omit."""
        names = self._names
        function, owner = scope.function, scope.owner
        assert function is not None
        is_constructor = owner is not None and function.name == "__init__"
        wanted = names.all_names(owner.node.name if is_constructor and owner else function.name)
        if is_constructor and owner is not None:
            for each in names.classes:  # those that inherit it
                if "__init__" not in each.methods and {last_name(base) for base in each.node.bases} & wanted:
                    wanted |= names.all_names(each.node.name)
        found: list[tuple[Called, int]] = []
        for call in (each for name in sorted(wanted) for each in names.by_called.get(name, ())):
            things = self._of(call.node.func, call.scope)
            if (
                not things
                or scope in things
                or (is_constructor and any(isinstance(t, Class) for t in things))
            ):
                found.append((call, int(scope.is_method)))
        if is_constructor:
            for call in names.by_called.get("__init__", ()):
                things = self._of(call.node.func, call.scope)
                if not things or scope in things:
                    is_super = isinstance(call.node.func, ast.Attribute) and isinstance(
                        call.node.func.value, ast.Call
                    )
                    found.append((call, int(is_super)))
        return found
