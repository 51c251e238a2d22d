"""A server's reports for operators: health and metrics, as JSON, so that any Zenoh tool can read them.

Times are in seconds. "Recent" is the last five to six seconds; ``window`` is the exact duration. A later version may
add fields to every object; the present fields stay.
"""

from __future__ import annotations

import json
import types
from collections.abc import Mapping
from typing import Any, TypedDict, cast, get_args, get_origin, get_type_hints, is_typeddict

from .codec import CodecError

MAX_REPORT = 16 << 20
"""Maximum size of a decoded report in bytes."""


class Health(TypedDict):
    """Health of a server. A server that does not answer is frozen, busy with one long call, or disconnected."""

    protocol: int
    realm: str
    server: str
    """Version of the server."""

    state: str
    """stopped, running or paused."""

    age: float
    """Seconds since the server was started."""

    problems: list[str]
    """Sentences on recent problems of a server that still answers."""


class Percentiles(TypedDict):
    """Percentiles within 10 %; 0 without values."""

    p50: float
    p90: float
    p99: float


class Recent(Percentiles):
    per_second: float


class Timing(Percentiles):
    """How often something happened, and how long it took."""

    count: int
    seconds: float
    """Sum of all durations."""

    longest: float
    recent: Recent


class Steps(TypedDict):
    count: int
    per_second: float
    """Recent."""

    simulated: float
    """Simulated seconds."""

    real_time_factor: float
    """Recent simulated seconds per second."""

    speed: float | None
    """Target of the real-time factor; None: as fast as possible."""

    time_step: float
    """Simulated seconds of one simulation step."""

    lost: float
    """Seconds that the simulation fell behind and skipped."""

    times: Timing
    """Times of the simulation steps, without streams and calls."""


class CallsAdditions(TypedDict, total=False):
    """Fields that servers of the first versions do not send."""

    dropped: int
    """Messages that were not executed, since the client's queue was full."""


class Calls(CallsAdditions):
    """Calls of clients, without executions of streams."""

    count: int
    per_second: float
    failed: int
    """Calls and streams that failed, with a text for the client."""

    failed_per_second: float


class Command(Timing):
    """Calls and streams of one command.

    The time is that of the physics thread: without the round trip, the rendering of an image or the
    simulation step of a trigger, which do not delay others.
    """

    failed: int
    silent: int
    """Answered with code 8 without a text: nothing to read."""

    internal: int
    """Failed because of a fault in the server."""

    last_error: str


class ClientAdditions(TypedDict, total=False):
    """Fields that servers of the first versions do not send."""

    commands: dict[str, int]
    """Number of calls by command; unknown commands are "(unknown)"."""


class Client(ClientAdditions):
    name: str
    role: str
    """driver or viewer."""

    port: int
    calls: int
    calls_per_second: float
    streams: int
    is_stepping: bool


class Images(TypedDict):
    backend: str | None
    """None before the first image."""

    waiting: int
    failed: int
    last_error: str
    cameras: dict[str, Timing]
    """By the camera's name; an image for several requests counts once."""


class Process(TypedDict):
    memory: int
    """Resident memory in bytes; 0 if the system does not report it."""

    open_files: int | None
    """None if the system does not report it."""

    threads: int
    """Threads of Python; Zenoh, MuJoCo and OpenGL have more."""

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
    """Number of calls by command."""

    ago: float
    """Seconds since it left."""


class MetricsAdditions(TypedDict, total=False):
    """Fields that servers of the first versions do not send."""

    departed: list[DepartedClient]
    """Clients that left last, the newest at the end; a bounded number."""


class Metrics(Health, MetricsAdditions):
    host: str
    process_id: int
    ports: list[int]
    """Ports on the loopback interface of its host."""

    scene: str
    window: float
    steps: Steps
    calls: Calls
    commands: dict[str, Command]
    """Commands that were executed or failed, by name."""

    clients: list[Client]
    streams: int
    images: Images
    process: Process
    log: Log


def encode_report(report: Health | Metrics) -> bytes:
    """Encode a report as JSON."""
    return json.dumps(report, allow_nan=False).encode()


def decode_health(payload: bytes) -> Health:
    """Read and check a server's health. Raises CodecError."""
    return cast(Health, _decode(payload, Health))


def decode_metrics(payload: bytes) -> Metrics:
    """Read and check a server's metrics. Raises CodecError."""
    return cast(Metrics, _decode(payload, Metrics, _FORMER))


_FORMER = {"passes": "steps", "pictures": "images"}
"""Fields by their names in servers of version 0.4."""


def _decode(payload: bytes, kind: type, former: Mapping[str, str] = types.MappingProxyType({})) -> Any:
    if len(payload) > MAX_REPORT:
        raise CodecError(f"report of {len(payload)} bytes; at most {MAX_REPORT} are read")
    try:
        value = json.loads(payload)
    except (ValueError, RecursionError) as error:
        raise CodecError(f"not a report: {error}") from None
    for old, new in former.items():
        if old in _mapping(value, kind.__name__):
            value.setdefault(new, value.pop(old))
    _check(value, kind, kind.__name__)
    return value


def _check(value: Any, kind: Any, where: str) -> None:
    """Raise CodecError unless a value of JSON is of this kind; accept unknown fields."""
    origin, parts = get_origin(kind), get_args(kind)
    if is_typeddict(kind):
        _check_fields(_mapping(value, where), kind, where)
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


def _check_fields(fields: Mapping[str, Any], kind: Any, where: str) -> None:
    """Raise CodecError unless an object of JSON has the fields of this TypedDict."""
    for name, part in get_type_hints(kind).items():
        if name in fields:
            _check(fields[name], part, f"{where}.{name}")
        elif name not in kind.__optional_keys__:
            raise CodecError(f"{where}.{name} is missing")


def _mapping(value: Any, where: str) -> Mapping[str, Any]:
    if not isinstance(value, dict):
        raise CodecError(f"{where} must be an object, got {type(value).__name__}")
    return cast(dict[str, Any], value)
