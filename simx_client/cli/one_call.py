"""Make one call of a function of the table to one simulator; return its results, or raise with the reason."""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from typing import Any, cast

import simx_client
from simx_client.calls.answers import Answer
from simx_client.calls.marshalling import Marshal
from simx_client.connection.clients import CLIENTS
from simx_client.connection.connection import Connection
from simx_client.connection.exchange import Exchange
from simx_client.errors import SimxError
from simx_client.protocol import constants as c
from simx_client.protocol.commands import BY_NAME, Command, Place

from .values.arguments import bare, shielded, wanted


class Refused(SimxError):
    """The simulator refused the call; the text is the simulator's."""

    def __init__(self, text: str, code: int) -> None:
        super().__init__(text)
        self.code = code
        """A simx_return_ code."""


def parse_words(parser: argparse.ArgumentParser, argv: Sequence[str]) -> argparse.Namespace:
    """Parse a command line with flags in any position, in which words such as ``-0.5`` are not flags."""
    options = parser.parse_intermixed_args(shielded(argv))
    options.arguments = bare(options.arguments)
    return options


def ask(client: int, command: Command, arguments: Sequence[Any]) -> list[Any]:
    """Call a function and wait; return its results without the return code.

    Raises:
        Refused: the call failed.
    """
    connection = CLIENTS.get(client)
    assert connection is not None
    if command.place is Place.LOCAL or command.loads_file:
        return _call(client, command, arguments)
    answer: Answer[Any] = Answer(
        Marshal(command), Marshal(command).coerce(tuple(arguments)), 0, connection.where
    )
    exchange = Exchange(connection, [answer])
    exchange.send()
    exchange.finish(time.monotonic() + connection.timeout, connection.timeout)
    if answer.code:
        raise Refused(f"{command.name}: {answer.failure.reason}", answer.code)
    assert answer.reply is not None
    result = answer.marshal.success(answer.reply.values)
    return [] if result == 0 else list(result[1:])


def _call(client: int, command: Command, arguments: Sequence[Any]) -> list[Any]:
    """Call a function that sends a file, or works in the client."""
    named = dict(zip((each.name for each in wanted(command)), arguments, strict=True))
    filled = {"clientID": client}
    if "operationMode" in command.parameters:
        filled["operationMode"] = c.simx_opmode_blocking
    result: Any = getattr(simx_client, command.name)(**named, **filled)
    code, *values = cast("tuple[Any, ...]", result) if isinstance(result, tuple) else (result,)
    if code:
        raise Refused(_reason(client, command, code), code)
    return values


def _reason(client: int, command: Command, code: int) -> str:
    """Return why a call failed: the simulator's words, if it refused the call."""
    if code & c.simx_return_remote_error_flag:
        (errors,) = ask(client, BY_NAME["simxGetLastErrors"], [])
        if errors:
            return str(errors[-1])
    return f"{command.name}: {meaning(code)}"


def meaning(code: int) -> str:
    """Describe a simx_return_ code in words."""
    if code & c.simx_return_remote_error_flag:
        return f"the simulator refused it (code {code})"
    if code & c.simx_return_timeout_flag:
        return f"no answer came in time (code {code}); see --timeout"
    if code & c.simx_return_novalue_flag:
        return f"there is no value (code {code})"
    return f"it was not done (code {code})"


def handle_of(client: int, finder: str, name: str) -> int:
    """Look up a name. Raises Refused, whose text contains the nearest names."""
    return int(ask(client, BY_NAME[finder], [name])[0])


def alive(connection: Connection) -> bool:
    """Return whether the simulator is still connected."""
    return connection.connection_id != -1
