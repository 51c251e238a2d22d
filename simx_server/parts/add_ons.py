"""Built-in add-ons of the server: clients call their functions like those of an add-on's script.

simxCallScriptFunction(clientID, NAME, 2, "function", ints, floats, strings, buffer, simx_opmode_blocking)
"""

from __future__ import annotations

from collections.abc import Mapping
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
    """The functions of one add-on by name, each with the number of integers and floats that it takes."""

    def __init__(self, add_on: str, known: Mapping[str, tuple[int, int, _Function]]) -> None:
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
        wanted_ints, wanted_floats, function = self._known[name]
        if (len(ints), len(floats)) != (wanted_ints, wanted_floats):
            raise CommandError(
                f"{name} of the add-on {self._add_on} takes {wanted_ints} integers and {wanted_floats} floats, "
                f"not {len(ints)} and {len(floats)}"
            )
        return function
