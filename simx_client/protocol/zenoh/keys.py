"""The Zenoh key expressions. ``realm`` names a simulator, ``client`` one connection to it.

simx/<realm>/hello            queryable: greeting in, welcome out
simx/<realm>/alive            liveliness token of the server
simx/<realm>/status           queryable: state and load of the server
simx/<realm>/health           queryable, JSON: health
simx/<realm>/metrics          queryable, JSON: metrics
simx/<realm>/client/<client>  liveliness token of a client
simx/<realm>/call/<client>    batches of calls, client to server
simx/<realm>/reply/<client>   deliveries, every one arrives
simx/<realm>/stream/<client>  the newest values of all small streams of a client, of one instant
simx/<realm>/picture/<client>/<call id>   the newest image of one stream

Names of clients that come to a server by other protocols have a slash, so no key has one of them.
"""

from __future__ import annotations

import re

ROOT = "simx"
ANY_HELLO = f"{ROOT}/*/hello"
ANY_ALIVE = f"{ROOT}/*/alive"
VIEWER = "viewer-"
"""Clients whose name starts with this may only read. The name is part of every key, so Zenoh's access rules
can restrict a user to it, although such rules cannot read the commands in payloads."""
LONGEST = 64
"""Maximum number of characters of a realm or client name."""

_CHUNK = re.compile(rf"[A-Za-z0-9._-]{{1,{LONGEST}}}")


def check_chunk(text: str) -> str:
    """Return a realm or client name as part of a key.

    Raises:
        ValueError: the text cannot be one segment of a key expression; the message contains the rule.
    """
    if not _CHUNK.fullmatch(text):
        raise ValueError(f"{text!r} cannot be part of a key: use 1 to 64 letters, digits, '.', '_' or '-'")
    return text


def hello(realm: str) -> str:
    return f"{ROOT}/{realm}/hello"


def alive(realm: str) -> str:
    return f"{ROOT}/{realm}/alive"


def status(realm: str) -> str:
    return f"{ROOT}/{realm}/status"


def health(realm: str) -> str:
    return f"{ROOT}/{realm}/health"


def metrics(realm: str) -> str:
    return f"{ROOT}/{realm}/metrics"


def realm_of(key: str) -> str:
    """Return the realm in any of these keys."""
    return key.split("/", 2)[1]


def client(realm: str, client: str = "*") -> str:
    return f"{ROOT}/{realm}/client/{client}"


def call(realm: str, client: str = "*") -> str:
    return f"{ROOT}/{realm}/call/{client}"


def reply(realm: str, client: str) -> str:
    return f"{ROOT}/{realm}/reply/{client}"


def stream(realm: str, client: str) -> str:
    return f"{ROOT}/{realm}/stream/{client}"


def image(realm: str, client: str, call_id: int | str = "*") -> str:
    return f"{ROOT}/{realm}/picture/{client}/{call_id}"
