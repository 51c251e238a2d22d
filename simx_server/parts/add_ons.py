"""Built-in add-ons of the server: clients call their functions like those of an add-on's script.

simxCallScriptFunction(clientID, NAME, 2, "function", ints, floats, strings, buffer, simx_opmode_blocking)
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Generic, Protocol, TypeVar

from simx_server.errors import CommandError

ADD_ON_TYPE = 2
"""Script type of add-ons in simxCallScriptFunction; the constants of the remote API lack it."""

Results = tuple[list[int], list[float], list[str], bytes]

_Function = TypeVar("_Function")


class AddOn(Protocol):
    """The receiver of such a call."""

    def call(
        self, function: str, ints: list[int], floats: list[float], strings: list[str], buffer: bytes
    ) -> Results: ...


class Functions(Generic[_Function]):
    """The functions of one add-on by name, each with the number of integers and floats that it takes; None: any."""

    def __init__(self, add_on: str, known: Mapping[str, tuple[int | None, int | None, _Function]]) -> None:
        self._add_on = add_on
        self._known = known

    def find(self, name: str, ints: list[int], floats: list[float]) -> _Function:
        """Return the function for this name and these integers.

        Raises:
            CommandError: the name is unknown, or the function takes other arguments.
        """
        if name not in self._known:
            raise CommandError(
                f"the add-on {self._add_on} has no function '{name}'; it has: {', '.join(self._known)}"
            )
        *wanted, function = self._known[name]
        given = len(ints), len(floats)
        if any(count not in (None, present) for count, present in zip(wanted, given, strict=True)):
            whole, real = ("any number of" if count is None else count for count in wanted)
            raise CommandError(
                f"{name} of the add-on {self._add_on} takes {whole} integers and {real} floats, "
                f"not {given[0]} and {given[1]}"
            )
        return function


class Deferred:
    """An add-on that is made when a client calls it first: most servers never load its modules."""

    def __init__(self, make: Callable[[], AddOn]) -> None:
        self._make = make
        self._made: AddOn | None = None

    def call(
        self, function: str, ints: list[int], floats: list[float], strings: list[str], buffer: bytes
    ) -> Results:
        """Call a function. Raises CommandError, as the add-on does."""
        if self._made is None:
            self._made = self._make()
        return self._made.call(function, ints, floats, strings, buffer)
