"""Functions of a stand-in that always give the same answer."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from typing import Any, ClassVar

from simx_server.sim_api.base import ApiPart


class StandIn(ApiPart):
    """A plug-in that is not there. Each function prints `NOTE` to the status bar, unless that was done before."""

    NOTE: ClassVar[str] = ""

    def _note(self) -> None:
        self._say_once(self.NOTE)


def answer(*results: Any, reason: str = "nothing is connected") -> Callable[..., Any]:
    """Return a method that takes any values and gives these results.

    Args:
        results: none for nil.
        reason: says in the list of functions why it is a stand-in.
    """

    def function(self: StandIn, *_values: Any) -> Any:
        self._note()  # pyright: ignore[reportPrivateUsage]
        copies = deepcopy(results)
        return None if not copies else copies[0] if len(copies) == 1 else copies

    shown = ", ".join(map(_shown, results))
    function.__doc__ = f"Return {shown or 'nil'}. Stand-in: {reason}."
    return function


def _shown(value: Any) -> str:
    if isinstance(value, str):
        return f"'{value}'"
    if isinstance(value, list | dict):
        return "an empty table" if not value else "a table of zeros"
    return str(value).lower()
