"""All live simulators within reach: their names from Zenoh's liveliness tokens, the rest by one question to each.

One that has a token but does not answer in time is listed as well: it is frozen, busy, or its host was just cut off.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Generator, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any, NamedTuple

from .errors import ConnectionFailed
from .protocol import keys, link
from .protocol.codec import CodecError, decode_status
from .protocol.messages import Status
from .session import open_session

logger = logging.getLogger(__name__)

TIMEOUT = 2.0
"""Seconds for an endpoint to tell what is there, and for the simulators to answer."""

SEEN_AGAIN = 0.1
"""Seconds until an endpoint that has no tokens yet is believed: its neighbours' may be on the way."""

SESSIONS = 16
"""Endpoints that are looked at at the same time."""


class Found(NamedTuple):
    """One live simulator."""

    realm: str
    endpoint: str
    """Where it was found; a server's own or a router's."""

    status: Status | None
    """None when it did not answer."""


class Unreachable(NamedTuple):
    """An endpoint where nothing could be asked."""

    endpoint: str
    reason: str


def find_servers(endpoints: Iterable[str], timeout: float = TIMEOUT) -> tuple[list[Found], list[Unreachable]]:
    """Every simulator that can be reached by these Zenoh endpoints, each once, by realm.

    Args:
        endpoints: of servers and routers, such as ``tcp/router:7447``.
        timeout: seconds for each endpoint; they are looked at side by side.

    Returns:
        What is there, and the endpoints that could not be asked.
    """
    places = list(dict.fromkeys(endpoints))
    if not places:
        return [], []
    zenoh = link.import_zenoh()
    unreachable: list[Unreachable] = []
    found: dict[tuple[str, str, int], Found] = {}
    with ThreadPoolExecutor(min(SESSIONS, len(places)), thread_name_prefix="simx-list") as pool:
        looks = [pool.submit(_look, zenoh, place, timeout) for place in places]
        for place, look in zip(places, looks, strict=True):
            try:
                for server in look.result():
                    found.setdefault(_identity(server), server)
            except ConnectionFailed as error:
                unreachable.append(Unreachable(place, str(error)))
    answered = {server.realm for server in found.values() if server.status is not None}
    servers = [one for one in found.values() if one.status is not None or one.realm not in answered]
    return sorted(servers, key=_identity), unreachable


def _identity(server: Found) -> tuple[str, str, int]:
    """Two processes may have been given the same realm by mistake."""
    status = server.status
    return (server.realm, "", 0) if status is None else (server.realm, status.host, status.process_id)


def _look(zenoh: Any, endpoint: str, timeout: float) -> list[Found]:
    deadline = time.monotonic() + timeout
    with _session(zenoh, endpoint, timeout) as session:
        realms = _realms(session, deadline)
        # All are asked before any answer is awaited.
        asked = [(realm, _ask(zenoh, session, realm, deadline)) for realm in realms]
        return [
            Found(realm, endpoint, status)
            for realm, replies in asked
            for status in _statuses(realm, replies) or [None]
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


def _realms(session: Any, deadline: float) -> list[str]:
    """The names of all that are alive, as this endpoint knows them."""
    patience = min(deadline, time.monotonic() + SEEN_AGAIN)
    while True:
        left = max(0.05, deadline - time.monotonic())
        tokens = session.liveliness().get(keys.ANY_ALIVE, timeout=left)
        realms = {keys.realm_of(str(token.ok.key_expr)) for token in tokens if token.ok is not None}
        if realms or time.monotonic() >= patience:
            return sorted(realms)
        time.sleep(0.01)


def _ask(zenoh: Any, session: Any, realm: str, deadline: float) -> Any:
    return session.get(
        keys.status(realm),
        timeout=max(0.05, deadline - time.monotonic()),
        target=zenoh.QueryTarget.ALL,
        consolidation=zenoh.ConsolidationMode.NONE,
    )


def _statuses(realm: str, replies: Any) -> Sequence[Status]:
    statuses: list[Status] = []
    for reply in replies:
        if reply.ok is not None:
            try:
                statuses.append(decode_status(reply.ok.payload.to_bytes()))
            except CodecError as error:
                logger.warning("realm %s answered something unreadable: %s", realm, error)
    return statuses
