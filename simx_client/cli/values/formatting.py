"""Values as text: in the form of an argument, or for JSON."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, cast

from simx_client.calls.images import PixelList
from simx_client.cli.command_parser import program
from simx_client.protocol.commands import Command


def as_lines(command: Command, values: Sequence[Any]) -> Iterator[str]:
    """Yield one result as it is; several with their names, one per line."""
    names = _names(command)
    if len(names) == 1:
        yield as_text(values[0])
        return
    for name, value in zip(names, values, strict=True):
        yield f"{name}={as_text(value)}"


def as_record(command: Command, values: Sequence[Any]) -> dict[str, Any]:
    """Return results by name, ready for json.dumps."""
    return {name: _plain(value) for name, value in zip(_names(command), values, strict=True)}


def as_text(value: Any) -> str:
    """Format a value: numbers with six digits, as in single precision; lists as ``1,2,3``, nested ones with
    ``;``."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, PixelList):
        return f"{value.width}x{value.height} values; {program()} image writes them to a file"
    if isinstance(value, (bytes, bytearray)):
        return _readable(bytes(value))
    if isinstance(value, list):
        items = cast("list[Any]", value)
        return (";" if items and isinstance(items[0], list) else ",").join(map(as_text, items))
    return str(value)


def _names(command: Command) -> list[str]:
    return [result.name for result in command.results if not result.meaning.automatic]


def _plain(value: Any) -> Any:
    if isinstance(value, (bytes, bytearray)):
        return _readable(bytes(value))
    if isinstance(value, PixelList):
        return list(value)
    return value


def _readable(data: bytes) -> str:
    """Return bytes as text if they are text, else in hexadecimal digits."""
    try:
        text = data.decode("utf-8")
    except UnicodeDecodeError:
        return data.hex(" ")
    return text if all(sign.isprintable() or sign in "\n\t" for sign in text) else data.hex(" ")
