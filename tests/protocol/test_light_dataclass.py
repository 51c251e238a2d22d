"""The project's decorator `dataclass` makes the same classes as the standard library's, and a start uses it."""

from __future__ import annotations

import copy
import dataclasses
import inspect
import pickle
import weakref
from collections.abc import Callable
from pathlib import Path
from typing import Any, ClassVar

import pytest
from launching import python

from simx_client.protocol.python import light_dataclass

DECORATORS = (dataclasses.dataclass, light_dataclass.dataclass)
OPTIONS = (
    {},
    {"frozen": True},
    {"slots": True},
    {"frozen": True, "slots": True},
    {"eq": False},
    {"frozen": True, "eq": False},
    {"repr": False},
    {"kw_only": True},
    {"slots": True, "weakref_slot": True},
)


def made(decorator: Any, **options: Any) -> Any:
    """Return a class with a field of each kind."""

    @decorator(**options)
    class Thing:
        """A thing."""

        KIND: ClassVar[str] = "kind"
        first: int
        numbers: list[int] = dataclasses.field(default_factory=list)
        last: str = "end"
        hidden: int = dataclasses.field(default=3, repr=False, compare=False)
        unhashed: int = dataclasses.field(default=4, hash=False)
        kept: int = dataclasses.field(default=5, init=False)
        listed: list[int] = dataclasses.field(default_factory=lambda: [1], init=False)
        named: bool = dataclasses.field(default=True, kw_only=True)

    return Thing


def outcome(use: Callable[[Any], Any], kind: Any) -> tuple[str, object]:
    """Return the value or the error of a use of a class."""
    try:
        return "value", use(kind)
    except Exception as error:
        return type(error).__name__, str(error)


def parameters(kind: Any) -> list[tuple[str, str, str]]:
    """Return name, kind and default of each parameter."""
    return [
        (each.name, str(each.kind), repr(each.default))
        for each in inspect.signature(kind).parameters.values()
    ]


USES: tuple[Callable[[Any], Any], ...] = (
    parameters,
    lambda kind: dataclasses.astuple(kind(1, [2], "x", named=False)),
    lambda kind: dataclasses.asdict(kind(first=1)),
    lambda kind: kind(),
    lambda kind: kind(first=1, other=2),
    lambda kind: repr(kind(first=1)).split(" at ")[0],
    lambda kind: kind(first=1) == kind(first=1),
    lambda kind: kind(first=1) == kind(first=1, hidden=9),
    lambda kind: kind(first=1) == kind(first=2),
    lambda kind: kind(first=1) == 1,
    lambda kind: kind.__hash__ is None,
    lambda kind: len({*map(hash, [kind(first=1, numbers=()), kind(first=1, numbers=(), unhashed=9)])}),
    lambda kind: hash(kind(first=1, numbers=())) == hash((1, (), "end", 5, True)),
    lambda kind: isinstance(hash(kind(first=1)), int),
    lambda kind: len({kind(first=1, numbers=(), last=last) for last in "aab"}),
    lambda kind: setattr(kind(first=1), "first", 2),
    # With slots the error of the standard library is another one, which is a known fault of its closures.
    lambda kind: outcome(lambda kind: setattr(kind(first=1), "other", 2), kind)[0] == "value",
    lambda kind: delattr(kind(first=1), "first"),
    lambda kind: dataclasses.asdict(dataclasses.replace(kind(first=1), first=7)),
    lambda kind: dataclasses.asdict(copy.copy(kind(first=1))),
    lambda kind: dataclasses.asdict(copy.deepcopy(kind(first=1))),
    lambda kind: kind(first=1).numbers is kind(first=1).numbers,
    lambda kind: (kind.KIND, kind.__match_args__, kind.__doc__, kind(first=1).kept),
    lambda kind: (kind.__init__.__qualname__, kind.__init__.__module__),
    lambda kind: hasattr(kind(first=1), "__dict__"),
    lambda kind: weakref.ref(kind(first=1)) is None,
)


@pytest.mark.parametrize("options", OPTIONS, ids=str)
def test_it_makes_the_class_of_the_standard_library(options: dict[str, Any]) -> None:
    theirs, own = ([outcome(use, made(each, **options)) for use in USES] for each in DECORATORS)
    assert own == theirs


def own_methods(decorator: Any) -> Any:
    """Return a class with its own methods in place of those that the decorator would add."""

    @decorator(frozen=True)
    class Thing:
        first: float

        def __post_init__(self) -> None:
            object.__setattr__(self, "first", self.first + 1)

        def __repr__(self) -> str:
            return "own"

        def __eq__(self, other: object) -> bool:
            return True

        def __hash__(self) -> int:
            return 5

    return Thing


def derived(decorator: Any) -> Any:
    """Return a class that inherits fields."""

    @decorator(frozen=True)
    class First:
        first: float

    @decorator(frozen=True)
    class Second(First):
        second: int = 2

    return Second


@pytest.mark.parametrize("make", [own_methods, derived])
def test_methods_of_the_class_and_of_its_parents_stay(make: Callable[[Any], Any]) -> None:
    (theirs, _), (own, own_kind) = ((make(each)(0.5), make(each)) for each in DECORATORS)
    assert (own.first, hash(own), repr(own)) == (theirs.first, hash(theirs), repr(theirs))
    assert (own == own_kind(2)) == (theirs == type(theirs)(2))


@light_dataclass.dataclass(frozen=True, slots=True)
class Packed:
    """A class that pickle finds by its name."""

    first: int
    second: str = "x"


def test_a_frozen_object_with_slots_can_be_pickled() -> None:
    assert pickle.loads(pickle.dumps(Packed(1))) == Packed(1)


def test_a_start_builds_no_class_with_the_decorator_of_the_standard_library(tmp_path: Path) -> None:
    """It takes five times as long; see `light_dataclass`."""
    code = """
import dataclasses, sys
slow = dataclasses.dataclass
def noted(cls=None, /, **options):
    caller = sys._getframe(1).f_globals["__name__"]
    if caller.startswith("simx_") and not caller.endswith(".light_dataclass"):
        print(caller)
    return slow(cls, **options)
dataclasses.dataclass = noted
import simx_client
simx_client.simxFinish(-1)
import simx_server.app.cli, simx_server.app.server
"""
    assert python(tmp_path, "-c", code).stdout.split() == []
