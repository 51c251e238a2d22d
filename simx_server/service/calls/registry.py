"""Register a function as the handler of a command of the table.

A handler takes the world and the command's arguments in the table's order, returns None, one value, a tuple of the
results, or a future of these, and raises CommandError for a remote error. A handler that takes long is a generator that
ends in this way, see `background.py`. Each handler is checked against the table on import: an unknown name or a wrong
number of parameters stops the server from starting.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import partial
from types import ModuleType
from typing import TYPE_CHECKING, Any, TypeVar

from simx_client.protocol.commands import ANSWERED, Command
from simx_client.protocol.python.light_dataclass import dataclass

if TYPE_CHECKING:
    from simx_server.world.world import World

_F = TypeVar("_F", bound=Callable[..., Any])
_MARK = "__simx_handler__"


@dataclass(frozen=True, slots=True)
class Handler:
    """One command and the function that executes it."""

    command: Command
    function: Callable[..., Any]
    with_client: bool
    """Whether the function takes the client's session after the world."""

    def __call__(self, world: World, client: Any, arguments: list[Any]) -> Any:
        """Execute the command with checked arguments; runs on the physics thread."""
        if self.with_client:
            return self.function(world, client, *arguments)
        return self.function(world, *arguments)

    def bound(self, world: World, client: Any) -> Callable[..., Any]:
        """Return a function of the checked arguments alone, for many calls."""
        return partial(self.function, world, client) if self.with_client else partial(self.function, world)


def handler(name: str, *, with_client: bool = False) -> Callable[[_F], _F]:
    """Mark a function as the handler of the command with this name in the table; it stays a plain function."""
    command = ANSWERED.get(name)
    if command is None or command.name != name:
        raise LookupError(f"{name} is not the name of a remote command in the table")

    def mark(function: _F) -> _F:
        expected = 1 + with_client + len(command.arguments)
        if len(inspect.signature(function).parameters) != expected:
            raise TypeError(f"the handler of {name} must take {expected} parameters: {function.__qualname__}")
        setattr(function, _MARK, Handler(command, function, with_client))
        return function

    return mark


def handlers_of(*modules: ModuleType) -> dict[str, Handler]:
    """Return the handlers of all marked functions in these modules, by command name."""
    found: dict[str, Handler] = {}
    for module in modules:
        for value in vars(module).values():
            entry = getattr(value, _MARK, None)
            if not isinstance(entry, Handler) or value.__module__ != module.__name__:
                continue
            if entry.command.name in found:
                raise LookupError(f"{entry.command.name} has two handlers")
            found[entry.command.name] = entry
    return found
