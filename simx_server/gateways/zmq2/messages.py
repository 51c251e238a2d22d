"""The messages of API 2's ZeroMQ connection: maps with a key ``msg``, numbered by each side."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, cast

from ..zmq.wire.messages import LONGEST_NAME, Reader, WireError
from .tags import TaggedReader

CALL, REGISTER, RESULT, NOOP = "call", "registerCallback", "result", "noop"

_EDGE, _PLACES = 256, 4
"""Bytes at each end of a message in which its kind and number are looked for, and places that are looked at."""


@dataclass(frozen=True, slots=True)
class Message:
    """One message of a client."""

    kind: str
    """CALL, REGISTER, RESULT, NOOP, or another word."""

    number: int | None
    """The sender's number of the request; None: it gave none."""

    function: str = ""
    target: int | None = None
    """The object whose method is called; None: a function by its name."""

    arguments: tuple[Any, ...] = ()
    """Of a call; of a result its values."""

    is_error: bool = False
    is_global: bool = False
    """Of a registered function: it is also a call-back of the simulation."""


def read_message(payload: bytes) -> Message:
    """Return the content of a message.

    Raises:
        WireError: it cannot be read; the text is for the client.
    """
    found = TaggedReader(payload).whole()
    if not isinstance(found, dict):
        raise WireError("a message must be a map with msg")
    fields = cast(dict[Any, Any], found)
    kind, number = fields.get("msg"), fields.get("id")
    if not isinstance(kind, str):
        raise WireError(
            "the message has no msg, as those of API 2 have: for the ZeroMQ remote API of CoppeliaSim 4.3 to 4.10 "
            "start the server with --zmq, and connect to that port (23000)"
        )
    if number is not None and type(number) is not int:
        raise WireError("id must be a whole number")
    if kind == RESULT:
        return Message(
            kind, number, arguments=_results(fields.get("result")), is_error=bool(fields.get("error"))
        )
    if kind not in (CALL, REGISTER):
        return Message(kind, number)
    function = fields.get("func")
    if not isinstance(function, str) or not function or len(function) > LONGEST_NAME:
        raise WireError(f"func must be a text of at most {LONGEST_NAME} characters")
    if kind == REGISTER:
        return Message(kind, number, function, is_global=bool(fields.get("global")))
    return Message(kind, number, function, _target(fields.get("target")), _arguments(fields.get("args", [])))


def _target(value: Any) -> int | None:
    if value is None:
        return None
    handle = getattr(value, "handle", value)
    if type(handle) is not int or abs(handle) >= 1 << 31:
        raise WireError("target must be the handle of an object, or null")
    return handle


def _arguments(value: Any) -> tuple[Any, ...]:
    if isinstance(value, list):
        return tuple(cast(list[Any], value))
    if value == {}:  # an empty table of Lua
        return ()
    raise WireError("args must be a list")


def _results(value: Any) -> tuple[Any, ...]:
    """Return the values of a result, which need not be a list."""
    if isinstance(value, list):
        return tuple(cast(list[Any], value))
    return () if value is None or value == {} else (value,)


def result_of(number: int | None, values: Any) -> dict[str, Any]:
    """Return the answer to a request."""
    return {"msg": RESULT, **_numbered(number), "error": False, "result": values}


def error_of(number: int | None, text: str) -> dict[str, Any]:
    """Return the answer to a request that has failed."""
    return {"msg": RESULT, **_numbered(number), "error": True, "result": text}


def call_of(number: int | None, function: str, arguments: list[Any]) -> dict[str, Any]:
    """Return the call of a function of the client."""
    return {"msg": CALL, **_numbered(number), "func": function, "args": arguments}


def _numbered(number: int | None) -> dict[str, int]:
    return {} if number is None else {"id": number}


def kind_of(payload: bytes) -> str:
    """Return the kind of a message without reading the rest; empty if none is seen."""
    found = _value_of(payload, b"\x63msg")
    return found.decode("ascii", "replace") if isinstance(found, bytes) and len(found) <= 32 else ""


def function_of(payload: bytes) -> str:
    """Return the function of a message without reading the rest; empty if none is seen."""
    found = _value_of(payload, b"\x64func")
    return found.decode("utf-8", "replace") if isinstance(found, bytes) and len(found) <= LONGEST_NAME else ""


def number_of(payload: bytes) -> int | None:
    """Return the number of a message without reading the rest; None if none is seen."""
    found = _value_of(payload, b"\x62id")
    return found if type(found) is int else None


def _value_of(payload: bytes, key: bytes) -> Any:
    """Return the value of a key near the start or the end of a message; None if none is seen.

    Only ``args`` and ``result`` may be long, and the other keys stand on one side of them.
    """
    for edge in (payload[:_EDGE], payload[-_EDGE:]):
        place = -1
        for _ in range(_PLACES):
            place = edge.find(key, place + 1)
            if place < 0:
                break
            start = place + len(key)
            if start < len(edge) and edge[start] >> 5 in (0, 2, 3):
                try:
                    return Reader(edge, start).item(0)
                except (WireError, IndexError):
                    continue
    return None
