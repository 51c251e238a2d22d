"""The types that a server knows, as each distribution of ROS 2 has them."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property, partial
from types import MappingProxyType
from typing import NamedTuple

from .built_in import read_layouts
from .decoding import Decoders
from .encoding import Encoders
from .hashing import TypeHashes
from .layouts import Layout
from .own import add_own
from .types import MessageType, ServiceType, dds_name

HUMBLE_HASH = "TypeHashNotSupported"
"""Stands in keys of ROS 2 Humble in place of a hash."""

_WITHIN = ("_Goal", "_Result", "_Feedback")
"""Parts of an action, which are sent within other messages only."""


class Types(NamedTuple):
    """All types of a distribution, by name."""

    messages: Mapping[str, MessageType]
    services: Mapping[str, ServiceType]


class KnownTypes:
    """The server's types, with those of the user's packages."""

    def __init__(self, own: Mapping[str, str] = MappingProxyType({})) -> None:
        """Read the definitions.

        Args:
            own: texts of the user's definitions, by name, as `read_packages` returns them.

        Raises:
            DefinitionError: one of them cannot be used.
        """
        self.own = own
        self.newer = self._make(read_layouts())
        """As ROS 2 Iron and later have them."""

    @cached_property
    def humble(self) -> Types:
        """Return the types of ROS 2 Humble: those of earlier releases, another Range, and no hashes."""
        return self._make(read_layouts(humble=True), has_hashes=False)

    @cached_property
    def older(self) -> Types:
        """Return the types as earlier releases of their packages have them, where these differ."""
        return self._make(read_layouts(older=True))

    def _make(self, built_in: Mapping[str, Layout], *, has_hashes: bool = True) -> Types:
        layouts = add_own(self.own, built_in) if self.own else built_in
        hashes = TypeHashes(layouts)
        encoders, decoders = Encoders(), Decoders()

        def made(name: str, hashed: str) -> MessageType:
            hash_of = partial(hashes.of, hashed) if has_hashes else lambda: HUMBLE_HASH
            return MessageType(layouts[name], hash_of, encoders, decoders)

        messages: dict[str, MessageType] = {}
        services: dict[str, ServiceType] = {}
        for name in layouts:
            if name.endswith("_Response"):
                service = name.removesuffix("_Response")
                parts = (made(f"{service}_{end}", service) for end in ("Request", "Response"))
                services[service] = ServiceType(service, dds_name(service), *parts)
            elif not name.endswith(("_Request", *_WITHIN)):
                messages[name] = made(name, name)
        return Types(MappingProxyType(messages), MappingProxyType(services))


BUILT_IN = KnownTypes()
BY_NAME, SERVICES = BUILT_IN.newer


def known_types(own: Mapping[str, str]) -> KnownTypes:
    """Return the server's types with those of the user's packages. Raises as `KnownTypes`."""
    return KnownTypes(own) if own else BUILT_IN
