"""Open a client's Zenoh sessions with the user's configuration; report the reason when that fails.

``SIMX_CONFIG`` names a Zenoh configuration file with certificates, user and password. The script and
``SIMX_CONNECT`` say where a session goes, never the file. ``SIMX_LOGIN`` is ``USER:PASSWORD``, for servers that
need nothing else of such a file. With ``SIMX_ROLE=viewer`` a client may only read.
"""

from __future__ import annotations

import math
import os
import re
import socket
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from simx_client.errors import ConnectionFailed
from simx_client.protocol.zenoh import keys, link

SEEN_AGAIN = 0.1
"""Seconds until an empty list of servers is believed: tokens of a router's neighbours may be on the way, and
a busy Zenoh 1.10 omits tokens in one answer of fifty."""

_LEAST_ANSWER = 0.01
"""Minimum time-out of an answer in seconds, after the deadline too."""

CONFIG_VARIABLE = "SIMX_CONFIG"
LOGIN_VARIABLE = "SIMX_LOGIN"
"""User and password as ``USER:PASSWORD``; they replace those of the file."""

ROLE_VARIABLE = "SIMX_ROLE"

_KNOCK = bytes([0x01, 0x09, 0xF2]) + os.urandom(16)
"""First message of a Zenoh session: INIT of protocol version 9, of a client with an identifier of 16 bytes.
"""

_INIT, _CLOSE = 0x01, 0x03
"""Kinds of Zenoh's answers to it, in the lower five bits: continue, or close."""

_KNOCK_TIMEOUT = 0.5
"""Time-out in seconds."""


_NO_SHARED_MEMORY = "shm segment"
"""Part of Zenoh's error where this user may make no shared memory, or none is left: in some containers and jails."""


class Unanswered(OSError):
    """A port accepts connections and sends nothing in time."""


def open_session(zenoh: Any, options: Mapping[str, Any], defaults: Mapping[str, Any]) -> Any:
    """Open a session with these options. `defaults` apply where the user's file sets no value.

    Shared memory makes large images faster. On a machine without it the session opens without it.

    Raises:
        zenoh.ZError: no session could be opened.
        ConnectionFailed: the file of ``SIMX_CONFIG`` or the text of ``SIMX_LOGIN`` cannot be used.
    """
    try:
        return zenoh.open(_configuration(zenoh, options, defaults))
    except zenoh.ZError as error:
        if _NO_SHARED_MEMORY not in str(error):
            raise
    without = {**options, "transport/shared_memory/enabled": False}
    return zenoh.open(_configuration(zenoh, without, defaults))


def _configuration(zenoh: Any, options: Mapping[str, Any], defaults: Mapping[str, Any]) -> Any:
    options = {**options, **_login()}
    file = config_file()
    if file is None:
        return link.configure(zenoh.Config(), {**defaults, **options})
    try:
        config = link.configured_by(zenoh, file, defaults)
    except zenoh.ZError as error:
        raise ConnectionFailed(
            f"{CONFIG_VARIABLE}: {file} is no Zenoh configuration: {link.reason(error)}"
        ) from None
    # With a file made for a server every client would listen.
    return link.configure(config, {**options, "listen/endpoints": []})


def config_file() -> Path | None:
    """Return the file that ``SIMX_CONFIG`` names, None if it is not set. Raises ConnectionFailed for a
    missing file."""
    text = os.environ.get(CONFIG_VARIABLE, "").strip()
    if not text:
        return None
    path = Path(text).expanduser()
    if not path.is_file():
        raise ConnectionFailed(
            f"{CONFIG_VARIABLE}: {text!r} is no existing file; it is to name one of Zenoh settings"
        )
    return path


def _login() -> dict[str, str]:
    """Return Zenoh's options for the login of ``SIMX_LOGIN``. Raises ConnectionFailed for an unreadable text."""
    text = os.environ.get(LOGIN_VARIABLE, "").strip()
    if not text:
        return {}
    user, colon, password = text.partition(":")
    if not (user and colon and password):
        raise ConnectionFailed(
            f"{LOGIN_VARIABLE}: the text is not USER:PASSWORD, as in seat-07:0Jq2c1; copy the whole line again"
        )
    return {"transport/auth/usrpwd/user": user, "transport/auth/usrpwd/password": password}


def client_role() -> str:
    """Return the first part of a new client's name, which tells the server its role. Raises ConnectionFailed for
    an unknown role."""
    role = os.environ.get(ROLE_VARIABLE, "").strip()
    if role not in ("", "viewer"):
        raise ConnectionFailed(
            f"{ROLE_VARIABLE}: there is no role {role!r}; valid: viewer, or not set at all"
        )
    return keys.VIEWER if role else ""


def client_name() -> str:
    """Return the name of a new client that has no Zenoh session. Raises ConnectionFailed for an unknown role."""
    return client_role() + os.urandom(16).hex()


def program_name() -> str:
    """Return the name by which servers call a client of this process."""
    return f"{os.path.basename(sys.argv[0] or 'python')} (pid {os.getpid()})"


def living_realms(session: Any, deadline: float) -> list[str]:
    """Return the realms of all live servers that this session's neighbour knows.

    Args:
        deadline: on the monotonic clock; an empty list is returned after `SEEN_AGAIN` seconds.
    """
    until = min(deadline, time.monotonic() + SEEN_AGAIN)
    while True:
        left = max(_LEAST_ANSWER, deadline - time.monotonic())
        tokens = session.liveliness().get(keys.ANY_ALIVE, timeout=left)
        realms = {keys.realm_of(str(token.ok.key_expr)) for token in tokens if token.ok is not None}
        if realms or time.monotonic() >= until:
            return sorted(realms)
        time.sleep(0.01)


def why_closed(address: str, port: int, is_secret: bool = False, deadline: float = math.inf) -> str | None:
    """Return who listens at a port at which no session could be opened, and why it may have refused.

    Args:
        is_secret: the endpoint uses TLS.
        deadline: on the monotonic clock; the examination may exceed it slightly.

    Returns:
        Half a sentence; None if something listens that does not speak Zenoh.

    Raises:
        Unanswered: something accepts connections and sends nothing.
        OSError: nothing can be reached.
    """

    def for_half() -> float:
        return min(_KNOCK_TIMEOUT, max(0.01, (deadline - time.monotonic()) / 2))

    with socket.create_connection((address, port), timeout=for_half()) as knocking:
        if is_secret:
            return f"refused TLS or the login; {_what_to_check()}"
        knocking.settimeout(for_half())
        knocking.sendall(len(_KNOCK).to_bytes(2, "little") + _KNOCK)
        try:
            answer = knocking.recv(16)
        except TimeoutError:
            raise Unanswered from None
        except OSError:
            return None
    if answer[:2] == b"\x15\x03":  # an alert of TLS
        return (
            f"is asked in plain text but wants TLS: SIMX_CONNECT=tls/{address}:{port}, and {_what_to_check()}"
        )
    kind = answer[2] & 0x1F if len(answer) > 2 else None
    if kind == _CLOSE:
        return f"speaks Zenoh but refused the login; {_what_to_check()}"
    if (
        kind == _INIT
    ):  # it would accept a client without login, so the given login is the reason, or it has just started
        return (
            "speaks Zenoh, wants no login and did not let this client in; try again, or without "
            f"{CONFIG_VARIABLE} and {LOGIN_VARIABLE}"
        )
    return None


def _what_to_check() -> str:
    file = os.environ.get(CONFIG_VARIABLE, "").strip()
    if os.environ.get(LOGIN_VARIABLE, "").strip():
        return f"check user and password in {LOGIN_VARIABLE}" + (
            f", and certificates in {file}" if file else ""
        )
    if not file:
        return (
            f"{CONFIG_VARIABLE} is not set: it names the Zenoh configuration with user, password and certificates "
            f"({LOGIN_VARIABLE}=USER:PASSWORD is enough where a login alone is required)"
        )
    return f"check user, password and certificates in {file} ({CONFIG_VARIABLE})"


def host_and_port(endpoint: str) -> tuple[str, int] | None:
    """Return host and port of a Zenoh endpoint over TCP; None for other endpoints."""
    match = re.match(r"(?:tcp|tls)/\[?([^\]?#]+?)\]?:(\d+)(?:[?#]|$)", endpoint)
    return (match[1], int(match[2])) if match else None
