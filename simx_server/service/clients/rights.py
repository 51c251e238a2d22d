"""The rights of clients: one answer for the commands of the table and for the functions of ``sim``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from simx_client.protocol.commands import Command

    from .sessions import ClientSession


class SimFunction(Protocol):
    """A function of a namespace, with what it declares to do."""

    @property
    def only_reads(self) -> bool: ...


def may(client: ClientSession, function: Command | SimFunction) -> bool:
    """Return whether the role of a client allows it to call a function: a viewer may call those that only read."""
    return function.only_reads or not client.may_only_read
