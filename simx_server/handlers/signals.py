"""Signals. `signals.py` of the server explains when a signal is cleared automatically."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from simx_client.protocol.kinds import MAX_BYTES
from simx_server.service.calls.registry import handler

from ..errors import CommandError

if TYPE_CHECKING:
    from simx_server.world.world import World

_LISTED = 8

MAX_STRING = MAX_BYTES
"""Length of the longest string signal in bytes."""


def _missing(kind: str, name: str, known: Mapping[str, object]) -> CommandError:
    listed = ", ".join(repr(each) for each in list(known)[:_LISTED]) or "none"
    more = f" and {len(known) - _LISTED} more" if len(known) > _LISTED else ""
    return CommandError(f"there is no {kind} signal {name!r}; set are: {listed}{more}")


@handler("simxSetIntegerSignal")
def set_integer_signal(world: World, name: str, value: int) -> None:
    """Ignore an empty name, as V-REP does; the same holds for all kinds."""
    if name:
        world.signals.set_integer(name, value)


@handler("simxGetIntegerSignal")
def get_integer_signal(world: World, name: str) -> int:
    value = world.signals.get_integer(name)
    if value is None:
        raise _missing("integer", name, world.signals.integers)
    return value


@handler("simxClearIntegerSignal")
def clear_integer_signal(world: World, name: str) -> None:
    """Accept the name of an unset signal."""
    world.signals.clear_integer(name)


@handler("simxSetFloatSignal")
def set_float_signal(world: World, name: str, value: float) -> None:
    if name:
        world.signals.set_float(name, value)


@handler("simxGetFloatSignal")
def get_float_signal(world: World, name: str) -> float:
    value = world.signals.get_float(name)
    if value is None:
        raise _missing("float", name, world.signals.floats)
    return value


@handler("simxClearFloatSignal")
def clear_float_signal(world: World, name: str) -> None:
    world.signals.clear_float(name)


@handler("simxSetStringSignal")
def set_string_signal(world: World, name: str, value: bytes) -> None:
    if name:
        world.signals.set_string(name, value)


@handler("simxGetStringSignal")
def get_string_signal(world: World, name: str) -> bytes:
    value = world.signals.get_string(name)
    if value is None:
        raise _missing("string", name, world.signals.strings)
    return value


@handler("simxClearStringSignal")
def clear_string_signal(world: World, name: str) -> None:
    world.signals.clear_string(name)


@handler("simxAppendStringSignal")
def append_string_signal(world: World, name: str, value: bytes) -> None:
    """Create the signal if it does not exist.

    Differs: string signals have a largest length; V-REP's grew until its memory was full.

    Raises:
        CommandError: the signal would become longer than one message can carry.
    """
    if not name:
        return
    length = len(world.signals.get_string(name) or b"") + len(value)
    if length > MAX_STRING:
        raise CommandError(
            f"string signal {name!r} would become {length} bytes long; at most {MAX_STRING}: read it more often"
        )
    world.signals.append_string(name, value)


@handler("simxReadStringStream")
def read_string_stream(world: World, name: str) -> bytes:
    """Clear the signal; the result is empty, without an error, when nothing was written."""
    return world.signals.take_string(name) or b""


@handler("simxGetAndClearStringSignal")
def get_and_clear_string_signal(world: World, name: str) -> bytes:
    value = world.signals.take_string(name)
    if value is None:
        raise _missing("string", name, world.signals.strings)
    return value
