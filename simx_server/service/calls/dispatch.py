"""Find the command and the handler of a call, and check the arguments."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

from simx_client.protocol.commands import ANSWERED, Command
from simx_client.protocol.kinds import apply
from simx_server.errors import CommandError
from simx_server.service.clients.rights import may
from simx_server.service.clients.sessions import ClientSession
from simx_server.world.world import World

from .registry import Handler

Handling = Callable[..., Any]
"""A handler with everything bound but the arguments of a call."""


class Dispatch:
    """Finds the handlers of commands."""

    def __init__(self, world: World, handlers: Mapping[str, Handler]) -> None:
        self.world = world
        self._handlers = handlers

    def find(self, client: ClientSession, name: str) -> tuple[Command, Handling] | tuple[None, None]:
        """Find the command with this name and the function that checks arguments and runs the handler.

        Returns:
            None for both if the table has no such command. If the client may not call it, the function raises.
        """
        command = ANSWERED.get(name)
        if command is None:
            return None, None
        try:
            run = self.handler(client, command).bound(self.world, client)
        except CommandError as error:
            return command, partial(_raise, error)
        if client.guard is None:
            return command, lambda *arguments: run(*check(command, arguments))

        def run_if_allowed(*arguments: Any) -> Any:
            checked = check(command, arguments)
            permit(client, command, checked)
            return run(*checked)

        return command, run_if_allowed

    def bind(self, client: ClientSession, command: Command, checked: list[Any]) -> Handling:
        """Return the function that executes a stream's command with arguments from `check`. Raises CommandError."""
        permit(client, command, checked)
        return partial(self.handler(client, command).bound(self.world, client), *checked)

    def handler(self, client: ClientSession, command: Command) -> Handler:
        """Return the handler of a command for this client. Raises CommandError."""
        if not may(client, command):
            raise CommandError(
                f"{command.name} changes something, and {client.name} is a viewer, who may only read"
            )
        handler = self._handlers.get(command.name)
        if handler is None:
            raise CommandError(
                f"{command.name} is not available in this version; 'simx-server --commands' lists what is"
            )
        return handler


def permit(client: ClientSession, command: Command, checked: Sequence[Any]) -> None:
    """Raise CommandError unless the client may make this call, with arguments from `check`."""
    if client.guard is not None:
        client.guard(command, checked)


def no_such_command(name: str) -> CommandError:
    """Return the refusal of a call with a name that is not in the table of commands."""
    return CommandError(f"there is no command {name[:64]!r}; 'simx-server --commands' lists all")


def check(command: Command, arguments: Sequence[Any]) -> list[Any]:
    """Return the arguments in the form that the handler takes. Raises CommandError."""
    checks = command.checks
    if len(arguments) == len(checks):
        try:
            return list(map(apply, checks, arguments))
        except ValueError:
            pass
    raise _refusal(command, arguments)


def _refusal(command: Command, arguments: Sequence[Any]) -> CommandError:
    """Return the error that says what is wrong with these arguments."""
    if len(arguments) != len(command.arguments):
        names = ", ".join(argument.name for argument in command.arguments) or "no arguments"
        return CommandError(f"{command.name} takes {names}; got {len(arguments)} arguments")
    for argument, value in zip(command.arguments, arguments, strict=True):
        try:
            argument.kind.check(value)
        except ValueError as error:
            return CommandError(f"{command.name}: {argument.name} {error}")
    raise AssertionError(f"these arguments of {command.name} are right")


def _raise(error: CommandError, *_arguments: Any) -> None:
    raise error
