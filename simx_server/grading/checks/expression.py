"""The language of checks: comparisons of numbers that a fixed list of functions reads from the simulation.

A text is parsed by Python's parser into a tree, of which only the kinds of nodes in `_Reader` are accepted. Each
becomes a function of this module; nothing of the text is ever compiled or executed by Python.
"""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Protocol

from simx_client.protocol.nearest import did_you_mean

LONGEST = 1000
"""Characters of an expression."""

DEEPEST = 20
"""Levels of an expression."""

Value = float | bool
Arguments = tuple[str | float, ...]


class Sight(Protocol):
    """The values that expressions read."""

    time: float
    """Seconds since the start of the run."""

    def read(self, function: str, arguments: Arguments) -> Value:
        """Return the present value of a function. Equal calls of one simulation step have one value."""
        ...


Evaluate = Callable[[Sight], Value]


class ExpressionError(ValueError):
    """A text that is not an expression; the message says what is valid."""


@dataclass(frozen=True, slots=True)
class Function:
    """A function of the language."""

    form: str
    """As in the manual: ``distance(object, other)``."""

    meaning: str
    texts: int
    """Number of names that it takes first."""

    numbers: int = 0
    """Number of numbers that may follow."""

    objects: int = -1
    """How many of the names are objects of the scene; -1: all."""

    is_bool: bool = False


FUNCTIONS = {
    "distance": Function("distance(a, b)", "between the origins of two objects, m", 2),
    "gap": Function("gap(a, b)", "smallest distance between two shapes or models, m", 2),
    "x": Function("x(object)", "position along the world's x axis, m", 1),
    "y": Function("y(object)", "position along the world's y axis, m", 1),
    "z": Function("z(object)", "height, m", 1),
    "speed": Function("speed(object)", "linear velocity, m/s", 1),
    "tilt": Function("tilt(object)", "angle between the object's z axis and the world's, rad", 1),
    "angle": Function("angle(a, b)", "angle of the rotation between two objects, rad", 2),
    "travelled": Function("travelled(object)", "length of its path since the start, m", 1),
    "joint": Function("joint(name)", "joint position, rad or m", 1),
    "joint_velocity": Function("joint_velocity(name)", "rad/s or m/s", 1),
    "touches": Function("touches(a, b)", "true while shapes of two objects touch", 2, is_bool=True),
    "collisions": Function("collisions(a, b)", "how often contact has started since the start", 2),
    "signal": Function(
        "signal(name, default)", "number of a float or integer signal; default without one", 1, 1, 0
    ),
    "is_set": Function("is_set(name)", "true while a signal of any type is set", 1, 0, 0, is_bool=True),
    "value": Function("value(object, property)", "a number among the object's properties", 2, 0, 1),
    "abs": Function("abs(number)", "its size", 0, 1),
}
"""All functions that read the simulation, and ``abs``."""

_COMPARE: dict[type[ast.cmpop], Callable[[Any, Any], bool]] = {
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
}
_COMPUTE: dict[type[ast.operator], Callable[[float, float], float]] = {
    ast.Add: float.__add__,
    ast.Sub: float.__sub__,
    ast.Mult: float.__mul__,
    ast.Div: float.__truediv__,
}
_CONSTANTS = {"pi": math.pi, "true": True, "false": False, "True": True, "False": False}


@dataclass(slots=True)
class Expression:
    """An expression, ready to be evaluated."""

    text: str
    evaluate: Evaluate = field(repr=False)
    is_bool: bool = True
    objects: tuple[str, ...] = ()
    """The objects that it names."""


def parse(text: str) -> Expression:
    """Return the expression of a text.

    Raises:
        ExpressionError: it is none, or not true or false.
    """
    if len(text) > LONGEST:
        raise ExpressionError(f"an expression has at most {LONGEST} characters, not {len(text)}")
    try:
        tree = ast.parse(text.strip(), mode="eval")
    except (SyntaxError, ValueError, RecursionError, MemoryError) as problem:
        reason = problem.msg if isinstance(problem, SyntaxError) else str(problem)
        raise ExpressionError(f"{text!r} is not an expression ({reason}); {_VALID}") from None
    reader = _Reader()
    evaluate, is_bool = reader.read(tree.body, 0)
    if not is_bool:
        raise ExpressionError(
            f"{text!r} is a number, and a check is true or false: compare it, as in {_EXAMPLE}"
        )
    return Expression(text.strip(), evaluate, is_bool, tuple(dict.fromkeys(reader.objects)))


_EXAMPLE = 'distance("gripper", "cube") < 0.02'
_VALID = f"valid is for example {_EXAMPLE}"


class _Reader:
    """Turns the accepted kinds of nodes into functions, and says which values they have: numbers, or true and false."""

    def __init__(self) -> None:
        self.objects: list[str] = []

    def read(self, node: ast.expr, depth: int) -> tuple[Evaluate, bool]:
        if depth > DEEPEST:
            raise ExpressionError(f"an expression has at most {DEEPEST} levels")
        depth += 1
        match node:
            case ast.Constant():
                return self._constant(node.value)
            case ast.Name():
                return self._name(node.id)
            case ast.BoolOp():
                return self._logic(node, depth)
            case ast.UnaryOp(op=ast.Not()):
                one = self._of(node.operand, True, "not", depth)
                return lambda sight: not one(sight), True
            case ast.UnaryOp(op=ast.USub()):
                number = self._of(node.operand, False, "-", depth)
                return lambda sight: -number(sight), False
            case ast.BinOp():
                return self._computed(node, depth)
            case ast.Compare():
                return self._comparison(node, depth)
            case ast.Call():
                return self._call(node, depth)
            case _:
                raise ExpressionError(
                    f"{ast.unparse(node)[:60]!r} cannot be used in a check; valid are numbers, and, or, not, "
                    f"+ - * /, comparisons, and the functions {', '.join(FUNCTIONS)}"
                )

    def _of(self, node: ast.expr, is_bool: bool, what: str, depth: int) -> Evaluate:
        evaluate, found = self.read(node, depth)
        if found != is_bool:
            wanted = "something true or false" if is_bool else "numbers"
            raise ExpressionError(f"{what!r} takes {wanted}, not {ast.unparse(node)[:60]!r}")
        return evaluate

    def _constant(self, value: object) -> tuple[Evaluate, bool]:
        if isinstance(value, bool):
            return lambda _sight: value, True
        if isinstance(value, (int, float)):
            number = _finite(value)
            return lambda _sight: number, False
        raise ExpressionError(f"{value!r} stands alone; names are arguments of functions, as in {_EXAMPLE}")

    def _name(self, name: str) -> tuple[Evaluate, bool]:
        if name == "time":
            return lambda sight: sight.time, False
        if name in _CONSTANTS:
            value = _CONSTANTS[name]
            return lambda _sight: value, isinstance(value, bool)
        known = ["time", *_CONSTANTS, *FUNCTIONS]
        raise ExpressionError(
            f"{name!r} is not known{did_you_mean(name, known)}; names of objects are written in quotes"
        )

    def _logic(self, node: ast.BoolOp, depth: int) -> tuple[Evaluate, bool]:
        word = "and" if isinstance(node.op, ast.And) else "or"
        parts = [self._of(each, True, word, depth) for each in node.values]
        decide = all if word == "and" else any
        # All parts are evaluated each time: some functions count what has happened.
        return lambda sight: decide([part(sight) for part in parts]), True

    def _computed(self, node: ast.BinOp, depth: int) -> tuple[Evaluate, bool]:
        compute = _COMPUTE.get(type(node.op))
        if compute is None:
            raise ExpressionError(f"{ast.unparse(node)[:60]!r}: valid operators are + - * /")
        left, right = (self._of(each, False, "+ - * /", depth) for each in (node.left, node.right))

        def computed(sight: Sight) -> float:
            first, second = float(left(sight)), float(right(sight))
            try:
                return compute(first, second)
            except ArithmeticError:  # division by zero has no value: every comparison with it is false
                return math.nan

        return computed, False

    def _comparison(self, node: ast.Compare, depth: int) -> tuple[Evaluate, bool]:
        operators = [_COMPARE.get(type(each)) for each in node.ops]
        if None in operators:
            raise ExpressionError(f"{ast.unparse(node)[:60]!r}: valid comparisons are < <= > >= == !=")
        chosen = [each for each in operators if each is not None]
        parts = [self._of(each, False, "a comparison", depth) for each in (node.left, *node.comparators)]

        def compared(sight: Sight) -> bool:
            values = [part(sight) for part in parts]
            return not any(map(math.isnan, values)) and all(
                compare(one, other) for compare, one, other in zip(chosen, values, values[1:], strict=False)
            )

        return compared, True

    def _call(self, node: ast.Call, depth: int) -> tuple[Evaluate, bool]:
        name = node.func.id if isinstance(node.func, ast.Name) else ""
        function = FUNCTIONS.get(name)
        if function is None:
            given = ast.unparse(node.func)[:60]
            raise ExpressionError(
                f"there is no function {given!r}{did_you_mean(given, FUNCTIONS)}; valid: {', '.join(FUNCTIONS)}"
            )
        if name == "abs":
            if len(node.args) != 1 or node.keywords:
                raise ExpressionError("abs takes one number")
            number = self._of(node.args[0], False, "abs", depth)
            return lambda sight: abs(number(sight)), False
        arguments = _arguments(name, function, node)
        count = function.texts if function.objects < 0 else function.objects
        self.objects += [str(each) for each in arguments[:count]]
        return lambda sight: sight.read(name, arguments), function.is_bool


def _arguments(name: str, function: Function, node: ast.Call) -> Arguments:
    given = [_literal(each) for each in node.args]
    texts, numbers = given[: function.texts], given[function.texts :]
    is_right = (
        not node.keywords
        and len(texts) == function.texts
        and len(numbers) <= function.numbers
        and all(isinstance(each, str) and each for each in texts)
        and all(isinstance(each, float) for each in numbers)
    )
    if not is_right:
        raise ExpressionError(
            f"{ast.unparse(node)[:60]!r}: write {function.form}, with names in quotes: {function.meaning}"
        )
    return tuple(each for each in given if each is not None)


def _literal(node: ast.expr) -> str | float | None:
    """Return a text or a number that is written down; None for everything else."""
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        number = _literal(node.operand)
        return -number if isinstance(number, float) else None
    if not isinstance(node, ast.Constant) or isinstance(node.value, bool):
        return None
    if isinstance(node.value, str):
        return node.value
    return _finite(node.value) if isinstance(node.value, (int, float)) else None


def _finite(value: float) -> float:
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise ExpressionError(f"{str(value)[:20]} is too large")
    return number
