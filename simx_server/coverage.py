"""What of the legacy remote API is there: the table joined with what is registered to answer it."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import asdict, dataclass

from simx_client.protocol.commands import TABLE, Command, Place

MODES = {
    Place.REMOTE: "any mode",
    Place.WAITING: "always blocking",
    Place.LOCAL: "in the client",
}
"""Where a command does its work, in a user's words."""


@dataclass(frozen=True, slots=True)
class Coverage:
    """One line of the listing."""

    name: str
    aliases: tuple[str, ...]
    supported: bool
    modes: str
    doc: str


def coverage(answered: Collection[str], table: Iterable[Command] = TABLE) -> list[Coverage]:
    """One entry per command of the table, in its order.

    `answered` holds the names that the server answers. What works in the client alone needs no answer: a test
    of the client holds that every such function exists.
    """
    return [
        Coverage(
            name=command.name,
            aliases=command.aliases,
            supported=command.place is Place.LOCAL or command.name in answered,
            modes=MODES[command.place],
            doc=command.doc,
        )
        for command in table
    ]


def as_text(lines: list[Coverage]) -> str:
    """A table for people: name, support, modes, doc, and a closing count."""
    width = max((len(line.name) for line in lines), default=0)
    rows = [
        f"{line.name:{width}}  {'yes' if line.supported else 'not yet':7}  {line.modes:15}  {line.doc}"
        + (f" (also {', '.join(line.aliases)})" if line.aliases else "")
        for line in lines
    ]
    supported = sum(line.supported for line in lines)
    return "\n".join([*rows, f"{supported} of {len(lines)} commands are supported"])


def as_records(lines: list[Coverage]) -> list[dict[str, object]]:
    """The same for programs, ready for json.dumps."""
    return [asdict(line) for line in lines]
