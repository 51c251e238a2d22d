"""Find the first simulation step in which two recordings differ, and the first call that differs before it."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import zip_longest
from pathlib import Path
from typing import Any

from simx_client.protocol.codec import CodecError, decode_batch
from simx_server.gateways.zmq.peer import NUMBER_BYTES
from simx_server.gateways.zmq.wire import WireError, read_request

from . import state
from .log_file import LogError, LogReader
from .records import Kind, Record

_LONGEST_ARGUMENTS = 120
"""Characters of a call's arguments that are shown."""


@dataclass
class Course:
    """The simulation steps of a recording, counted from 1 over all its runs, and the calls before them."""

    path: Path
    steps: list[bytes] = field(default_factory=list[bytes])
    """Checksums after each step (`state.of_step`)."""

    before: dict[int, list[str]] = field(default_factory=lambda: defaultdict(list[str]))
    """The acts and calls of clients before a step, by its number, as texts."""

    damage: str = ""
    """Why the rest could not be read, else empty."""

    @classmethod
    def of(cls, path: Path) -> Course:
        """Read a recording. Raises LogError."""
        reader = LogReader(path)
        course = cls(path)
        names: dict[int, str] = {}
        zmq: set[int] = set()
        for record in reader:
            if record[0] == Kind.PASS:
                course.steps.append(record[1])
            else:
                course.before[len(course.steps) + 1] += _texts(record, names, zmq)
        course.damage = reader.damage
        return course


@dataclass(frozen=True)
class Difference:
    """The first step in which two recordings differ."""

    step: int
    """Counted from 1."""

    quantities: list[str]
    """The quantities that differ after it; empty where one recording ends before it."""

    ended: Path | None
    """The recording that ends before this step."""

    call_step: int | None
    """The step before which clients did something else for the first time; None: they did the same."""

    calls: tuple[list[str], list[str]]
    """The acts of the clients of each before that step, or else before the step that differs."""


def first_difference(one: Course, other: Course) -> Difference | None:
    """Compare two recordings; return None if all steps are equal."""
    if not (one.steps and other.steps):
        empty = one if not one.steps else other
        raise LogError(f"'{empty.path}' has no simulation step to compare")
    for number, (mine, its) in enumerate(zip_longest(one.steps, other.steps), 1):
        if mine is None or its is None:
            return _difference(one, other, number, [], one.path if mine is None else other.path)
        if mine != its:
            return _difference(one, other, number, state.differences_of_step(mine, its), None)
    return None


def _difference(
    one: Course, other: Course, step: int, quantities: list[str], ended: Path | None
) -> Difference:
    changed = (number for number in range(1, step + 1) if one.before.get(number) != other.before.get(number))
    call_step = next(changed, None)
    shown = step if call_step is None else call_step
    calls = one.before.get(shown, []), other.before.get(shown, [])
    return Difference(step, quantities, ended, call_step, calls)


def _texts(record: Record, names: dict[int, str], zmq: set[int]) -> Iterator[str]:
    """Yield what a client did; `names` of clients by number, `zmq` those of the ZeroMQ remote API."""
    match record:
        case [Kind.JOINED | Kind.JOINED_ZMQ as kind, _, number, _, name, _]:
            names[number] = name
            if kind == Kind.JOINED_ZMQ:
                zmq.add(number)
            yield f"client '{name}' joined"
        case [Kind.LEFT, _, number]:
            yield f"client '{names.get(number, number)}' left"
        case [Kind.BATCH, _, number, payload]:
            for call in _zmq_calls(payload) if number in zmq else _calls(payload):
                yield f"'{names.get(number, number)}' called {call}"
        case [Kind.STARTED]:
            yield "the simulation was started"
        case [Kind.ENDING]:
            yield "the server was requested to end"
        case _:
            pass


def _calls(payload: bytes) -> Iterator[str]:
    try:
        batch = decode_batch(payload)
    except CodecError:
        yield "something that cannot be read"
        return
    for call in batch.calls:
        yield _call(call.command, call.arguments)


def _zmq_calls(payload: bytes) -> Iterator[str]:
    try:
        request = read_request(payload[NUMBER_BYTES:])
    except WireError:
        yield "something that cannot be read"
        return
    yield _call(request.function, request.arguments)


def _call(function: str, arguments: list[Any]) -> str:
    text = ", ".join(f"{len(each)} bytes" if isinstance(each, bytes) else repr(each) for each in arguments)
    if len(text) > _LONGEST_ARGUMENTS:
        text = text[:_LONGEST_ARGUMENTS] + " ..."
    return f"{function}({text})"
