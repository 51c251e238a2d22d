"""Find endpoints that are open to strangers: reachable from other machines, without a login or certificates."""

from __future__ import annotations

import ipaddress
import json
import re
from collections.abc import Sequence
from typing import Any

_ENCRYPTED = ("tls", "quic")
_NETWORK = (*_ENCRYPTED, "tcp", "udp", "ws")
"""Zenoh protocols that other machines can use; the rest are sockets, pipes and cables of this machine."""


def exposure(endpoints: Sequence[str], config: Any) -> str | None:
    """Return a warning about endpoints that are open to everyone, with the next step; None if there are none.

    Args:
        endpoints: the endpoints to listen on, ``PROTOCOL/ADDRESS``.
        config: a Zenoh configuration.
    """
    if _has_login(config):
        return None
    has_certificates = json.loads(config.get_json("transport/link/tls/enable_mtls")) is True
    open_ones = [
        endpoint
        for endpoint in endpoints
        if is_beyond_loopback(endpoint) and not (has_certificates and endpoint.startswith(_ENCRYPTED))
    ]
    if not open_ones:
        return None
    return (
        f"whoever reaches {', '.join(open_ones)} can do everything a client can, unasked: nothing there wants a "
        "password or a certificate; give --config FILE with a login or mutual TLS "
        "(recipes: docs/operators/security.md), or leave --listen away"
    )


def plain_exposure(addresses: Sequence[str]) -> str | None:
    """Return the same warning for a protocol that has neither passwords nor certificates.

    Args:
        addresses: ``HOST:PORT`` each.
    """
    open_ones = [address for address in addresses if is_beyond_loopback(f"tcp/{address}")]
    if not open_ones:
        return None
    return (
        f"whoever reaches {', '.join(open_ones)} can do everything a client can, unasked: the original's protocol "
        "has no passwords and no encryption; leave the host away to listen on this machine alone, and reach it "
        "through an SSH tunnel or a VPN (recipes: docs/operators/security.md)"
    )


def _has_login(config: Any) -> bool:
    """Return whether every endpoint requires a user and password, or a known public key."""
    return any(
        json.loads(config.get_json(path)) is not None
        for path in ("transport/auth/usrpwd/dictionary_file", "transport/auth/pubkey/known_keys_file")
    )


def is_beyond_loopback(endpoint: str) -> bool:
    """Return whether other machines can reach a Zenoh endpoint."""
    protocol, _, address = endpoint.partition("/")
    if protocol not in _NETWORK:
        return False
    return not is_loopback(re.split(r"[?#]", address)[0].rpartition(":")[0].strip("[]"))


def is_loopback(host: str) -> bool:
    """Return whether a host can be reached from this machine only; names other than localhost count as others."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False  # a host name, or an interface
