"""Sending a script's hard-wired address elsewhere, without an edit.

Old scripts have ``'127.0.0.1', 19997`` written in them. ``SIMX_REDIRECT`` maps ports to places, for example
``19997=lab-pc:19997 19999=127.0.0.1:40123``; ``simx-run --server`` uses it to reach a server on free ports.
"""

from __future__ import annotations

import os

VARIABLE = "SIMX_REDIRECT"


def format_redirects(places: dict[int, tuple[str, int]]) -> str:
    """The variable's text for a map of port to (host, port)."""
    return " ".join(f"{asked}={host}:{port}" for asked, (host, port) in places.items())


def redirected(address: str, port: int) -> tuple[str, int]:
    """Where to connect instead of this address and port; the same place when nothing is said about it.

    Raises:
        ValueError: the variable cannot be read; says what is valid.
    """
    for word in os.environ.get(VARIABLE, "").replace(",", " ").split():
        asked, _, place = word.partition("=")
        host, _, target = place.rpartition(":")
        if not (asked.isdecimal() and host and target.isdecimal()):
            raise ValueError(f"{VARIABLE}: {word!r} is not PORT=HOST:PORT, as in 19997=127.0.0.1:40123")
        if int(asked) == port:
            return host, int(target)
    return address, port
