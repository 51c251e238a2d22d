"""List which functions of the legacy remote API the server supports: the table of commands joined with the handlers."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import asdict, dataclass

from simx_client.protocol.commands import TABLE, Command, Place
from simx_client.protocol.differences import as_list, numbers_of

MODES = {
    Place.REMOTE: "any mode",
    Place.WAITING: "always blocking",
    Place.LOCAL: "in the client",
}
"""The place where a command does its work, in a user's words."""

PAGE = """\
# What of the legacy remote API is here

Made by `simx-server --commands --markdown > docs/coverage.md`; a test holds it fresh.
{count}, {names} names with the aliases.

[api.md](api.md) says what each function does, and which operation modes it takes. These differ from the original, by
the list below:

{rows}

These do not differ: {equal}.

## Differences from the original

Each has its test behind it.

{differences}
"""


@dataclass(frozen=True, slots=True)
class Coverage:
    """One line of the listing."""

    name: str
    aliases: tuple[str, ...]
    supported: bool
    modes: str
    doc: str
    differences: tuple[int, ...]
    """Numbers of `differences.DIFFERENCES`."""


def coverage(answered: Collection[str], table: Iterable[Command] = TABLE) -> list[Coverage]:
    """Return one entry per command of the table, in its order.

    `answered` holds the names that the server answers. Commands that work in the client alone need no answer: a test of
    the client checks that every such function exists.
    """
    return [
        Coverage(
            name=command.name,
            aliases=command.aliases,
            supported=command.place is Place.LOCAL or command.name in answered,
            modes="any but blocking" if command.takes_what_it_reads else MODES[command.place],
            doc=command.doc,
            differences=tuple(numbers_of(command.names)),
        )
        for command in table
    ]


def as_text(lines: list[Coverage]) -> str:
    """Return a table for people: name, support, modes, doc, and a closing count."""
    width = max((len(line.name) for line in lines), default=0)
    rows = [
        f"{line.name:{width}}  {_support(line):7}  {line.modes:16}  {line.doc}"
        + (f" (also {', '.join(line.aliases)})" if line.aliases else "")
        for line in lines
    ]
    return "\n".join([*rows, _count(lines)])


def as_records(lines: list[Coverage]) -> list[dict[str, object]]:
    """Return the same for programs, ready for json.dumps."""
    return [asdict(line) for line in lines]


def as_markdown(lines: list[Coverage]) -> str:
    """Return the page docs/coverage.md: all functions, and every numbered difference with the test that checks it."""
    rows = [
        f"* {_function(line)}: {', '.join(map(str, line.differences))}" for line in lines if line.differences
    ]
    return PAGE.format(
        count=_count(lines),
        names=sum(1 + len(line.aliases) for line in lines),
        rows="\n".join(rows),
        equal=", ".join(_function(line) for line in lines if not line.differences),
        differences=as_list(),
    )


def _function(line: Coverage) -> str:
    """Return the names of a function, and whether it is not there yet."""
    names = [f"[`{line.name}`](api.md#{line.name.lower()})", *(f"`{alias}`" for alias in line.aliases)]
    return ", ".join(names if line.supported else [*names, f"*{_support(line)}*"])


def _support(line: Coverage) -> str:
    return "yes" if line.supported else "not yet"


def _count(lines: list[Coverage]) -> str:
    return f"{sum(line.supported for line in lines)} of {len(lines)} commands are supported"
