"""The messages: a batch of calls goes out, deliveries of replies come back, a greeting opens.

Every message is a msgpack list in field order. Numbers with a fraction are float32, as in the original. The
id of a stream is that of the call that started it, so an answer that was on its way when the stream was
replaced cannot be taken for a new one.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum
from typing import Any, NamedTuple, Protocol, TypeVar, cast

_Message = TypeVar("_Message")


class _OfFields(Protocol):
    def __call__(self, kind: type[_Message], fields: Sequence[Any], /) -> _Message: ...


of_fields = cast(_OfFields, tuple.__new__)  # pyright: ignore[reportUnknownMemberType]
"""Makes a named tuple in half the time of its class: every call makes several."""

PROTOCOL_VERSION = 1
"""Newest supported version. Incremented when an older peer could misread a message; see docs/internals/protocol.md."""

OLDEST_PROTOCOL = 1
"""Oldest supported version."""

STATUS_OK = 0
STATUS_REMOTE_ERROR = 8
"""Status of a reply; the same number as ``simx_return_remote_error_flag``."""

CLIENT_TIME_MASK = 0x03FF_FFFF
"""Client time stamps are milliseconds modulo 2**26, as in the original header."""


Spoken = tuple[int, int]
"""Oldest and newest version of one side."""


def choose_version(client: Spoken, server: Spoken) -> int | None:
    """Return the newest version that both sides support; None without one."""
    version = min(client[1], server[1])
    return version if version >= max(client[0], server[0]) else None


def no_common_version(client: Spoken, server: Spoken) -> str:
    """Return why the versions do not match, and which side to upgrade."""

    def listed(versions: Spoken) -> str:
        return str(versions[0]) if versions[0] == versions[1] else f"{versions[0]} to {versions[1]}"

    older = "client" if client[1] < server[0] else "server"
    return (
        f"client and server share no version of the protocol (the client speaks {listed(client)}, the server "
        f"{listed(server)}); upgrade the {older}, to the release that the other side has"
    )


class Operation(IntEnum):
    """Operation of the server on a call."""

    EXECUTE = 0
    """Execute it once."""

    STREAM = 1
    """Execute it now, and again after each simulation step, until cancelled."""

    CANCEL = 2
    """End the stream whose id is the only argument (0 for none); answered with an empty reply."""


NOT_AWAITED_MS = 1
"""The delay of a call without a waiting caller."""


class Pace(IntEnum):
    """When the server executes a blocking call while the simulation runs without stepped mode: the call's
    delay."""

    FREE = 0
    """Execute it at once."""

    REPEAT = -1
    """Execute it at once if, since the last simulation step, the client has made only paced calls that read, of other
    keys, and it reads too; otherwise after the next."""

    EVERY = -2
    """Execute it after the next simulation step."""


class Call(NamedTuple):
    call_id: int
    operation: int
    delay_ms: int
    """Minimum wall time in ms between two executions of a stream. For a single execution, the time that its
    answer may wait for others to leave with: 0 if the caller waits for it; below 0 a `Pace`."""

    command: str
    arguments: list[Any]


class Batch(NamedTuple):
    """Client to server. The calls are executed in this order, within one simulation step.

    A trigger among them is answered after the step that it requests. The calls after the trigger are executed
    after it too, unless the client's next batch comes first.
    """

    message_id: int
    client_time: int
    calls: list[Call]


class Reply(NamedTuple):
    call_id: int
    status: int
    """STATUS_OK, or STATUS_REMOTE_ERROR with the error's text as the only value."""

    time_ms: int
    """Simulation time at execution in ms, 0 while stopped."""

    values: list[Any]
    """The command's results. For a command without results or waiting caller: the number of such calls, with
    ids from this one on, that this reply answers."""


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
    """Oldest version of the client; old servers, which know only one version, compare it with theirs."""

    client: str
    """Key segment of the client's messages."""

    name: str
    """The program and its process id, for messages."""

    port: int
    """Port that the client connected to; 19999 may start the simulation."""

    newest: int
    """Newest version of the client; an old client, which knows only one version, omits it."""


class Welcome(NamedTuple):
    """Server to client. ``refusal`` is empty, or the sentence with the reason for the refusal."""

    protocol: int
    """The chosen version, the newest that both support; in a reply without a greeting, the server's newest.
    """

    refusal: str
    realm: str
    scene: str
    server: str
    local: str = ""
    """``TOKEN@PATH`` of a socket for clients on the server's host; empty without one, and from old servers."""


class Status(NamedTuple):
    """A server's reply to a status request: its host, state and load."""

    protocol: int
    realm: str
    scene: str
    state: str
    """stopped, running or paused."""

    clients: int
    ports: list[int]
    """Ports on the loopback interface of its host."""

    host: str
    process_id: int
    age: float
    """Seconds since the server was ready."""

    real_time_factor: float
    """Simulated seconds per second of the last one or two; 0 unless it runs."""

    core_share: float
    """Processor seconds of all threads of the process per second, over the same time."""

    server: str
    """Version of the server."""
