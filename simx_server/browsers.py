"""The parts of HTTP that both pages for browsers need: the web viewer and the class."""

from __future__ import annotations

import asyncio
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
