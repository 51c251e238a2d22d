"""The node of the gateway, which makes endpoints: those of the scene's offers, and those of scripts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from simx_server import ros2_messages as messages

from .wire.names import Distribution, Place
from .wire.publisher import Publisher
from .wire.qos import Qos
from .wire.service import Service
from .wire.service_client import ServiceClient
from .wire.subscription import Guard, Subscription

if TYPE_CHECKING:
    from .client import Ros2Client


@dataclass(frozen=True)
class Node:
    """A node; names of endpoints are full, and types are named as in `pkg/msg/Type`. Physics thread."""

    place: Place
    distribution: Distribution
    types: messages.Types
    """The types of the distribution."""

    client: Ros2Client
    guard: Guard
    """Judges what arrives."""

    send_later: Callable[[Callable[[], object], int], object]
    """Sends an answer of this many bytes, on another thread if it may take long."""

    def publisher(self, name: str, kind: str, qos: Qos) -> Publisher:
        """Make the publisher of a topic."""
        return Publisher(self.place, name, messages.BY_NAME[kind], qos, self.distribution)

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
            messages.BY_NAME[kind],
            qos,
            self.distribution,
            is_listed=is_listed,
            guard=self.guard,
            arrived=arrived,
        )

    def service(
        self, name: str, kind: str, arrived: Callable[[Service], object], refusal: Callable[[str], bytes]
    ) -> Service:
        """Make the server of a service; `arrived` is called on Zenoh's threads, `refusal` encodes a reason."""
        return Service(
            self.place,
            name,
            messages.SERVICES[kind],
            self.distribution,
            guard=self.guard,
            arrived=arrived,
            refusal=refusal,
            send_later=self.send_later,
        )

    def service_client(self, name: str, kind: str) -> ServiceClient:
        """Make the client of a service."""
        return ServiceClient(self.place, name, messages.SERVICES[kind], self.distribution)
