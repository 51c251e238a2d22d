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
from .hashes import HASHES
from .layouts import read_layouts
from .types import MessageType, ServiceType, dds_name

HUMBLE_HASH = "TypeHashNotSupported"
"""Stands in keys of ROS 2 Humble in place of a hash."""


class Types(NamedTuple):
    """All types of a distribution, by name."""

    messages: Mapping[str, MessageType]
    services: Mapping[str, ServiceType]


def _make(*, humble: bool) -> Types:
    encoders, decoders = Encoders(), Decoders()
    messages: dict[str, MessageType] = {}
    services: dict[str, ServiceType] = {}
    parts: dict[str, MessageType] = {}
    for name, layout in read_layouts(humble=humble).items():
        service = name.removesuffix("_Request").removesuffix("_Response")
        hash_ = HUMBLE_HASH if humble else f"RIHS01_{HASHES[service]}"
        made = MessageType(layout, hash_, encoders, decoders)
        (messages if service == name else parts)[name] = made
        if name.endswith("_Response"):
            services[service] = ServiceType(
                service, dds_name(service), hash_, parts[f"{service}_Request"], made
            )
    return Types(MappingProxyType(messages), MappingProxyType(services))


@cache
def humble() -> Types:
    """Return the types of ROS 2 Humble: another Range, and no hashes."""
    return _make(humble=True)


BY_NAME, SERVICES = _make(humble=False)

__all__ = (
    "BY_NAME",
    "HUMBLE_HASH",
    "SERVICES",
    "MessageError",
    "MessageType",
    "ServiceType",
    "Types",
    "humble",
)
