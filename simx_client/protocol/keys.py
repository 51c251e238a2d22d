"""The Zenoh key expressions. ``realm`` names a simulator, ``client`` one connection to it.

simx/<realm>/hello            queryable: greeting in, welcome out
simx/<realm>/alive            liveliness token of the server
simx/<realm>/status           queryable: what the server does and how loaded it is
simx/<realm>/health           queryable, JSON: whether it works
simx/<realm>/metrics          queryable, JSON: all that it counts
simx/<realm>/client/<client>  liveliness token of a client
simx/<realm>/call/<client>    batches of calls, client to server
simx/<realm>/reply/<client>   deliveries, every one arrives
simx/<realm>/stream/<client>  the newest values of all small streams of a client, of one instant
simx/<realm>/picture/<client>/<call id>   the newest picture of one stream
"""

from __future__ import annotations

import re

ROOT = "simx"
ANY_HELLO = f"{ROOT}/*/hello"
ANY_ALIVE = f"{ROOT}/*/alive"
VIEWER = "viewer-"
"""Clients whose name begins so may only read. The name is part of every key, so access rules of Zenoh can hold a user
to it, although the commands themselves are in payloads, which such rules do not see."""
LONGEST = 64
"""Characters of a realm or client name."""

_CHUNK = re.compile(rf"[A-Za-z0-9._-]{{1,{LONGEST}}}")


def check_chunk(text: str) -> str:
    """A realm or client name as part of a key.

    Raises:
        ValueError: with the rule, when the text could not be one segment of a key expression.
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
    """The realm in any of these keys."""
    return key.split("/", 2)[1]


def client(realm: str, client: str = "*") -> str:
    return f"{ROOT}/{realm}/client/{client}"


def call(realm: str, client: str = "*") -> str:
    return f"{ROOT}/{realm}/call/{client}"


def reply(realm: str, client: str) -> str:
    return f"{ROOT}/{realm}/reply/{client}"


def stream(realm: str, client: str) -> str:
    return f"{ROOT}/{realm}/stream/{client}"


def picture(realm: str, client: str, call_id: int | str = "*") -> str:
    return f"{ROOT}/{realm}/picture/{client}/{call_id}"
