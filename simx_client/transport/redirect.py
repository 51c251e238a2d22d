"""Redirect the fixed address in a script without an edit.

Old scripts contain ``'127.0.0.1', 19997``. ``SIMX_REDIRECT`` maps ports to endpoints, for example
``19997=lab-pc:19997 19999=127.0.0.1:40123``; ``*=127.0.0.1:40123`` leads all other ports there, which is what
``simx-run --server`` uses. A redirection counts for every address, except for ``REALM@ROUTER``, which ``*``
leaves alone.
"""

from __future__ import annotations

import os
from collections.abc import Mapping

VARIABLE = "SIMX_REDIRECT"

ANY_PORT = "*"
"""Matches every port without a separate redirection."""


Redirects = Mapping[int | str, tuple[str, int]]
"""Port, or ``*``, to host and port."""


def format_redirects(places: Redirects) -> str:
    """Return the variable's text."""
    return " ".join(f"{asked}={host}:{port}" for asked, (host, port) in places.items())


def read_redirects() -> dict[int | str, tuple[str, int]]:
    """Return the content of the variable; the first of several for one port counts.

    Raises:
        ValueError: the variable cannot be read; the text says what is valid.
    """
    found: dict[int | str, tuple[str, int]] = {}
    for word in os.environ.get(VARIABLE, "").replace(",", " ").split():
        asked, _, place = word.partition("=")
        host, _, target = place.rpartition(":")
        is_port = asked == ANY_PORT or (asked.isascii() and asked.isdecimal())
        if not (is_port and host and target.isascii() and target.isdecimal()):
            raise ValueError(
                f"{VARIABLE}: {word!r} is not PORT=HOST:PORT, as in 19997=127.0.0.1:40123; "
                f"{ANY_PORT} for PORT means all others"
            )
        found.setdefault(asked if asked == ANY_PORT else int(asked), (host, int(target)))
    return found


def redirected(address: str, port: int) -> tuple[str, int]:
    """Return the endpoint to use instead of this address and port: the same without a redirection.

    Raises:
        ValueError: the variable cannot be read; the text says what is valid.
    """
    places = read_redirects()
    others = (address, port) if "@" in address else places.get(ANY_PORT, (address, port))
    return places.get(port, others)
