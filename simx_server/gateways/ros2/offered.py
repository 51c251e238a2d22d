"""The offers of the present scene, each with its endpoint. Physics thread."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING

from simx_server import ros2_messages as messages
from simx_server.errors import CommandError

from .desk import Desk, Intake, Outlet
from .endpoints import Commanded, Followed, Offer, Published, Served
from .wire.endpoint import Endpoint
from .wire.names import Distribution, Place
from .wire.publisher import Publisher
from .wire.service import Service
from .wire.subscription import Guard, Subscription

if TYPE_CHECKING:
    from .client import Ros2Client

Name = tuple[object, ...]
"""Kind, name, type and QoS of an offer: a later one with the same keeps the endpoint."""


class Offered:
    """Everything that the node offers at present, apart from topics and services of scripts."""

    def __init__(
        self,
        place: Place,
        distribution: Distribution,
        types: messages.Types,
        client: Ros2Client,
        guard: Guard,
        send_later: Callable[[Callable[[], object], int], object],
    ) -> None:
        """Offer nothing yet.

        Args:
            types: those of the distribution.
            guard: judges what arrives.
            send_later: sends an answer of this many bytes, on another thread if it may take long.
        """
        self._place, self._distribution, self._types = place, distribution, types
        self._client, self._guard, self._send_later = client, guard, send_later
        self._known: dict[Name, Outlet | Intake | Desk] = {}
        self.outlets: Sequence[Outlet] = ()
        self.desks: Sequence[Desk] = ()
        self.followed: Sequence[Followed] = ()

    def replace(self, offers: Iterable[Offer]) -> bool:
        """Offer this from now on, with the endpoints that were there before; return whether the endpoints changed."""
        before, self._known, followed = self._known, {}, list[Followed]()
        for offer in offers:
            if isinstance(offer, Followed):
                followed.append(offer)
            else:
                self._add(offer, before)
        self.outlets = [each for each in self._known.values() if isinstance(each, Outlet)]
        self.desks = [each for each in self._known.values() if isinstance(each, Desk)]
        self.followed = followed
        return before.keys() != self._known.keys()

    def endpoints(self) -> list[Endpoint]:
        """Return the endpoints of all offers."""
        return [each.endpoint for each in self._known.values()]

    def _add(self, offer: Published | Commanded | Served, before: dict[Name, Outlet | Intake | Desk]) -> None:
        match offer:
            case Published(topic, kind, _, qos):
                name = (Published, topic, kind, qos)
            case Commanded(topic, kind, _, qos, is_listed):
                name = (Commanded, topic, kind, qos, is_listed)
            case Served(topic, kind):
                name = (Served, topic, kind)
        if name in self._known:
            problem = "two objects have it; the first one keeps it: give the other a different name in its annotation"
            self._client.failed(self._place.full(topic), CommandError(problem))
            return
        made = before.get(name)
        match offer:
            case Published():
                made = made if isinstance(made, Outlet) else self._outlet(offer)
                made.offer = offer
            case Commanded():
                made = made if isinstance(made, Intake) else self._intake(offer)
                made.offer = offer
            case Served():
                made = made if isinstance(made, Desk) else self._desk(offer)
                made.offer = offer
        self._known[name] = made

    def _outlet(self, offer: Published) -> Outlet:
        type_, described = self._types.messages[offer.type], messages.BY_NAME[offer.type]
        full_name = self._place.full(offer.topic)
        publisher = Publisher(self._place, full_name, described, offer.qos, self._distribution)
        return Outlet(offer, publisher, type_, self._client)

    def _intake(self, offer: Commanded) -> Intake:
        def arrived(_: Subscription) -> None:
            self._client.post(intake.serve)

        subscription = Subscription(
            self._place,
            self._place.full(offer.topic),
            messages.BY_NAME[offer.type],
            offer.qos,
            self._distribution,
            is_listed=offer.is_listed,
            guard=self._guard,
            arrived=arrived,
        )
        intake = Intake(offer, subscription, self._types.messages[offer.type], self._client)
        return intake

    def _desk(self, offer: Served) -> Desk:
        type_ = self._types.services[offer.type]

        def arrived(_: Service) -> None:
            self._client.post(desk.serve, desk.wants_stop)

        def refusal(why: str) -> bytes:
            return type_.response.encode(desk.offer.refusal(why))

        service = Service(
            self._place,
            self._place.full(offer.service),
            messages.SERVICES[offer.type],
            self._distribution,
            guard=self._guard,
            arrived=arrived,
            refusal=refusal,
            send_later=self._send_later,
        )
        desk = Desk(offer, service, type_, self._client)
        return desk
