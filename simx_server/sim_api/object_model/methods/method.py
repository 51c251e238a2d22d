"""One method: its name, its classes, its effect, and the function that runs it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, TypeVar

from simx_server.errors import CommandError
from simx_server.scripting.conversion.signature import MOST_ITEMS, Signature, to_float, to_list, to_short_text
from simx_server.sim_api.base import at_no_cost
from simx_server.sim_api.effects import Effect
from simx_server.sim_api.object_model.classes import classes_of, to_api_1
from simx_server.sim_api.object_model.values import Matrix, WrongValue, plain, to_matrix

if TYPE_CHECKING:
    from simx_server.scripting.script import Script
    from simx_server.world.world import World

    from .api_1 import Api1

Options = dict[str, Any] | None
"""The map that many methods take as their last argument."""


@dataclass(frozen=True, slots=True)
class Call:
    """The call of a method."""

    sim: Api1
    """The functions of API 1, as the caller has them."""

    world: World
    script: Script
    """The caller; of a client the script that stands for it."""

    handle: int
    """The object."""

    def uncounted(self) -> AbstractContextManager[None]:
        """Work within a separate time limit: the time does not count against the script's limit."""
        return at_no_cost(self.script)

    @property
    def old(self) -> int:
        """Return the handle of the object in API 1."""
        return to_api_1(self.handle)


@dataclass(frozen=True, slots=True)
class Method:
    """A method of a class."""

    name: str
    effect: Effect
    function: Callable[..., Any]
    """Takes the call, then the arguments with the types that it declares; returns a result, a tuple of several, or a
    generator that returns them and yields once per simulation step. None: the method has no result.
    """

    signature: Signature
    takes_values: bool
    """Whether it takes arguments as API 2 has them, and not as API 1's numbers."""

    def run(self, call: Call, arguments: list[Any]) -> Any:
        """Run it. Raises CommandError."""
        given = arguments if self.takes_values else [plain(each) for each in arguments]
        try:
            return self.function(call, *self.signature.bind(given))
        except WrongValue as problem:
            raise CommandError(f"a value of {self.name} must be {problem}") from None


METHODS: dict[str, dict[str, Method]] = {}
"""By class and name, as the modules of this folder declare them."""

_F = TypeVar("_F", bound=Callable[..., Any])


def method(classes: str, name: str, effect: Effect, *, takes_values: bool = False) -> Callable[[_F], _F]:
    """Declare a function as a method.

    Args:
        classes: names of classes, separated by spaces.
        name: of the method; dots are part of it.
        effect: what it does to the simulator.
        takes_values: whether it takes objects, poses, matrices and colours, and not numbers.
    """

    def declare(function: _F) -> _F:
        made = Method(name, effect, function, Signature.of(function), takes_values)
        for each in classes.split():
            METHODS.setdefault(each, {})[name] = made
        return function

    return declare


@cache
def methods_of(kind: str) -> Mapping[str, Method]:
    """Return the methods of a class with those of the classes above it. All modules have declared theirs before."""
    found: dict[str, Method] = {}
    for each in reversed(classes_of(kind)):
        found |= METHODS.get(each, {})
    return MappingProxyType(found)


@cache
def groups_of_methods(kind: str) -> frozenset[str]:
    """Return the starts of the names of a class's methods, such as `simulation`."""
    return frozenset(name.rpartition(".")[0] for name in methods_of(kind)) - {""}


def option(options: Options, name: str, default: Any = None) -> Any:
    """Return an option; the default where it is missing or nil."""
    value = (options or {}).get(name)
    return default if value is None else plain(value)


def number(options: Options, name: str, default: float) -> float:
    """Return an option that is a finite number. Raises CommandError."""
    return finite(option(options, name, default), name)


def whole(options: Options, name: str, default: int) -> int:
    """Return an option that is a whole number of 32 bits. Raises CommandError."""
    value = number(options, name, default)
    if abs(value) >= 1 << 31:
        raise CommandError(f"'{name}' is a whole number of 32 bits")
    return int(value)


def finite(value: Any, name: str) -> float:
    """Return a value that must be a finite number. Raises CommandError."""
    try:
        return to_float(value)
    except TypeError as problem:
        raise CommandError(f"'{name}' must be {problem}") from None


def numbers(value: Any, name: str) -> list[float]:
    """Return a value that must be a list of finite numbers. Raises CommandError."""
    try:
        return _TO_NUMBERS(value)
    except TypeError as problem:
        raise CommandError(f"'{name}' must be {problem}") from None


def pair(options: Options, name: str) -> list[int] | None:
    """Return an option that is two whole numbers; None without it. Raises CommandError."""
    value = option(options, name)
    if value is None:
        return None
    found = [round(each) for each in numbers(value, name)]
    if len(found) != 2 or max(map(abs, found)) >= 1 << 31:
        raise CommandError(f"'{name}' is two whole numbers")
    return found


def words(options: Options, name: str) -> list[str]:
    """Return an option that is a list of texts; none without it. Raises CommandError."""
    try:
        return _TO_WORDS(option(options, name, []))
    except TypeError as problem:
        raise CommandError(f"'{name}' must be {problem}") from None


def unpacked(data: bytes) -> list[float]:
    """Return the numbers of packed doubles. Raises CommandError: too many, or they are not finite."""
    if len(data) % 8 or len(data) // 8 > MOST_ITEMS:
        raise CommandError(f"{len(data)} bytes are not doubles, at most {MOST_ITEMS}")
    return numbers(list(memoryview(data).cast("d")), "the packed numbers")


_TO_NUMBERS, _TO_WORDS = to_list(to_float), to_list(to_short_text)


def text_option(options: Options, name: str, default: str = "") -> str:
    """Return an option that is text."""
    value = option(options, name, default)
    return value.decode("utf-8", "surrogateescape") if isinstance(value, bytes) else str(value)


def points_of(value: Any, rows: int = 3) -> list[float]:
    """Return the columns of a matrix one after the other; a flat list is taken as it is. Raises CommandError."""
    try:
        if isinstance(value, Matrix):
            return value.points(rows)
        matrix = to_matrix(value)
        return matrix.numbers if matrix.columns == 1 else matrix.points(rows)
    except TypeError as problem:
        raise CommandError(f"the points must be {problem}") from None


def silently(options: Options, act: Callable[[], Any]) -> Any:
    """Return the result of an action; nil where it fails and the options say `noError`."""
    try:
        return act()
    except CommandError:
        if option(options, "noError", False):
            return (None,)
        raise


def handles(values: Iterable[Any]) -> list[int]:
    """Return the handles of a list of objects."""
    found = [plain(each) for each in values]
    if any(type(each) is not int for each in found):
        raise WrongValue("a table of objects")
    return found
