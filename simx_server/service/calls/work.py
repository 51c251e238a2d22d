"""The messages of clients as the server loop takes them: calls as values, or a batch that is decoded in its turn.

A gateway hands work in from any thread. While a script or a search runs, work waits for its end, or makes it end, or is
executed meanwhile; what it demands is read from its calls.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import field
from itertools import islice
from typing import TYPE_CHECKING, Protocol

import msgpack

from simx_client.protocol.codec import CodecError, decode_batch, decode_callers
from simx_client.protocol.commands import ANSWERED, Command
from simx_client.protocol.messages import NOT_AWAITED_MS, Batch, Call, Operation
from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.service.answers.answers import size_of

if TYPE_CHECKING:
    from simx_server.service.clients.sessions import ClientSession


STOP = "simxStopSimulation"

STOP_MARK = b"topSimulation"
"""Part of every message that stops the simulation, in every protocol; other messages may have it too."""

SHORT = 1 << 10
"""Bytes of a message whose calls are kept after the first reading, for those who handle it next."""

_CALL = 32
"""About how many bytes a call takes without its arguments."""


class Work(Protocol):
    """One message of a client. It is never changed."""

    @property
    def size(self) -> int:
        """Return its bytes, about."""
        ...

    def waits_for_scripts(self) -> bool:
        """Return whether it must not be executed while a script runs."""
        ...

    def stops(self) -> bool:
        """Return whether it stops the simulation, so that a search that runs is not needed any more."""
        ...

    def divide(self) -> tuple[CallsWork | None, Work | None]:
        """Return the calls that its client waits for, and the others; None if there are none."""
        ...

    def run(self, session: ClientSession, table: TableRunner) -> None:
        """Execute it for its client. Physics thread."""
        ...


class TableRunner(Protocol):
    """Executes calls of the table, see `Batches`."""

    def run(self, session: ClientSession, work: TableWork) -> None:
        """Execute calls of a client. Physics thread."""
        ...


class TableWork:
    """Calls of the table."""

    __slots__ = ()

    size: int

    def read(self) -> Batch:
        """Return the calls. Raises CodecError."""
        raise NotImplementedError

    def callers(self, most: int) -> tuple[int, int, list[int]]:
        """Return message id, client time and the ids of the first `most` calls. Raises CodecError."""
        raise NotImplementedError

    def recorded(self) -> bytes:
        """Return it as a batch of this project's own protocol."""
        raise NotImplementedError

    def waits_for_scripts(self) -> bool:
        return any(command.waits_for_scripts for command in self._commands())

    def stops(self) -> bool:
        return any(command.name == STOP for command in self._commands())

    def _commands(self) -> list[Command]:
        """Return the commands; none if it is unreadable, as it is refused then."""
        try:
            return known_commands(self.read().calls)
        except CodecError:
            return []

    def divide(self) -> tuple[CallsWork | None, TableWork | None]:
        """Divide it. An unreadable message counts as work without awaited calls."""
        try:
            batch = self.read()
        except CodecError:
            return None, self
        awaited = [call for call in batch.calls if _is_awaited(call)]
        if not awaited:
            return None, self
        others = [call for call in batch.calls if not _is_awaited(call)]
        return CallsWork(batch._replace(calls=awaited)), (
            CallsWork(batch._replace(calls=others)) if others else None
        )

    def run(self, session: ClientSession, table: TableRunner) -> None:
        table.run(session, self)


@dataclass(slots=True, init=False)
class BatchWork(TableWork):
    """A batch of this project's own protocol."""

    payload: bytes
    size: int
    _batch: Batch | None = field(compare=False, repr=False)
    """The calls of a short one, as soon as they were read; those of a long one take many times its bytes."""

    def __init__(self, payload: bytes) -> None:
        self.payload, self.size, self._batch = payload, len(payload), None

    def read(self) -> Batch:
        if self._batch is not None:
            return self._batch
        batch = decode_batch(self.payload)
        if self.size <= SHORT:
            self._batch = batch
        return batch

    def callers(self, most: int) -> tuple[int, int, list[int]]:
        return decode_callers(self.payload, most)

    def recorded(self) -> bytes:
        return self.payload

    def stops(self) -> bool:
        return STOP_MARK in self.payload and TableWork.stops(self)


@dataclass(slots=True, init=False)
class CallsWork(TableWork):
    """Calls as values."""

    batch: Batch
    size: int

    def __init__(self, batch: Batch) -> None:
        self.batch = batch
        self.size = sum(_CALL + len(call.command) + sum(map(size_of, call.arguments)) for call in batch.calls)

    def read(self) -> Batch:
        return self.batch

    def callers(self, most: int) -> tuple[int, int, list[int]]:
        message_id, client_time, calls = self.batch
        return message_id, client_time, [call.call_id for call in islice(calls, most)]

    def recorded(self) -> bytes:
        return msgpack.packb(self.batch, unicode_errors="surrogateescape")  # numbers keep their 64 bits


def interfere(calls: Iterable[Call]) -> bool:
    """Return whether any of these calls must not be executed while a script runs."""
    return any(command.waits_for_scripts for command in known_commands(calls))


def known_commands(calls: Iterable[Call]) -> list[Command]:
    """Return the commands of these calls, without those that the table does not have."""
    return [command for call in calls if (command := ANSWERED.get(call.command)) is not None]


def _is_awaited(call: Call) -> bool:
    return call.operation == Operation.EXECUTE and call.delay_ms < NOT_AWAITED_MS
