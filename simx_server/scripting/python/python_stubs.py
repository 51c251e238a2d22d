"""Modules that a script can import and whose functions are refused: libraries import them without need.

``subprocess`` and ``socket`` are imported by many others. In place of the native modules below them are modules with
the same names, whose functions raise PermissionError with a reason. The stubs protect nothing: some interpreters have
the native modules built in, where a script can find them. The kernel's walls refuse what those try.
"""

from __future__ import annotations

import types
from typing import Any, NoReturn

_FUNCTIONS = {
    "_posixsubprocess": "fork_exec",
    "_socket": "CMSG_LEN CMSG_SPACE close dup getaddrinfo getdefaulttimeout gethostbyaddr gethostbyname "
    "gethostbyname_ex gethostname getnameinfo getprotobyname getservbyname getservbyport htonl htons if_indextoname "
    "if_nameindex if_nametoindex inet_aton inet_ntoa inet_ntop inet_pton ntohl ntohs setdefaulttimeout sethostname "
    "socketpair",
}
_REASONS = {"_posixsubprocess": "no other processes", "_socket": "no connections"}

_NUMBERS = {
    "AF_UNSPEC": 0, "AF_UNIX": 1, "AF_INET": 2, "AF_INET6": 10, "AI_PASSIVE": 1, "EAI_NONAME": -2, "INADDR_ANY": 0,
    "IPPROTO_IP": 0, "IPPROTO_TCP": 6, "IPPROTO_UDP": 17, "IPPROTO_IPV6": 41, "IPV6_V6ONLY": 26, "MSG_PEEK": 2,
    "MSG_WAITALL": 256, "MSG_DONTWAIT": 64, "SHUT_RD": 0, "SHUT_WR": 1, "SHUT_RDWR": 2, "SOCK_STREAM": 1,
    "SOCK_DGRAM": 2, "SOCK_RAW": 3, "SOCK_CLOEXEC": 524288, "SOCK_NONBLOCK": 2048, "SOL_SOCKET": 1, "SO_BROADCAST": 6,
    "SO_ERROR": 4, "SO_KEEPALIVE": 9, "SO_RCVBUF": 8, "SO_REUSEADDR": 2, "SO_REUSEPORT": 15, "SO_SNDBUF": 7,
    "SOMAXCONN": 4096, "TCP_NODELAY": 1, "has_ipv6": 1,
}  # fmt: skip
"""Constants of Linux's sockets that programs name most."""


def stubs() -> dict[str, types.ModuleType]:
    """Return the modules by name."""
    found: dict[str, types.ModuleType] = {}
    for name, reason in _REASONS.items():
        found[name] = types.ModuleType(name, f"Without functions in a script: {reason}.")
        for function in _FUNCTIONS[name].split():
            setattr(found[name], function, _refusing(f"{name}.{function}", reason))
    sockets = vars(found["_socket"])
    sockets.update(_NUMBERS, error=OSError, timeout=TimeoutError)
    sockets.update({kind: type(kind, (OSError,), {}) for kind in ("gaierror", "herror")})
    refusing = {"__slots__": (), "__init__": _refusing("sockets", _REASONS["_socket"])}
    sockets["socket"] = sockets["SocketType"] = type("socket", (), refusing)
    return found


def _refusing(name: str, reason: str) -> types.FunctionType:
    def refused(*_arguments: Any, **_named: Any) -> NoReturn:
        raise PermissionError(f"a script may not use {name}: {reason}")

    return refused
