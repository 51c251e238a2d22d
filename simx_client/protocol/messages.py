"""The messages: a batch of calls goes out, deliveries of replies come back, a greeting opens.

Every message is a msgpack list in field order. Numbers with a fraction travel as float32, as they did
in the original. A stream is known by the id of the call that armed it, so an answer that was on its way
when the stream was replaced can never be taken for a new one.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum
from typing import Any, NamedTuple, Protocol, TypeVar, cast

_Message = TypeVar("_Message")


class _OfFields(Protocol):
    def __call__(self, kind: type[_Message], fields: Sequence[Any], /) -> _Message: ...


of_fields = cast(_OfFields, tuple.__new__)  # pyright: ignore[reportUnknownMemberType]
"""Makes a named tuple, in half the time that its class takes: each call passes here several times."""

PROTOCOL_VERSION = 1
"""The newest that is spoken here. Counts up when an older peer could misread a message; see docs/protocol.md."""

OLDEST_PROTOCOL = 1
"""The oldest that is spoken here as well."""

STATUS_OK = 0
STATUS_REMOTE_ERROR = 8
"""The status of a reply; the same number as ``simx_return_remote_error_flag``."""

CLIENT_TIME_MASK = 0x03FF_FFFF
"""Client time stamps are milliseconds modulo 2**26, as in the original header."""


Spoken = tuple[int, int]
"""The oldest and the newest version that somebody speaks."""


def choose_version(client: Spoken, server: Spoken) -> int | None:
    """The newest version that both speak; None when there is none."""
    version = min(client[1], server[1])
    return version if version >= max(client[0], server[0]) else None


def no_common_version(client: Spoken, server: Spoken) -> str:
    """Why there is no connection, and who is to be upgraded."""

    def listed(versions: Spoken) -> str:
        return str(versions[0]) if versions[0] == versions[1] else f"{versions[0]} to {versions[1]}"

    older = "client" if client[1] < server[0] else "server"
    return (
        f"client and server share no version of the protocol (the client speaks {listed(client)}, the server "
        f"{listed(server)}); upgrade the {older}, to the release that the other side has"
    )


class Operation(IntEnum):
    """What the server is to do with a call."""

    EXECUTE = 0
    """Once."""

    STREAM = 1
    """Now, and again after each pass, until cancelled."""

    CANCEL = 2
    """End the stream whose id is the only argument (0 for none); answered with an empty reply."""


NOT_AWAITED_MS = 1
"""The delay of a call whose answer nobody waits for."""


class Pace(IntEnum):
    """When the server executes a blocking call while a simulation runs that nobody steps: the call's delay."""

    FREE = 0
    """At once."""

    REPEAT = -1
    """At once, unless the client made a paced call of this key since the last simulation step: then after the next."""

    EVERY = -2
    """After the next simulation step."""


class Call(NamedTuple):
    call_id: int
    operation: int
    delay_ms: int
    """Least wall time between two executions of a stream. Of what is executed once, how long its answer may wait for
    others to leave with: 0 when somebody waits for it; below 0 a `Pace`."""

    command: str
    arguments: list[Any]


class Batch(NamedTuple):
    """Client to server. The calls are executed in this order, with no pass between them, but for the pass that a
    trigger among them is answered after: what follows the trigger is executed after it too, unless the client's next
    batch comes first."""

    message_id: int
    client_time: int
    calls: list[Call]


class Reply(NamedTuple):
    call_id: int
    status: int
    """STATUS_OK, or STATUS_REMOTE_ERROR with the error's text as the only value."""

    time_ms: int
    """Simulation time at execution, 0 while stopped."""

    values: list[Any]
    """The command's results. Of one without, that nobody waits for: to how many such calls, with ids from this one on,
    this is the reply."""


class Delivery(NamedTuple):
    """Server to client. ``message_id`` and ``client_time`` are those of the client's last batch."""

    message_id: int
    client_time: int
    server_time: int
    scene_id: int
    server_state: int
    """Bit 0: not stopped, bit 1: paused, bit 2: real time."""

    replies: list[Reply]


class Greeting(NamedTuple):
    """Client to server, once per connection."""

    protocol: int
    """The oldest version that the client speaks: servers from before there were two compare it with theirs."""

    client: str
    """The key segment this client is reached under."""

    name: str
    """For people: the program and its process id."""

    port: int
    """The port the client asked for; 19999 may start the simulation."""

    newest: int
    """The newest version that the client speaks; a client that does not say it speaks one alone."""


class Welcome(NamedTuple):
    """Server to client. ``refusal`` is empty, or the sentence that says why there is no connection."""

    protocol: int
    """The version chosen, the newest that both speak; to a question without a greeting the server's newest."""

    refusal: str
    realm: str
    scene: str
    server: str


class Status(NamedTuple):
    """Server to whoever asks: where it is, what it does, how loaded it is."""

    protocol: int
    realm: str
    scene: str
    state: str
    """stopped, running or paused."""

    clients: int
    ports: list[int]
    """On the loopback interface of its host."""

    host: str
    process_id: int
    age: float
    """Seconds since the server was ready."""

    real_time_factor: float
    """Simulated seconds per second of the last one or two; 0 unless it runs."""

    core_share: float
    """Processor seconds of all threads of the process per second, over the same time."""

    server: str
    """Its version."""
