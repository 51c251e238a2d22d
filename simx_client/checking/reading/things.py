"""Meaning of an expression: a module, a class, a function, or something of another library.

So a call is recognised by the function and not by its name: a wrapper's ``simxStart`` does not count as a
call of the remote API, but ``api = vrep; f = api.simxStart; f(…)`` does.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from simx_client.checking.program import (
    BINDING,
    BINDINGS,
    ZMQ_CLIENTS,
    Folder,
    Library,
    Module,
    Source,
    imported_by_call,
)

from .passing import Passing
from .scopes import Bound, Class, Import, Names, Scope, last_name

_DEEPEST = 24
"""Maximum number of steps from name to name."""

_MOST_STEPS = 1000
"""Maximum number of steps for one expression and everything it refers to; a program of a few thousand lines
needs hundreds."""

_MOST_STEPS_IN_ALL = 200_000
"""Maximum number of steps for a whole program."""

_LONGEST = 200

_MEANT = (ast.Name, ast.Attribute, ast.Call, ast.IfExp, ast.BoolOp, ast.Await, ast.NamedExpr, ast.Subscript)
"""Expressions that may mean one of these."""

_GIVING = ("require", "getObject")
"""Methods of other libraries whose text argument matters: ``client.require('sim')``."""

_PROPERTIES = ("property", "cached_property")
_SAME = ("list", "tuple", "sorted", "reversed", "set", "iter", "next", "enumerate")


@dataclass(frozen=True)
class Foreign:
    """Something of a library: ``vrep.simxStart``,
    ``zmqRemoteApi.RemoteAPIClient().require('sim').getObject``."""

    path: str


@dataclass(frozen=True)
class Instance:
    """An object of a class of the program."""

    of: Class


Thing = Foreign | Instance | Class | Scope | Source | Folder
Things = frozenset[Thing]

NOTHING: Things = frozenset()


class Meaning:
    """Finds the meanings of expressions of one program. Expressions known only at run time have none."""

    def __init__(self, names: Names) -> None:
        self._names = names
        self._passing = Passing(names, self.of)
        self._known: dict[tuple[ast.expr, Scope], Things] = {}
        self._open: set[ast.expr] = set()
        """Expressions under evaluation."""

        self._steps = self._in_all = 0
        self._cuts = 0
        """Number of expressions not followed: results that depend on them are not final."""

    def of(self, node: ast.expr | None, scope: Scope) -> Things:
        """Return the possible meanings of an expression."""
        if node is None:
            return NOTHING
        key = node, scope
        if (known := self._known.get(key)) is not None:
            return known
        if not isinstance(node, _MEANT):
            return NOTHING
        if not self._open:
            self._in_all += self._steps
            self._steps = 0
        self._steps += 1
        if node in self._open or len(self._open) > _DEEPEST or self._is_tired:
            self._cuts += 1
            return NOTHING
        cuts = self._cuts
        self._open.add(node)
        try:
            found = frozenset(self._of(node, scope))
        finally:
            self._open.discard(node)
        if cuts == self._cuts or not self._open:
            self._known[key] = found
        return found

    @property
    def _is_tired(self) -> bool:
        return self._steps > _MOST_STEPS or self._in_all > _MOST_STEPS_IN_ALL

    def _of(self, node: ast.expr, scope: Scope) -> Iterable[Thing]:
        if isinstance(node, ast.Name):
            return self.named(node.id, scope)
        if isinstance(node, ast.Attribute):
            return self._all_members(self.of(node.value, scope), node.attr, node.value)
        if isinstance(node, ast.Call):
            return self._call(node, scope)
        if isinstance(node, ast.IfExp):
            return self.of(node.body, scope) | self.of(node.orelse, scope)
        if isinstance(node, ast.BoolOp):
            return self._union(node.values, scope)
        if isinstance(node, (ast.Await, ast.NamedExpr)):
            return self.of(node.value, scope)
        if isinstance(node, ast.Subscript):
            return self._elements(node.value, scope)
        return ()

    def _union(self, nodes: Iterable[ast.expr], scope: Scope) -> Things:
        return frozenset(each for node in nodes for each in self.of(node, scope))

    # --- names -------------------------------------------------------------------------------------

    def named(self, name: str, scope: Scope) -> Things:
        """Return the meanings of a name, as seen from a scope."""
        place: Scope | None = scope
        while place is not None:
            found: set[Thing] = set(self._names.defined.get((place, name), ()))
            imports = self._names.imports.get((place, name), ())
            for each in imports:
                found |= self.imported(each, place)
            bounds = [*self._names.bound.get((place, name), ()), *self._passing.passed(name, place)]
            for bound in bounds:
                found |= self._bound(bound)
                if self._is_tired:
                    break
            if place.is_method and place.owner and place.function and _first(place.function) == name:
                found.add(Instance(place.owner))
            if found or imports or bounds:
                return frozenset(found)
            place = place.parent
        return self._from_stars(name, scope.module)

    def _from_stars(self, name: str, module: Scope) -> Things:
        found: set[Thing] = set()
        for each in self._names.stars.get(module, ()):
            target = self._names.program.links.get((module.file, each.level, each.module))
            if isinstance(target, Source):
                found |= self._member(target, name)
            elif target == Library(BINDING) and name.startswith(("simx", "sim_")):
                found.add(Foreign(f"{BINDING}.{name}"))
            elif isinstance(target, Library) and target.name in ZMQ_CLIENTS and name == "RemoteAPIClient":
                found.add(Foreign(f"{target.name}.{name}"))
        return frozenset(found)

    def imported(self, each: Import, scope: Scope) -> Things:
        """Return the meanings of an import statement."""
        links, file = self._names.program.links, scope.file
        module = links.get((file, each.level, each.module))
        if not each.attribute:
            return _thing(module)
        submodule = links.get((file, each.level, f"{each.module}.{each.attribute}".lstrip(".")))
        found = (
            NOTHING
            if module is None
            else frozenset(m for t in _thing(module) for m in self._member(t, each.attribute))
        )
        return found | _thing(submodule) if found == NOTHING or isinstance(module, Library) else found

    def _bound(self, bound: Bound) -> Things:
        if bound.is_element or bound.is_value:
            return NOTHING if bound.node is None else self._elements(bound.node, bound.scope)
        found = self.of(bound.node, bound.scope)
        if bound.is_entered:
            return frozenset(entered for thing in found for entered in self._entered(thing))
        return found

    def _entered(self, thing: Thing) -> Things:
        """Return the value that ``with`` binds: the result of ``__enter__``, else the object itself."""
        method = self.method(thing.of, "__enter__", set()) if isinstance(thing, Instance) else None
        return (
            frozenset((thing,))
            if method is None
            else self._union(self._names.returned.get(method, ()), method)
        )

    # --- members -----------------------------------------------------------------------------------

    def _all_members(self, things: Things, name: str, base: ast.expr) -> Things:
        if not things and not isinstance(
            base, ast.Constant
        ):  # of an unknown value: anything that is assigned to that name
            return frozenset(t for bound in self._names.attributes.get(name, ()) for t in self._bound(bound))
        return frozenset(member for thing in things for member in self._member(thing, name))

    def _member(self, thing: Thing, name: str) -> Things:
        if isinstance(thing, Foreign):
            return _foreign(f"{thing.path}.{name}")
        scope = self._names.modules.get(thing.path) if isinstance(thing, Source) else None
        if scope is not None and (found := self.named(name, scope)):
            return found
        if isinstance(thing, (Source, Folder)):
            return _thing(self._names.program.submodule(thing, name))
        if isinstance(thing, (Class, Instance)):
            return self._of_class(thing.of if isinstance(thing, Instance) else thing, name, set())
        return NOTHING

    def _of_class(self, owner: Class, name: str, seen: set[Class]) -> Things:
        """Return a method, else the values assigned to an attribute of this name, else the result of
        ``__getattr__``."""
        if (method := self.method(owner, name, seen)) is not None:
            function = method.function
            if function and any(last_name(each) in _PROPERTIES for each in function.decorator_list):
                return self._union(self._names.returned.get(method, ()), method)
            return frozenset((method,))
        if bounds := self._names.attributes.get(name):
            return frozenset(thing for bound in bounds for thing in self._bound(bound))
        passing_on = self.method(owner, "__getattr__", set())
        found: set[Thing] = set()
        for node in self._names.returned.get(passing_on, ()) if passing_on else ():
            if isinstance(node, ast.Call) and last_name(node.func) == "getattr" and node.args:
                for base in self.of(node.args[0], passing_on or owner.scope):
                    found |= self._member(base, name)
        return frozenset(found)

    def method(self, owner: Class, name: str, seen: set[Class]) -> Scope | None:
        """Return a method of a class or of its base classes."""
        if owner in seen:
            return None
        seen.add(owner)
        if name in owner.methods:
            return owner.methods[name]
        for base in self.bases(owner):
            if (found := self.method(base, name, seen)) is not None:
                return found
        return None

    def bases(self, owner: Class) -> list[Class]:
        """Return the base classes in the program."""
        found = self._union(owner.node.bases, owner.scope)
        return [each for each in found if isinstance(each, Class)]

    # --- calls and lists ---------------------------------------------------------------------------

    def _call(self, node: ast.Call, scope: Scope) -> Iterable[Thing]:
        called = last_name(node.func)
        if isinstance(node.func, ast.Name) and called == "getattr" and len(node.args) > 1:
            base = node.args[0]
            things = self.of(base, scope)
            names = self._written(node.args[1], scope)
            return frozenset(thing for name in names for thing in self._all_members(things, name, base))
        if called == "super" and scope.owner is not None:
            return [Instance(each) for each in self.bases(scope.owner)]
        if module := imported_by_call(node):
            return _thing(self._names.program.links.get((scope.file, 0, module)))
        if isinstance(node.func, ast.Name) and called in _SAME:
            return self._elements(node, scope) if called == "next" else ()
        found: set[Thing] = set()
        for thing in self.of(node.func, scope):
            if isinstance(thing, Class):
                found.add(Instance(thing))
            elif isinstance(thing, Scope):
                found |= self._union(self._names.returned.get(thing, ()), thing)
            elif isinstance(thing, Foreign):
                found |= _foreign(f"{thing.path}({self._given(thing.path, node)})")
        return found

    def _written(self, node: ast.expr, scope: Scope) -> Iterator[str]:
        """Yield the texts that a name gets directly, by assignments or from callers."""
        bounds = self.bounds(node.id, scope) if isinstance(node, ast.Name) else [Bound(node, scope)]
        for each in bounds:
            nodes = (
                each.node.elts
                if each.is_element and isinstance(each.node, (ast.List, ast.Tuple))
                else [each.node]
            )
            for one in nodes:
                if isinstance(one, ast.Constant) and isinstance(one.value, str):
                    yield one.value

    @staticmethod
    def _given(path: str, node: ast.Call) -> str:
        if (
            path.rpartition(".")[2] not in _GIVING
            or not node.args
            or not isinstance(node.args[0], ast.Constant)
        ):
            return ""
        return repr(node.args[0].value)

    def _elements(self, node: ast.expr, scope: Scope) -> Things:
        """Return the meanings of the elements of a list, or of the values of a dictionary."""
        if isinstance(node, (ast.List, ast.Tuple, ast.Set)):
            return self._union(node.elts, scope)
        if isinstance(node, ast.Dict):
            return self._union(node.values, scope)
        if isinstance(node, (ast.ListComp, ast.GeneratorExp, ast.SetComp)):
            return self.of(node.elt, scope)
        if isinstance(node, ast.DictComp):
            return self.of(node.value, scope)
        if isinstance(node, ast.Call) and node.args and last_name(node.func) in _SAME:
            return self._elements(node.args[0], scope)
        if (
            isinstance(node, ast.Call)
            and isinstance(node.func, ast.Attribute)
            and node.func.attr in ("values", "get", "pop")
        ):
            return self._elements(node.func.value, scope)
        if not isinstance(node, (ast.Name, ast.Attribute)) or node in self._open:
            return NOTHING
        self._open.add(node)
        try:
            found: set[Thing] = set()
            for bound in self._bounds(node, scope):
                if bound.node is not None and len(self._open) <= _DEEPEST:
                    found |= self._elements(bound.node, bound.scope)
            for bound in self._names.appended.get(last_name(node), ()):
                found |= self.of(bound.node, bound.scope)
            return frozenset(found)
        finally:
            self._open.discard(node)

    def _bounds(self, node: ast.Name | ast.Attribute, scope: Scope) -> list[Bound]:
        if isinstance(node, ast.Attribute):
            return self._names.attributes.get(node.attr, [])
        return self.bounds(node.id, scope)

    # --- what names are bound to --------------------------------------------------------------------

    def bounds(self, name: str, scope: Scope) -> list[Bound]:
        """Return the possible expressions of a name, as seen from a scope, in other modules too."""
        place: Scope | None = scope
        while place is not None:
            found = [*self._names.bound.get((place, name), ()), *self._passing.passed(name, place)]
            for each in self._names.imports.get((place, name), ()):
                found += self._bounds_in(
                    self._names.program.links.get((place.file, each.level, each.module)), each.attribute
                )
            if found:
                return found
            place = place.parent
        stars = self._names.stars.get(scope.module, ())
        links = (self._names.program.links.get((scope.file, each.level, each.module)) for each in stars)
        return [bound for module in links for bound in self._bounds_in(module, name)]

    def bounds_of_member(self, node: ast.Attribute, scope: Scope) -> list[Bound]:
        """Return the possible expressions of an attribute: of a module's name, else of any attribute of that
        name."""
        modules = [each for each in self.of(node.value, scope) if isinstance(each, Source)]
        found = [bound for module in modules for bound in self._bounds_in(module, node.attr)]
        return found or self._names.attributes.get(node.attr, [])

    def _bounds_in(self, module: Module | None, name: str) -> list[Bound]:
        scope = self._names.modules.get(module.path) if isinstance(module, Source) else None
        return self._names.bound.get((scope, name), []) if scope is not None else []


def _thing(module: Module | None) -> Things:
    if module is None:
        return NOTHING
    return frozenset((Foreign(module.name),)) if isinstance(module, Library) else frozenset((module,))


def _foreign(path: str) -> Things:
    if path in {f"{BINDING}.{name}" for name in BINDINGS}:  # from vrep import vrep
        path = BINDING
    return frozenset((Foreign(path),)) if len(path) <= _LONGEST else NOTHING


def _first(function: ast.FunctionDef | ast.AsyncFunctionDef) -> str:
    order = [*function.args.posonlyargs, *function.args.args]
    return order[0].arg if order else ""
