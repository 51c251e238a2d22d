"""Find the first simulation step in which two recordings differ, and the first call that differs before it."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from hashlib import blake2b
from itertools import zip_longest
from pathlib import Path
from typing import Any, NamedTuple

from simx_client.protocol.codec import CodecError, decode_batch
from simx_server.gateways.zmq.peer import NUMBER_BYTES
from simx_server.gateways.zmq.wire.messages import WireError, read_request
from simx_server.gateways.zmq2.clients import KEY
from simx_server.gateways.zmq2.messages import CALL, REGISTER, read_message

from . import state
from .log_file import LogError, LogReader
from .records import Kind, Record

_LONGEST_ARGUMENTS = 120
"""Characters of a call's arguments that are shown."""


class Act(NamedTuple):
    """One thing that a client did."""

    content: bytes
    """A digest of all of it, with the client's number in place of its name, which may be another in each run."""

    text: str
    """It in words; long arguments are cut off."""


class _Client(NamedTuple):
    number: int
    name: str
    protocol: str


_LEGACY, _ZMQ, _API_2 = "legacy", "zmq", "api 2"


@dataclass
class Course:
    """The simulation steps of a recording, counted from 1 over all its runs, and the calls before them."""

    path: Path
    steps: list[bytes] = field(default_factory=list[bytes])
    """Checksums after each step (`state.of_step`)."""

    before: dict[int, list[Act]] = field(default_factory=lambda: defaultdict(list[Act]))
    """The acts and calls of clients before a step, by its number."""

    damage: str = ""
    """Why the rest could not be read, else empty."""

    @classmethod
    def of(cls, path: Path) -> Course:
        """Read a recording. Raises LogError."""
        reader = LogReader(path)
        course = cls(path)
        clients: dict[int, _Client] = {}
        for record in reader:
            if record[0] == Kind.PASS:
                course.steps.append(record[1])
            else:
                course.before[len(course.steps) + 1] += _acts(record, clients)
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
    """The acts of the clients of each before that step, from the first one that differs; without such a step, all acts
    before the step that differs.
    """


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
    for number in range(1, step + 1):
        mine, its = one.before.get(number, []), other.before.get(number, [])
        same = _same_at_start(mine, its)
        if same < max(len(mine), len(its)):
            return Difference(step, quantities, ended, number, (_texts(mine[same:]), _texts(its[same:])))
    calls = _texts(one.before.get(step, [])), _texts(other.before.get(step, []))
    return Difference(step, quantities, ended, None, calls)


def _same_at_start(one: Sequence[Act], other: Sequence[Act]) -> int:
    """Return how many acts at the start are the same in both."""
    pairs = enumerate(zip(one, other, strict=False))
    differing = (place for place, (mine, its) in pairs if mine.content != its.content)
    return next(differing, min(len(one), len(other)))


def _texts(acts: Sequence[Act]) -> list[str]:
    return [act.text for act in acts]


def _acts(record: Record, clients: dict[int, _Client]) -> Iterator[Act]:
    """Yield what a client did, or what the server did to it; `clients` by number."""
    match record:
        case [Kind.JOINED | Kind.JOINED_ZMQ as kind, _, number, key, name, _]:
            protocol = _LEGACY if kind == Kind.JOINED else _API_2 if KEY in key else _ZMQ
            clients[number] = _Client(number, name, protocol)
            yield _act(f"client '{name}' joined", "joined", number, protocol)
        case [Kind.LEFT, _, number]:
            yield _act(f"client '{_known(clients, number).name}' left", "left", number)
        case [Kind.BATCH, _, number, payload]:
            client = _known(clients, number)
            yield from _calls(client, payload if client.protocol == _LEGACY else payload[NUMBER_BYTES:])
        case [Kind.WITHIN, number, bytes(payload)]:
            yield from _calls(_known(clients, number), payload)
        case [Kind.WITHIN, number, reason]:
            name = _known(clients, number).name
            yield _act(f"'{name}' did not answer a function that the server called: {reason}", number, reason)
        case [Kind.STEPPING_LOST, _, number]:
            name = _known(clients, number).name
            yield _act(f"the server ended the stepped mode of '{name}', which was silent", "lost", number)
        case [Kind.STARTED]:
            yield _act("the simulation was started", "started")
        case [Kind.RESUMED, what, _]:
            yield _act(f"the server began again: {what}", "resumed", what)
        case [Kind.ENDING]:
            yield _act("the server was requested to end", "ending")
        case _:
            pass


def _known(clients: dict[int, _Client], number: int) -> _Client:
    return clients.get(number, _Client(number, str(number), _LEGACY))


def _act(text: str, *content: object) -> Act:
    return Act(blake2b(repr(content).encode("utf-8", "surrogatepass"), digest_size=16).digest(), text)


def _calls(client: _Client, payload: bytes) -> Iterator[Act]:
    """Yield the calls in a message of a client."""
    try:
        if client.protocol == _API_2:
            yield _model_call(client, payload)
        elif client.protocol == _ZMQ:
            request = read_request(payload)
            yield _call(client, request.function, request.arguments)
        else:
            for call in decode_batch(payload).calls:
                yield _call(client, call.command, call.arguments)
    except (CodecError, WireError):
        yield _act(f"'{client.name}' sent something that cannot be read", client.number, payload)


def _model_call(client: _Client, payload: bytes) -> Act:
    """Return a message of API 2. Raises WireError."""
    message = read_message(payload)
    content = (client.number, message.kind, message.function, message.target, message.arguments)
    if message.kind == CALL:
        of_object = "" if message.target is None else f" of object {message.target}"
        shown = _shown(message.function, message.arguments)
        return _act(f"'{client.name}' called {shown}{of_object}", content)
    if message.kind == REGISTER:
        return _act(f"'{client.name}' registered {message.function}", content, message.is_global)
    shown = _shown(message.kind, message.arguments)
    return _act(f"'{client.name}' sent {shown}", content, message.is_error)


def _call(client: _Client, function: str, arguments: Sequence[Any]) -> Act:
    return _act(
        f"'{client.name}' called {_shown(function, arguments)}", client.number, function, list(arguments)
    )


def _shown(function: str, arguments: Sequence[Any]) -> str:
    text = ", ".join(f"{len(each)} bytes" if isinstance(each, bytes) else repr(each) for each in arguments)
    if len(text) > _LONGEST_ARGUMENTS:
        text = text[:_LONGEST_ARGUMENTS] + " ..."
    return f"{function}({text})"
