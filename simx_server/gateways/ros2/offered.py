"""The offers of the present scene, each with its endpoint. Physics thread."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from simx_server.errors import CommandError

from .desk import Desk, Intake, Outlet
from .endpoints import Commanded, Followed, Offer, Published, Sent, Served
from .node import Node
from .wire.endpoint import Endpoint
from .wire.service import Service
from .wire.subscription import Subscription

Name = tuple[object, ...]
"""Kind, name, type and QoS of an offer: a later one with the same keeps the endpoint."""


class Offered:
    """Everything that the node offers at present, apart from topics and services of scripts."""

    def __init__(self, node: Node) -> None:
        """Offer nothing yet."""
        self._node, self._client = node, node.client
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

    def _add(
        self, offer: Published | Sent | Commanded | Served, before: dict[Name, Outlet | Intake | Desk]
    ) -> None:
        match offer:
            case Published(topic, kind, _, qos):
                name = (Published, topic, kind, qos, offer.is_older)
            case Sent(topic, kind, _, qos):
                name = (Published, topic, kind, qos, offer.is_older)
            case Commanded(topic, kind, _, qos, is_listed):
                name = (Commanded, topic, kind, qos, is_listed)
            case Served(topic, kind):
                name = (Served, topic, kind, offer.is_older)
        if name in self._known:
            problem = "two objects have it; the first one keeps it: give the other a different name in its annotation"
            self._client.failed(self._node.place.full(topic), CommandError(problem))
            return
        made = before.get(name)
        match offer:
            case Published() | Sent():
                made = made if isinstance(made, Outlet) else self._outlet(offer)
                made.offer = offer
                if isinstance(offer, Sent):
                    offer.sender.outlet = made
            case Commanded():
                made = made if isinstance(made, Intake) else self._intake(offer)
                made.offer = offer
            case Served():
                made = made if isinstance(made, Desk) else self._desk(offer)
                made.offer = offer
        self._known[name] = made

    def _outlet(self, offer: Published | Sent) -> Outlet:
        publisher = self._node.publisher(
            self._node.place.full(offer.topic), offer.type, offer.qos, is_older=offer.is_older
        )
        type_ = self._node.types_of(is_older=offer.is_older).messages[offer.type]
        return Outlet(offer, publisher, type_, self._client)

    def _intake(self, offer: Commanded) -> Intake:
        def arrived(_: Subscription) -> None:
            self._client.post(intake.serve)

        subscription = self._node.subscription(
            self._node.place.full(offer.topic), offer.type, offer.qos, arrived, is_listed=offer.is_listed
        )
        intake = Intake(offer, subscription, self._node.types.messages[offer.type], self._client)
        return intake

    def _desk(self, offer: Served) -> Desk:
        type_ = self._node.types_of(is_older=offer.is_older).services[offer.type]

        def arrived(_: Service) -> None:
            self._client.post(desk.serve, desk.wants_stop)

        def refusal(why: str) -> bytes:
            return type_.response.encode(desk.offer.refusal(why))

        service = self._node.service(
            self._node.place.full(offer.service), offer.type, arrived, refusal, is_older=offer.is_older
        )
        desk = Desk(offer, service, type_, self._client)
        return desk
