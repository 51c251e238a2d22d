"""Find all live simulators: their names from Zenoh's liveliness tokens, the rest by one request to each.

A simulator that has a token but does not answer in time is listed too: it is frozen or busy, or its host was
just disconnected.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Generator, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Generic, NamedTuple, TypeVar

from simx_client.errors import ConnectionFailed
from simx_client.protocol import roster
from simx_client.protocol.codec import CodecError, decode_status
from simx_client.protocol.messages import Status
from simx_client.protocol.reports import Metrics, decode_metrics
from simx_client.protocol.zenoh import keys, link
from simx_client.transport.zenoh_session import living_realms, open_session

logger = logging.getLogger(__name__)
T = TypeVar("T")

TIMEOUT = 2.0
"""Time-out in seconds for an endpoint to list its simulators, and for the simulators to answer."""

SESSIONS = 16
"""Number of endpoints that are searched at the same time."""


class Found(NamedTuple):
    """A live simulator."""

    realm: str
    endpoint: str
    """Endpoint at which it was found; of the server or of a router."""

    status: Status | None
    """None if it did not answer."""


class Unreachable(NamedTuple):
    """An endpoint that did not answer."""

    endpoint: str
    reason: str


class Measured(NamedTuple):
    """A live simulator with its metrics."""

    realm: str
    endpoint: str
    metrics: Metrics | None
    """None if it did not answer."""


class _Answer(NamedTuple, Generic[T]):
    realm: str
    endpoint: str
    value: T | None


@dataclass(frozen=True)
class _Question(Generic[T]):
    """A request to each simulator."""

    key: Callable[[str], str]
    read: Callable[[bytes], T]
    process: Callable[[T], tuple[str, int]]
    """Returns host and process id: two processes may have the same realm by mistake."""

    def identity(self, answer: _Answer[T]) -> tuple[str, str, int]:
        return (answer.realm, "", 0) if answer.value is None else (answer.realm, *self.process(answer.value))


def silent_servers(unreachable: Iterable[Unreachable]) -> list[str]:
    """Describe the servers of this host that did not answer; leave out servers that have exited."""
    alive = roster.endpoints()
    return [
        f"the server of this host at {one.endpoint} does not answer; it is frozen, or just starts or ends"
        for one in unreachable
        if one.endpoint in alive
    ]


def find_servers(endpoints: Iterable[str], timeout: float = TIMEOUT) -> tuple[list[Found], list[Unreachable]]:
    """Find every simulator that these Zenoh endpoints reach, each once, by realm.

    Args:
        endpoints: of servers and routers, such as ``tcp/router:7447``.
        timeout: time-out in seconds for each endpoint; all are searched at the same time.

    Returns:
        The simulators, and the endpoints that did not answer.
    """
    question = _Question(keys.status, decode_status, lambda status: (status.host, status.process_id))
    answers, unreachable = _ask_all(endpoints, question, timeout)
    return [Found(each.realm, each.endpoint, each.value) for each in answers], unreachable


def measure_servers(
    endpoints: Iterable[str], timeout: float = TIMEOUT, realm: str | None = None
) -> tuple[list[Measured], list[Unreachable]]:
    """Find simulators as `find_servers` does, and request their metrics.

    Args:
        realm: only simulators of this name.
    """
    question = _Question(
        keys.metrics, decode_metrics, lambda metrics: (metrics["host"], metrics["process_id"])
    )
    answers, unreachable = _ask_all(endpoints, question, timeout, realm)
    return [Measured(each.realm, each.endpoint, each.value) for each in answers], unreachable


def _ask_all(
    endpoints: Iterable[str], question: _Question[T], timeout: float, realm: str | None = None
) -> tuple[list[_Answer[T]], list[Unreachable]]:
    places = list(dict.fromkeys(endpoints))
    if not places:
        return [], []
    zenoh = link.import_zenoh()
    unreachable: list[Unreachable] = []
    found: dict[tuple[str, str, int], _Answer[T]] = {}
    with ThreadPoolExecutor(min(SESSIONS, len(places)), thread_name_prefix="simx-list") as pool:
        looks = [pool.submit(_look, zenoh, place, question, timeout, realm) for place in places]
        for place, look in zip(places, looks, strict=True):
            try:
                for server in look.result():
                    found.setdefault(question.identity(server), server)
            except ConnectionFailed as error:
                unreachable.append(Unreachable(place, str(error)))
    answered = {server.realm for server in found.values() if server.value is not None}
    servers = [one for one in found.values() if one.value is not None or one.realm not in answered]
    return sorted(servers, key=question.identity), unreachable


def _look(
    zenoh: Any, endpoint: str, question: _Question[T], timeout: float, wanted: str | None
) -> list[_Answer[T]]:
    deadline = time.monotonic() + timeout
    with _session(zenoh, endpoint, timeout) as session:
        realms = living_realms(session, deadline)
        # All are requested before the first answer is awaited.
        asked = [
            (realm, _ask(zenoh, session, question.key(realm), deadline))
            for realm in realms
            if wanted in (None, realm)
        ]
        return [
            _Answer(realm, endpoint, value)
            for realm, replies in asked
            for value in _read(realm, replies, question) or [None]
        ]


@contextmanager
def _session(zenoh: Any, endpoint: str, timeout: float) -> Generator[Any]:
    options = {
        "mode": "client",
        "connect/endpoints": [endpoint],
        "connect/timeout_ms": 0,
        "transport/shared_memory/enabled": False,
    }
    try:
        session = open_session(
            zenoh, options, {**link.CLIENT, "transport/unicast/open_timeout": int(timeout * 1000)}
        )
    except zenoh.ZError:
        raise ConnectionFailed(f"nothing at {endpoint} speaks Zenoh and lets this client in") from None
    try:
        yield session
    finally:
        session.close()


def _ask(zenoh: Any, session: Any, key: str, deadline: float) -> Any:
    return session.get(
        key,
        timeout=max(0.05, deadline - time.monotonic()),
        target=zenoh.QueryTarget.ALL,
        consolidation=zenoh.ConsolidationMode.NONE,
    )


def _read(realm: str, replies: Any, question: _Question[T]) -> Sequence[T]:
    values: list[T] = []
    for reply in replies:
        if reply.ok is not None:
            try:
                values.append(question.read(reply.ok.payload.to_bytes()))
            except CodecError as error:
                logger.warning("realm %s answered something unreadable: %s", realm, error)
    return values
