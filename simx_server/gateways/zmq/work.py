"""A message of the ZeroMQ remote API as work of the server loop."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from simx_client.protocol.commands import ANSWERED
from simx_server.service.calls.work import STOP_MARK, CallsWork

from .functions import Function, described
from .wire.messages import WireError, read_request

if TYPE_CHECKING:
    from simx_server.service.calls.work import TableRunner
    from simx_server.service.clients.sessions import ClientSession

_STOP = "sim.stopSimulation"

MOST_READ = 1 << 16
"""Bytes of a message above which it waits unread: reading it twice would take the time of the script."""

_LONG = frozenset(("visitTree", "wait", "waitForSignal", "checkVisionSensor"))
"""Functions that only read, but run code or wait."""


@dataclass(slots=True, init=False)
class MessageWork:
    """One message of a connection."""

    number: int
    """The connection's."""

    payload: bytes
    size: int
    serve: Callable[[str, int, bytes], object]
    """Executes the message: the client, the connection, the payload."""

    def __init__(self, number: int, payload: bytes, serve: Callable[[str, int, bytes], object]) -> None:
        self.number, self.payload, self.size, self.serve = number, payload, len(payload), serve

    def waits_for_scripts(self) -> bool:
        function = self._function()
        return function is None or not (function.space == "sim" and function.is_known and _is_brief(function))

    def stops(self) -> bool:
        if STOP_MARK not in self.payload:
            return False
        function = self._function()
        return function is not None and function.full_name == _STOP

    def divide(self) -> tuple[CallsWork | None, MessageWork]:
        """Return it whole: its client waits without a time-out."""
        return None, self

    def run(self, session: ClientSession, table: TableRunner) -> None:
        self.serve(session.client, self.number, self.payload)

    def _function(self) -> Function | None:
        """Return what is called; None if it is unreadable or too long to be read twice."""
        if len(self.payload) > MOST_READ:
            return None
        try:
            return described(read_request(self.payload).function)
        except WireError:
            return None


def _is_brief(function: Function) -> bool:
    """Return whether a function of `sim` only reads, or sets what the remote API's table allows to be set then."""
    name = function.name
    if name in _LONG:
        return False
    command = ANSWERED.get(f"simx{name[:1].upper()}{name[1:]}")
    return function.only_reads or (command is not None and not command.waits_for_scripts)
