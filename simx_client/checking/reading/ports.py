"""Possible ports of an expression, as far as a program's text shows."""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable, Iterable

from .scopes import Bound, Called, Scope
from .texts import DEEPEST, MOST, Texts

_OPERATORS: dict[type[ast.operator], Callable[[int, int], int]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.FloorDiv: int.__floordiv__,
    ast.Mod: operator.mod,
}
_HIGHEST = 65535


class Ports(Texts):
    """Evaluates whole numbers as well as texts."""

    def ports(self, call: Called, name: str, parameters: tuple[str, ...]) -> list[int]:
        """Return the ports that an argument of a call may name; a negative one means its absolute value."""
        nodes = [keyword.value for keyword in call.node.keywords if keyword.arg == name]
        place = parameters.index(name)
        before = call.node.args[: place + 1]
        if not nodes and len(before) > place and not any(isinstance(each, ast.Starred) for each in before):
            nodes = [before[place]]
        found = {abs(port) for node in nodes for port in self._numbers(node, call.scope, 0)}
        return sorted(port for port in found if 0 < port <= _HIGHEST)

    def _numbers(self, node: ast.expr | None, scope: Scope, depth: int) -> set[int]:
        """Return the possible values of an expression; empty if unknown, or if there are too many."""
        if node is None or depth >= DEEPEST:
            return set()
        found = set(self._evaluate(node, scope, depth + 1))
        return found if len(found) <= MOST else set()

    def _evaluate(self, node: ast.expr, scope: Scope, depth: int) -> Iterable[int]:
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.UAdd)):
            sign = -1 if isinstance(node.op, ast.USub) else 1
            return {sign * each for each in self._numbers(node.operand, scope, depth)}
        if isinstance(node, ast.BinOp) and (_is_text(node.left) or _is_text(node.right)):
            return {int(text) for text in self.of(node, scope) if _is_whole(text)}
        if isinstance(node, ast.BinOp) and (compute := _OPERATORS.get(type(node.op))):
            left, right = self._numbers(node.left, scope, depth), self._numbers(node.right, scope, depth)
            return {
                compute(one, other)
                for one in left
                for other in right
                if other or not isinstance(node.op, (ast.FloorDiv, ast.Mod))
            }
        if isinstance(node, ast.IfExp):
            return self._numbers(node.body, scope, depth) | self._numbers(node.orelse, scope, depth)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in ("int", "abs"):
            return self._numbers(node.args[0], scope, depth) if len(node.args) == 1 else ()
        if isinstance(node, ast.Name):
            return self._of_all(self._bound(node.id, scope), depth)
        if isinstance(node, ast.Attribute):
            bounds = [*self._meaning.bounds_of_member(node, scope), *self._of_parser(node.attr)]
            return self._of_all(bounds, depth)
        return {int(text) for text in self.of(node, scope) if _is_whole(text)}

    def _of_all(self, bounds: Iterable[Bound], depth: int) -> set[int]:
        return {number for bound in bounds for number in self._of_bound(bound, depth)}

    def _of_bound(self, bound: Bound, depth: int) -> Iterable[int]:
        node = bound.node
        if not bound.is_element:
            return self._numbers(node, bound.scope, depth)
        if isinstance(node, (ast.List, ast.Tuple, ast.Set)):
            return {number for each in node.elts for number in self._numbers(each, bound.scope, depth)}
        if (
            isinstance(node, ast.Call)
            and isinstance(node.func, ast.Name)
            and node.func.id in ("range", "xrange")
        ):
            limits = [self._numbers(each, bound.scope, depth) for each in node.args]
            if 0 < len(limits) <= 3 and all(len(each) == 1 for each in limits):
                numbers = [each.pop() for each in limits]
                return range(*numbers)[: MOST + 1] if len(numbers) < 3 or numbers[2] else ()
        return {
            int(text) for text in self._elements(node, bound.scope, depth, values=False) if _is_whole(text)
        }

    def _of_parser(self, name: str) -> list[Bound]:
        """Return the defaults of an argument of the command line, ``parser.add_argument('--port',
        default=19997)``."""
        return [
            Bound(keyword.value, call.scope)
            for call in self._names.by_called.get("add_argument", ())
            if any(
                isinstance(each, ast.Constant) and str(each.value).lstrip("-").replace("-", "_") == name
                for each in call.node.args
            )
            for keyword in call.node.keywords
            if keyword.arg == "default"
        ]


def _is_text(node: ast.expr) -> bool:
    """Return whether this is a text in the source, which `+` joins and does not add."""
    return isinstance(node, ast.JoinedStr) or (isinstance(node, ast.Constant) and isinstance(node.value, str))


def _is_whole(text: str) -> bool:
    return text.removeprefix("-").isdecimal() and text.isascii()
