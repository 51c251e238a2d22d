"""Replies of the original's protocol: the commands of an answer, and the values in their payloads."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from simx_client.protocol.table.original_wire import Wire
from simx_server.gateways.original import forms
from simx_server.gateways.original.messages import (
    COMMAND,
    FAILED,
    HEADER,
    ID_MASK,
    MODE_MASK,
    Malformed,
    Request,
)


class Reply(NamedTuple):
    """One command of an answer."""

    request: Request
    """The command as a request has it; a stream in pieces comes in several."""

    time: float
    """Simulated seconds."""

    has_failed: bool
    whole: bytes
    """All bytes of it."""


def replies(answer: bytes) -> Iterator[Reply]:
    """Yield the commands of a message from a server. Raises Malformed."""
    position = HEADER.size
    if len(answer) < position:
        raise Malformed(f"an answer of {len(answer)} bytes, which is less than its header")
    while position < len(answer):
        if len(answer) - position < COMMAND.size:
            raise Malformed("a reply that ends within its header")
        size, full, ident_size, offset, command, low, time_ms, status, _ = COMMAND.unpack_from(
            answer, position
        )
        if not COMMAND.size <= size <= len(answer) - position or ident_size > size - COMMAND.size:
            raise Malformed(f"a reply of {size} bytes where {len(answer) - position} are left")
        whole = answer[position : position + size]
        body = whole[COMMAND.size :]
        request = Request(
            command & ID_MASK,
            command & MODE_MASK,
            low,
            body[:ident_size],
            body[ident_size:],
            False,
            full,
            offset,
        )
        yield Reply(request, time_ms / 1000, bool(status & FAILED), whole)
        position += size


def read_values(wire: Wire, payload: bytes) -> list[Any]:
    """Return the results in the payload of a complete reply. Raises Unreadable."""
    reader = forms.Reader(payload)
    if wire.reply == ("group",):
        counts = reader.numbers(4, "i")
        parts = [
            reader.numbers(counts[0], "i"),
            reader.numbers(counts[1], "i"),
            reader.numbers(counts[2], "f"),
        ]
        return [*parts, [reader.text() for _ in range(_count(reader, counts[3]))]]
    found: list[Any] = []
    for form in wire.reply:
        if form == "n*i":
            found.append(reader.numbers(_count(reader, reader.int()), "i"))
        elif form == "n*z":
            found.append([reader.text() for _ in range(_count(reader, reader.int()))])
        elif form == "sizes":
            sizes = reader.numbers(_count(reader, reader.int()), "i")
            found.append([reader.numbers(size, "f") for size in sizes])
        else:
            found += forms.read(reader, form)
    return found


def _count(reader: forms.Reader, count: int) -> int:
    if not 0 <= count <= reader.left:
        raise forms.Unreadable(f"its payload cannot hold {count} values")
    return count


def numbers_of(wire: Wire, values: Sequence[Any]) -> list[float]:
    """Return the real numbers and switches among the results, which can be compared; handles and images cannot."""
    if wire.reply in (("group",), ("lists",)):
        return list(values[2 if wire.reply == ("group",) else 1])
    found: list[float] = []
    for form, value in zip(wire.reply, values, strict=True):
        if form == "sizes":
            found += [number for packet in value for number in packet]
        elif form == "b":
            found.append(float(value))
        elif form.endswith("f"):
            found += value if isinstance(value, list) else [value]
    return found
