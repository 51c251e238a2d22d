"""The parts of HTTP that both pages for browsers need: the web viewer and the class."""

from __future__ import annotations

import asyncio
from collections import Counter
from collections.abc import Mapping

SLOW = 10.0
"""Seconds for the rest of a request, and for a browser to take an answer."""


def cookie_of(header: str, name: str) -> str:
    """Return a cookie's value; empty without it.

    Cookies of one host are for all its ports, so other programs' come too, in any form. Python's ``SimpleCookie`` then
    reads none.

    Args:
        header: the value of the header ``Cookie``.
        name: the cookie's name.
    """
    for pair in header.split(";"):
        key, _, value = pair.partition("=")
        if key.strip() == name:
            return value.strip()
    return ""


def is_of_another_page(headers: Mapping[str, str], *, in_frames: bool = False) -> bool:
    """Return whether a page of another site or of another port has the browser send a request, without its user.

    The user may follow a link from anywhere. Browsers tell so (``Sec-Fetch-Site``) to encrypted pages and to those of
    the host they run on; other programs do not, and count as the user.

    Args:
        headers: of the request, names in lower case.
        in_frames: another page of the same host may show this one in a frame, as notebooks do.
    """
    site = headers.get("sec-fetch-site", "none")
    if site in ("same-origin", "none"):
        return False
    place = headers.get("sec-fetch-dest")
    if place == "document":
        return headers.get("sec-fetch-mode", "navigate") != "navigate"
    return not (in_frames and site == "same-site" and place in ("iframe", "frame"))


async def end_connection(writer: asyncio.StreamWriter) -> None:
    """Close a connection, also one whose other end does not take what is left; it would stay open for ever."""
    writer.close()
    try:
        async with asyncio.timeout(SLOW):
            await writer.wait_closed()
    except (OSError, TimeoutError):
        writer.transport.abort()


class Places:
    """The connections of a page; when there are many, those that have been without a whole request for longest go."""

    def __init__(self) -> None:
        """Start without connections."""
        self._waiting: dict[asyncio.StreamWriter, None] = {}
        """Connections without a whole request at present, those that wait longest first."""

        self._addresses: dict[asyncio.StreamWriter, str] = {}
        """The other machine of each connection."""

        self._by_address: Counter[str] = Counter()

    def __len__(self) -> int:
        return len(self._addresses)

    def enter(self, writer: asyncio.StreamWriter, *, many: int, most: int, most_of_one: int) -> bool:
        """Give a place to a new connection, which has no request yet; return False if there is none.

        Args:
            many: connections from which those without a request go.
            most: connections that may have one.
            most_of_one: connections from one other machine.
        """
        address: str = (writer.get_extra_info("peername") or ("",))[0]
        is_here = is_this_machine(address)
        if not is_here and self._by_address[address] >= most_of_one:
            self._close_longest(address)
        elif len(self) >= many:
            self._close_longest()
        if len(self) >= most or (not is_here and self._by_address[address] >= most_of_one):
            return False
        self._addresses[writer] = address
        self._by_address[address] += 1
        self._waiting[writer] = None
        return True

    def has_request(self, writer: asyncio.StreamWriter) -> None:
        """Keep a connection while its request is answered."""
        self._waiting.pop(writer, None)

    def waits(self, writer: asyncio.StreamWriter) -> None:
        """Count a connection that was answered as one without a request, from now on."""
        if writer in self._addresses:
            self._waiting[writer] = None

    def leave(self, writer: asyncio.StreamWriter) -> None:
        """Free the place of a connection that is closed, if it has one."""
        self._waiting.pop(writer, None)
        address = self._addresses.pop(writer, None)
        if address is not None:
            self._by_address[address] -= 1
            if not self._by_address[address]:
                del self._by_address[address]

    def _close_longest(self, address: str | None = None) -> None:
        for writer in self._waiting:
            if address is None or self._addresses[writer] == address:
                self.leave(writer)
                writer.transport.abort()
                return


def is_this_machine(address: str) -> bool:
    """Return whether a connection's other end is on this machine."""
    return address in ("127.0.0.1", "::1")
