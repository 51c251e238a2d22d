"""Read waiting messages: their demands on a script or a search that runs, and the calls that a client waits for.

A message waits for the end of what runs, or makes it end, or can be executed meanwhile.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from simx_client.protocol.codec import CodecError, decode_batch, encode
from simx_client.protocol.commands import ANSWERED, Command
from simx_client.protocol.messages import NOT_AWAITED_MS, Batch, Call, Operation

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


def divide(payload: bytes) -> tuple[bytes | None, bytes | None]:
    """Return the calls of a batch that its client waits for, and the others, each encoded; None if there are none.

    An unreadable batch counts as one without awaited calls.
    """
    try:
        batch = decode_batch(payload)
    except CodecError:
        return None, payload
    awaited = [call for call in batch.calls if _is_awaited(call)]
    if not awaited:
        return None, payload
    others = [call for call in batch.calls if not _is_awaited(call)]
    return _with(batch, awaited), _with(batch, others) if others else None


def _is_awaited(call: Call) -> bool:
    return call.operation == Operation.EXECUTE and call.delay_ms < NOT_AWAITED_MS


def _with(batch: Batch, calls: list[Call]) -> bytes:
    return encode(Batch(batch.message_id, batch.client_time, calls))
