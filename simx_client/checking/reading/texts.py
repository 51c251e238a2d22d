"""Possible texts of an expression. Parts known only at run time, such as a loop's index, become ``*``."""

from __future__ import annotations

import ast
import itertools
import re
from collections.abc import Callable, Iterable

from simx_client.checking.program import BINDING
from simx_client.protocol import constants

from .scopes import Bound, Called, Names, Scope
from .things import Foreign, Meaning

ANY = "*"
"""Unknown part of a text; alone: the whole text is unknown."""

DEEPEST = 12
"""Maximum number of steps from name to name; scripts need four."""

MOST_STEPS = 20_000
"""Maximum number of steps for one expression and everything it refers to."""

MOST = 60
"""Maximum number of texts of one expression; more are not worth listing."""

_PERCENT = re.compile(r"%(?:\((?P<name>\w+)\))?[-+ #0]*\d*(?:\.\d+)?(?P<kind>[a-zA-Z%])")
_BRACES = re.compile(r"\{\{|\}\}|\{(?P<field>[^{}:!]*)(?P<rest>[^{}]*)\}")
_WHOLE = re.compile(r"-?\d+")
_SAME = ("str", "unicode", "bytes", "list", "tuple", "sorted", "reversed", "set")
_SAME_METHODS = ("encode", "decode", "strip", "keys", "copy")


class Texts:
    """Evaluates expressions of one program."""

    def __init__(self, names: Names, meaning: Meaning | None = None) -> None:
        self._names = names
        self._meaning = meaning or Meaning(names)
        self._open: list[ast.expr | None] = []
        """Expressions under evaluation."""

        self._steps = 0

    def of(self, node: ast.expr | None, scope: Scope, depth: int = 0) -> frozenset[str]:
        """Return the possible values of an expression; a text with ANY in it is a pattern."""
        self._steps = self._steps + 1 if self._open else 0
        # The second condition: a name that refers to itself.
        if depth >= DEEPEST or node in self._open or self._steps > MOST_STEPS:
            return frozenset((ANY,))
        self._open.append(node)
        try:
            return _tidy(self._of(node, scope, depth))
        finally:
            self._open.pop()

    def elements(self, node: ast.expr, scope: Scope) -> frozenset[str]:
        """Return the possible elements of a list."""
        return _tidy(self._elements(node, scope, 0, values=True))

    def argument(self, call: Called, name: str, parameters: tuple[str, ...]) -> frozenset[str]:
        """Return the possible values of one argument of a call; ANY if the call does not show it."""
        node = self.written(call, name, parameters)
        return frozenset((ANY,)) if node is None else self.of(node, call.scope)

    @staticmethod
    def written(call: Called, name: str, parameters: tuple[str, ...]) -> ast.expr | None:
        """Return the expression of one argument of a call; None if the call does not show it."""
        for keyword in call.node.keywords:
            if keyword.arg == name:
                return keyword.value
        place = parameters.index(name)
        before = call.node.args[: place + 1]
        if len(before) <= place or any(isinstance(each, ast.Starred) for each in before):
            return None
        return before[place]

    def _of(self, node: ast.expr | None, scope: Scope, depth: int) -> Iterable[str]:
        deeper = depth + 1
        if isinstance(node, ast.Constant):
            return (_constant(node.value),)
        if isinstance(node, ast.JoinedStr):
            return _joined(self._piece(each, scope, deeper) for each in node.values)
        if isinstance(node, ast.BinOp):
            return self._binary(node, scope, deeper)
        if isinstance(node, ast.Call):
            return self._call(node, scope, deeper)
        if isinstance(node, (ast.Name, ast.Attribute)) and (numbers := self._constants(node, scope)):
            return numbers
        if isinstance(node, ast.Name):
            return self._all(self._bound(node.id, scope), deeper)
        if isinstance(node, ast.Attribute):
            return self._all(self._meaning.bounds_of_member(node, scope), deeper)
        if isinstance(node, ast.Subscript):
            return self._elements(node.value, scope, deeper, values=True)
        if isinstance(node, ast.IfExp):
            return self.of(node.body, scope, deeper) | self.of(node.orelse, scope, deeper)
        if isinstance(node, ast.BoolOp):
            return itertools.chain.from_iterable(self.of(each, scope, deeper) for each in node.values)
        return (ANY,)

    def _binary(self, node: ast.BinOp, scope: Scope, depth: int) -> Iterable[str]:
        """Return the possible texts of ``left + right`` and ``form % values``."""
        if isinstance(node.op, ast.Mod):
            return self._percent(node, scope, depth)
        if not isinstance(node.op, ast.Add) or _is_number(node.left) or _is_number(node.right):
            return (ANY,)
        return _joined((self.of(node.left, scope, depth), self.of(node.right, scope, depth)))

    def _constants(self, node: ast.expr, scope: Scope) -> list[str]:
        """Return the numbers of the binding's constants that an expression means."""
        paths = [each.path for each in self._meaning.of(node, scope) if isinstance(each, Foreign)]
        values = [
            getattr(constants, path.rpartition(".")[2], None)
            for path in paths
            if path.startswith(f"{BINDING}.")
        ]
        return [str(value) for value in values if isinstance(value, int)]

    def _all(self, bounds: Iterable[Bound], depth: int) -> Iterable[str]:
        found = [text for bound in bounds for text in self._bound_texts(bound, depth)]
        return found or (ANY,)

    def _bound_texts(self, bound: Bound, depth: int) -> Iterable[str]:
        if bound.node is None:
            return (ANY,)
        if bound.is_element or bound.is_value:
            return self._elements(bound.node, bound.scope, depth, values=bound.is_value)
        return self.of(bound.node, bound.scope, depth)

    def _bound(self, name: str, scope: Scope) -> list[Bound]:
        """Return the possible values of a name, as seen from a scope."""
        return self._meaning.bounds(name, scope)

    def _elements(self, node: ast.expr | None, scope: Scope, depth: int, *, values: bool) -> Iterable[str]:
        """Return the possible elements of an expression; of a dictionary its keys, or `values`."""
        self._steps += 1
        if depth >= DEEPEST or node is None or self._steps > MOST_STEPS:
            return (ANY,)
        deeper = depth + 1
        if isinstance(node, (ast.List, ast.Tuple, ast.Set)):
            return [text for each in node.elts for text in self.of(each, scope, deeper)]
        if isinstance(node, ast.Dict):
            parts = node.values if values else node.keys
            return [text for each in parts for text in self.of(each, scope, deeper)]
        if isinstance(node, (ast.ListComp, ast.GeneratorExp, ast.SetComp)):
            return self.of(node.elt, scope, deeper)
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
            return [
                text
                for each in (node.left, node.right)
                for text in self._elements(each, scope, deeper, values=values)
            ]
        if isinstance(node, ast.Call):
            inner = node.func.value if isinstance(node.func, ast.Attribute) else None
            name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
            if name == "values" and inner is not None:
                return self._elements(inner, scope, deeper, values=True)
            if name in _SAME_METHODS and inner is not None:
                return self._elements(inner, scope, deeper, values=values)
            if name in _SAME and node.args:
                return self._elements(node.args[0], scope, deeper, values=values)
            return (ANY,)
        if isinstance(node, (ast.Name, ast.Attribute)):
            name = node.id if isinstance(node, ast.Name) else node.attr
            if isinstance(node, ast.Name):
                bounds = self._bound(name, scope)
            else:
                bounds = self._meaning.bounds_of_member(node, scope)
            found = [
                text
                for bound in bounds
                for text in self._elements(bound.node, bound.scope, deeper, values=values)
            ]
            added = [
                text
                for bound in self._names.appended.get(name, ())
                for text in self.of(bound.node, bound.scope, deeper)
            ]
            return [*found, *added] or (ANY,)
        return (ANY,)

    def _piece(self, node: ast.expr, scope: Scope, depth: int) -> frozenset[str]:
        """Return the possible values of a part of an f-string."""
        if isinstance(node, ast.FormattedValue):
            return frozenset((ANY,)) if node.format_spec is not None else self.of(node.value, scope, depth)
        return self.of(node, scope, depth)

    def _percent(self, node: ast.BinOp, scope: Scope, depth: int) -> Iterable[str]:
        given = node.right.elts if isinstance(node.right, ast.Tuple) else [node.right]
        unknown = frozenset((ANY,))
        parts = [self.of(each, scope, depth) for each in given]

        def filled(form: str) -> Iterable[str]:
            left = iter(parts)

            def value(found: re.Match[str]) -> frozenset[str]:
                if found["kind"] == "%":
                    return frozenset("%")
                part = unknown if found["name"] else next(left, unknown)
                is_plain = found[0] in ("%d", "%i") and all(map(_is_plain, part))
                return part if is_plain or found[0] == "%s" else unknown

            return _filled(form, _PERCENT, value)

        return [text for form in self.of(node.left, scope, depth) for text in filled(form)]

    def _call(self, node: ast.Call, scope: Scope, depth: int) -> Iterable[str]:
        if isinstance(node.func, ast.Name) and node.func.id in _SAME[:3] and node.args:
            return self.of(node.args[0], scope, depth)
        if isinstance(node.func, ast.Attribute):
            if node.func.attr == "format":
                return self._format(node, scope, depth)
            if node.func.attr in _SAME_METHODS:
                return self.of(node.func.value, scope, depth)
        return (ANY,)

    def _format(self, node: ast.Call, scope: Scope, depth: int) -> Iterable[str]:
        assert isinstance(node.func, ast.Attribute)
        unknown = frozenset((ANY,))
        parts = [
            unknown if isinstance(each, ast.Starred) else self.of(each, scope, depth) for each in node.args
        ]
        named = {each.arg: self.of(each.value, scope, depth) for each in node.keywords if each.arg}

        def filled(form: str) -> Iterable[str]:
            place = itertools.count()

            def value(found: re.Match[str]) -> frozenset[str]:
                name = found["field"]
                if name is None:
                    return frozenset(found[0][0])
                key = str(next(place)) if name == "" else name
                if found["rest"]:
                    return unknown
                return (
                    parts[int(key)] if key.isdecimal() and int(key) < len(parts) else named.get(key, unknown)
                )

            return _filled(form, _BRACES, value)

        return [text for form in self.of(node.func.value, scope, depth) for text in filled(form)]


def is_known(text: str) -> bool:
    """Return whether at least a part of a text is known."""
    return bool(text.strip(ANY))


def matches(pattern: str, name: str) -> bool:
    """Return whether a text with unknown parts may be this name."""
    return re.fullmatch(".*".join(map(re.escape, pattern.split(ANY))), name, re.DOTALL) is not None


def _constant(value: object) -> str:
    if isinstance(value, bytes):
        return value.decode("utf-8", "replace")
    if isinstance(value, (str, int)) and not isinstance(value, bool):
        return str(value)
    return ANY


def _is_number(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, (int, float))


def _is_plain(text: str) -> bool:
    return text == ANY or _WHOLE.fullmatch(text) is not None


def _filled(
    form: str, blanks: re.Pattern[str], value: Callable[[re.Match[str]], frozenset[str]]
) -> Iterable[str]:
    """Yield a form with the possible values of each blank, requested in their order."""
    pieces: list[frozenset[str]] = []
    end = 0
    for found in blanks.finditer(form):
        pieces += (frozenset((form[end : found.start()],)), value(found))
        end = found.end()
    return _joined([*pieces, frozenset((form[end:],))])


def _joined(pieces: Iterable[frozenset[str]]) -> Iterable[str]:
    texts = [""]
    for piece in pieces:
        texts = [before + after for before in texts for after in sorted(piece)]
        if len(texts) > MOST:
            return (ANY,)
    return texts


def _tidy(texts: Iterable[str]) -> frozenset[str]:
    found = {re.sub(r"\*+", ANY, text) for text in texts}
    return frozenset(found) if found and len(found) <= MOST else frozenset((ANY,))
