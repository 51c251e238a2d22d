"""Translate a command of the original's protocol to a call of the table, and the answer to its reply.

A file of the client's side travels as the original sends it: a transfer to a name that starts with `TEMPORARY`, then
the command that loads this name, then one that erases it. Here the transfer lends the file to the loading call, and it
never lies in the workspace.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from typing import Any, NamedTuple

from simx_client.protocol.commands import ANSWERED, CARRIED, TABLE, Command, Effect
from simx_client.protocol.table.original_wire import Wire, wires

from . import forms
from .messages import Request

TEMPORARY = "REMOTE_API_TEMPFILE_"
"""The start of the names of files that a client transfers to have them loaded."""

LEND = "lendFile"
"""The command that keeps a file for the call that loads it."""

FILE_IS_ON_CLIENT = 1
"""Bit 0 of the options of commands that load a file."""

_LENT, _ERASE = "storeFile", "simxEraseFile"


class Translated(NamedTuple):
    """A command as a call of the table."""

    name: str
    arguments: list[Any]
    wire: Wire


def _by_id() -> dict[tuple[int, int | None], Wire]:
    return {(wire.id, wire.number): wire for wire in wires((*TABLE, *CARRIED))}


WIRES: Mapping[tuple[int, int | None], Wire] = _by_id()
"""By id, and the identification number where several commands share an id."""


UNKNOWN = Wire(id=-1, command="", ident=(), request=(), reply=())
"""Stands for a number that the protocol does not have."""

_UNKNOWN_COMMAND = Command(name="", doc="There is no such command.", effect=Effect.READS)


def command_of(wire: Wire) -> Command:
    """Return the entry of the table."""
    return _UNKNOWN_COMMAND if wire is UNKNOWN else ANSWERED[wire.command]


def translate(request: Request) -> Translated:
    """Return a complete command as a call.

    The server loop refuses a number that the protocol does not have, and a command without its arguments if the payload
    is unreadable; so both are errors of the client like any other.
    """
    wire = WIRES.get((request.id, None)) or WIRES.get((request.id, _number(request.ident)))
    if wire is None:
        return Translated(f"{request.id:#06x}", [], UNKNOWN)
    values: dict[str, Any] = dict(wire.fixed)
    try:
        _read_ident(wire, request, values)
        reader = forms.Reader(request.payload)
        for names, form in wire.request:
            values.update(zip(names, forms.read(reader, form), strict=True))
    except (forms.Unreadable, struct.error):
        return Translated(wire.command, [], wire)
    return _with_files(wire, [values[name] for name in command_of(wire).takes])


def _number(ident: bytes) -> int | None:
    return int.from_bytes(ident, "little", signed=True) if len(ident) == 4 else None


def _read_ident(wire: Wire, request: Request, values: dict[str, Any]) -> None:
    takes, reader = command_of(wire).takes, forms.Reader(request.ident)
    for name in wire.ident:
        form = "i" if not name or takes[name].kind.name == "int" else "z"
        (value,) = forms.read(reader, form)
        if name:
            values[name] = value


def _with_files(wire: Wire, arguments: list[Any]) -> Translated:
    """Return the call, which for a temporary file is another one."""
    command = command_of(wire)
    if not arguments or not isinstance(path := arguments[0], str) or not path.startswith(TEMPORARY):
        return Translated(wire.command, arguments, wire)
    if command.loads_file:
        return Translated(wire.command, [path, arguments[1] | FILE_IS_ON_CLIENT], wire)
    if wire.command == _LENT:
        return Translated(LEND, [path, path, arguments[1]], wire)
    if wire.command == _ERASE:
        return Translated(LEND, [path, path, b""], wire)
    return Translated(wire.command, arguments, wire)


def payload(wire: Wire, values: list[Any]) -> bytes:
    """Return the payload of a successful reply.

    Raises:
        ValueError: a result does not fit the protocol.
    """
    try:
        return forms.write(wire.reply, values)
    except (struct.error, TypeError, OverflowError) as error:
        raise ValueError(f"the result of {wire.command} does not fit the protocol: {error}") from None
