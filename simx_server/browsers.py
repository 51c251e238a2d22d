"""The parts of HTTP that both pages for browsers need: the web viewer and the class."""

from __future__ import annotations

import asyncio

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


async def end_connection(writer: asyncio.StreamWriter) -> None:
    """Close a connection, also one whose other end does not take what is left; it would stay open for ever."""
    writer.close()
    try:
        async with asyncio.timeout(SLOW):
            await writer.wait_closed()
    except (OSError, TimeoutError):
        writer.transport.abort()
