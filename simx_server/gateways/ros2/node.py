"""The node of the gateway, which makes endpoints: those of the scene's offers, and those of scripts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from .wire.names import NO_HASH, Distribution, Place
from .wire.publisher import Publisher
from .wire.qos import Qos
from .wire.service import Service
from .wire.service_client import ServiceClient
from .wire.subscription import Guard, Subscription

if TYPE_CHECKING:
    from simx_server.ros2_messages import KnownTypes, Types

    from .client import Ros2Client


@dataclass(frozen=True)
class Node:
    """A node; names of endpoints are full, and types are named as in `pkg/msg/Type`. Physics thread."""

    place: Place
    distribution: Distribution
    known: KnownTypes
    client: Ros2Client
    guard: Guard
    """Judges what arrives."""

    send_later: Callable[[Callable[[], object], int], object]
    """Sends an answer of this many bytes, on another thread if it may take long."""

    @property
    def types(self) -> Types:
        """Return the types of the distribution."""
        return self.known.humble if self.distribution is Distribution.HUMBLE else self.known.newer

    def types_of(self, *, is_older: bool) -> Types:
        """Return the types of the distribution, or those that earlier releases of their packages have."""
        return self.known.older if is_older else self.types

    def publisher(self, name: str, kind: str, qos: Qos, *, is_older: bool = False) -> Publisher:
        """Make the publisher of a topic; see `Published.is_older`."""
        made = Publisher(
            self.place, name, self.types_of(is_older=is_older).messages[kind], qos, self.distribution
        )
        made.is_listed = not is_older
        return made

    def subscription(
        self,
        name: str,
        kind: str,
        qos: Qos,
        arrived: Callable[[Subscription], object],
        *,
        is_listed: bool = True,
    ) -> Subscription:
        """Make the subscription of a topic; `arrived` is called on Zenoh's threads."""
        return Subscription(
            self.place,
            name,
            self.known.newer.messages[kind],
            qos,
            self.distribution,
            is_listed=is_listed,
            guard=self.guard,
            arrived=arrived,
        )

    def service(
        self,
        name: str,
        kind: str,
        arrived: Callable[[Service], object],
        refusal: Callable[[str], bytes],
        *,
        is_older: bool = False,
    ) -> Service:
        """Make the server of a service; `arrived` is called on Zenoh's threads, `refusal` encodes a reason."""
        made = Service(
            self.place,
            name,
            self.types_of(is_older=is_older).services[kind],
            self.distribution,
            guard=self.guard,
            arrived=arrived,
            refusal=refusal,
            send_later=self.send_later,
        )
        made.is_listed = not is_older
        newer, older = (types.services[kind].hash for types in (self.known.newer, self.known.older))
        if newer != older and self.distribution is Distribution.NEWER:
            # Requests of Humble, which have no hash, are those of the earlier release.
            made.elsewhere = (newer,) if is_older else (older, NO_HASH)
        return made

    def service_client(self, name: str, kind: str) -> ServiceClient:
        """Make the client of a service."""
        return ServiceClient(self.place, name, self.known.newer.services[kind], self.distribution)
