"""Read the demands of a message of the ZeroMQ remote API on a script that runs; see `runtime.demands`."""

from __future__ import annotations

from simx_client.protocol.commands import ANSWERED
from simx_server.service.calls.demands import Demands

from .functions import described
from .peer import NUMBER_BYTES
from .reading import only_reads
from .wire import WireError, read_request

_STOP = "sim.stopSimulation"

_MOST_READ = 1 << 16
"""Bytes of a message above which it waits unread: reading it twice would take the time of the script."""

_LONG = frozenset(("visitTree", "wait", "waitForSignal", "checkVisionSensor"))
"""Functions that only read, but run code or wait."""


def demands_of_message(numbered: bytes) -> Demands:
    """Return the demands of a message with the number of its connection in front."""
    if len(numbered) > _MOST_READ:
        return Demands(waits=True, stops=False)
    try:
        function = described(read_request(numbered[NUMBER_BYTES:]).function)
    except WireError:
        return Demands(waits=True, stops=False)
    is_brief = function.space == "sim" and function.is_known and _is_brief(function.name)
    return Demands(waits=not is_brief, stops=function.full_name == _STOP)


def _is_brief(name: str) -> bool:
    """Return whether a function of `sim` only reads, or sets what the remote API's table allows to be set then."""
    if name in _LONG:
        return False
    command = ANSWERED.get(f"simx{name[:1].upper()}{name[1:]}")
    return only_reads(f"sim.{name}") or (command is not None and not command.waits_for_scripts)
