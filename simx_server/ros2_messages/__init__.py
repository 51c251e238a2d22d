"""ROS 2's messages and services that the server knows: their layouts, hashes and CDR bytes.

`BY_NAME` and `SERVICES` hold the types as ROS 2 Iron and later have them; `humble()` those of Humble.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from types import MappingProxyType
from typing import NamedTuple

from .decoding import Decoders
from .encoding import Encoders
from .errors import MessageError
from .hashes import HASHES, OLDER_HASHES
from .layouts import read_layouts
from .types import MessageType, ServiceType, dds_name

HUMBLE_HASH = "TypeHashNotSupported"
"""Stands in keys of ROS 2 Humble in place of a hash."""


class Types(NamedTuple):
    """All types of a distribution, by name."""

    messages: Mapping[str, MessageType]
    services: Mapping[str, ServiceType]


def _make(*, humble: bool = False, older: bool = False) -> Types:
    encoders, decoders = Encoders(), Decoders()
    messages: dict[str, MessageType] = {}
    services: dict[str, ServiceType] = {}
    parts: dict[str, MessageType] = {}
    hashes = {**HASHES, **OLDER_HASHES} if older else HASHES
    for name, layout in read_layouts(humble=humble, older=older).items():
        service = name.removesuffix("_Request").removesuffix("_Response")
        if service not in hashes:
            continue  # a part of an action, which is sent within other messages only
        hash_ = HUMBLE_HASH if humble else f"RIHS01_{hashes[service]}"
        made = MessageType(layout, hash_, encoders, decoders)
        (messages if service == name else parts)[name] = made
        if name.endswith("_Response"):
            services[service] = ServiceType(
                service, dds_name(service), hash_, parts[f"{service}_Request"], made
            )
    return Types(MappingProxyType(messages), MappingProxyType(services))


@cache
def humble() -> Types:
    """Return the types of ROS 2 Humble: those of earlier releases, another Range, and no hashes."""
    return _make(humble=True)


@cache
def older() -> Types:
    """Return the types as earlier releases of their packages have them, where these differ."""
    return _make(older=True)


BY_NAME, SERVICES = _make()

__all__ = (
    "BY_NAME",
    "HUMBLE_HASH",
    "SERVICES",
    "MessageError",
    "MessageType",
    "ServiceType",
    "Types",
    "humble",
    "older",
)
