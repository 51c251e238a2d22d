"""Read the demands of waiting messages on a script or a search that runs: to wait for its end, or to make it end."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from simx_client.protocol.codec import CodecError, decode_batch
from simx_client.protocol.commands import ANSWERED, Command
from simx_client.protocol.messages import Call

STOP = "simxStopSimulation"

STOP_MARK = b"topSimulation"
"""Part of every message that stops the simulation, in every protocol; other messages may have it too."""


class Demands(NamedTuple):
    """The demands of one message."""

    waits: bool
    """It must not be executed while a script runs."""

    stops: bool
    """It stops the simulation, so a search that runs is not needed any more."""


def demands_of_batch(payload: bytes) -> Demands:
    """Return the demands of a batch of calls of the table; an unreadable one, which is refused, has none."""
    try:
        commands = known_commands(decode_batch(payload).calls)
    except CodecError:
        return Demands(waits=False, stops=False)
    return Demands(
        any(command.waits_for_scripts for command in commands),
        any(command.name == STOP for command in commands),
    )


def interfere(calls: Iterable[Call]) -> bool:
    """Return whether any of these calls must not be executed while a script runs."""
    return any(command.waits_for_scripts for command in known_commands(calls))


def known_commands(calls: Iterable[Call]) -> list[Command]:
    """Return the commands of these calls, without those that the table does not have."""
    return [command for call in calls if (command := ANSWERED.get(call.command)) is not None]
