"""What a server tells of itself for operators: health and metrics, as JSON, so that any Zenoh tool can read them.

Times are in seconds. "Recent" is the last five to six seconds, ``window`` says how long exactly. A later version may
add to every object; what is here stays.
"""

from __future__ import annotations

import json
import types
from collections.abc import Mapping
from typing import Any, TypedDict, cast, get_args, get_origin, get_type_hints, is_typeddict

from .codec import CodecError

MAX_REPORT = 16 << 20
"""Largest report in bytes that is decoded."""


class Health(TypedDict):
    """A server that does not answer is frozen, busy with one long call, or cut off."""

    protocol: int
    realm: str
    server: str
    """Its version."""

    state: str
    """stopped, running or paused."""

    age: float
    """Seconds since the server was started."""

    problems: list[str]
    """Sentences on what has gone wrong in recent seconds, although it answers."""


class Percentiles(TypedDict):
    """Within 10 %; 0 when there was nothing."""

    p50: float
    p90: float
    p99: float


class Recent(Percentiles):
    per_second: float


class Timing(Percentiles):
    """How often something happened, and how long it took."""

    count: int
    seconds: float
    """Of all together."""

    longest: float
    recent: Recent


class Passes(TypedDict):
    count: int
    per_second: float
    """Recent."""

    simulated: float
    """Seconds."""

    real_time_factor: float
    """Recent simulated seconds per second."""

    speed: float | None
    """What it should be; None: as much as possible."""

    time_step: float
    """Simulated seconds of one pass."""

    lost: float
    """Seconds that the simulation fell behind and gave up."""

    times: Timing
    """Of the passes themselves, without streams and calls."""


class CallsAdditions(TypedDict, total=False):
    """What servers of the first versions do not tell."""

    dropped: int
    """Messages that were not executed, as too much of their client waited."""


class Calls(CallsAdditions):
    """What clients sent. What streams execute is no call."""

    count: int
    per_second: float
    failed: int
    """Of calls and streams, with a text for the client."""

    failed_per_second: float


class Command(Timing):
    """Of calls and streams. The time is that of the thread that simulates: without the way there and back, without the
    rendering of a picture or the pass of a trigger, which others do not wait for."""

    failed: int
    silent: int
    """Answered 8 without a text: nothing to read yet, or any more."""

    internal: int
    """Of those that failed: by a mistake of the server's own."""

    last_error: str


class ClientAdditions(TypedDict, total=False):
    """What servers of the first versions do not tell."""

    commands: dict[str, int]
    """How often it has called what; what is no command is "(unknown)"."""


class Client(ClientAdditions):
    name: str
    role: str
    """driver or viewer."""

    port: int
    calls: int
    calls_per_second: float
    streams: int
    is_stepping: bool


class Pictures(TypedDict):
    backend: str | None
    """None before the first picture."""

    waiting: int
    failed: int
    last_error: str
    cameras: dict[str, Timing]
    """By the camera's name; a picture that several askers share counts once."""


class Process(TypedDict):
    memory: int
    """Resident bytes; 0 where the system does not tell."""

    open_files: int | None
    """None where the system does not tell."""

    threads: int
    """Of Python; Zenoh, MuJoCo and OpenGL have more."""

    processor_seconds: float
    core_share: float
    """Recent processor seconds of all threads per second."""


class Log(TypedDict):
    warnings: int
    errors: int
    last_warning: str
    last_error: str


class DepartedClient(TypedDict):
    """A client that has left."""

    name: str
    role: str
    port: int
    calls: int
    commands: dict[str, int]
    """How often it called what."""

    ago: float
    """Seconds since it left."""


class MetricsAdditions(TypedDict, total=False):
    """What servers of the first versions do not tell."""

    departed: list[DepartedClient]
    """Those that left last, the newest at the end; a bounded number."""


class Metrics(Health, MetricsAdditions):
    host: str
    process_id: int
    ports: list[int]
    """On the loopback interface of its host."""

    scene: str
    window: float
    passes: Passes
    calls: Calls
    commands: dict[str, Command]
    """By name, those that were executed or failed."""

    clients: list[Client]
    streams: int
    pictures: Pictures
    process: Process
    log: Log


def encode_report(report: Health | Metrics) -> bytes:
    """A report as it travels."""
    return json.dumps(report, allow_nan=False).encode()


def decode_health(payload: bytes) -> Health:
    """Read and check a server's health. Raises CodecError."""
    return cast(Health, _decode(payload, Health))


def decode_metrics(payload: bytes) -> Metrics:
    """Read and check a server's metrics. Raises CodecError."""
    return cast(Metrics, _decode(payload, Metrics))


def _decode(payload: bytes, kind: type) -> Any:
    if len(payload) > MAX_REPORT:
        raise CodecError(f"report of {len(payload)} bytes; at most {MAX_REPORT} are read")
    try:
        value = json.loads(payload)
    except (ValueError, RecursionError) as error:
        raise CodecError(f"not a report: {error}") from None
    _check(value, kind, kind.__name__)
    return value


def _check(value: Any, kind: Any, where: str) -> None:
    """Raise CodecError unless a value of JSON is of this kind; unknown fields pass."""
    origin, parts = get_origin(kind), get_args(kind)
    if is_typeddict(kind):
        fields = _mapping(value, where)
        for name, part in get_type_hints(kind).items():
            if name not in fields:
                if name in kind.__optional_keys__:
                    continue
                raise CodecError(f"{where}.{name} is missing")
            _check(fields[name], part, f"{where}.{name}")
    elif origin is dict:
        for name, item in _mapping(value, where).items():
            _check(item, parts[1], f"{where}[{name!r}]")
    elif origin is list:
        if not isinstance(value, list):
            raise CodecError(f"{where} must be a list, got {type(value).__name__}")
        for item in cast(list[Any], value):
            _check(item, parts[0], f"{where}[]")
    elif origin is types.UnionType:
        if value is not None:
            _check(value, parts[0], where)
    elif type(value) is not kind and not (kind is float and type(value) is int):
        raise CodecError(f"{where} must be {kind.__name__}, got {type(value).__name__}")


def _mapping(value: Any, where: str) -> Mapping[str, Any]:
    if not isinstance(value, dict):
        raise CodecError(f"{where} must be an object, got {type(value).__name__}")
    return cast(dict[str, Any], value)
