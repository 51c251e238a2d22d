"""The link back to one client: it takes values, and each gateway gives them the form of its protocol."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from simx_client.protocol.codec import encode
from simx_client.protocol.messages import Delivery

if TYPE_CHECKING:
    from .streams import NewestValues


class Link:
    """A link that sends nothing. Any thread, except `publish`; no method blocks for long, or changes what it gets."""

    copies_positions: ClassVar[bool] = False
    """The client's streams of joint positions are read from a copy, see `positions.py`."""

    keeps_positions: ClassVar[bool] = True
    """The copy is read after `publish`; otherwise the joints' numbers themselves serve."""

    def deliver(self, delivery: Delivery) -> None:
        """Send replies; every one arrives, in order."""

    def publish(self, values: NewestValues) -> None:
        """Send the newest values of all small streams; a slow client may miss some. Physics thread."""

    def publish_image(self, stream_id: int, delivery: Delivery, *, in_order: bool) -> None:
        """Send the newest image of one stream; a slow client may miss some.

        Args:
            in_order: the client steps: it must have the image when it gets the replies that are sent later.
        """

    def close(self) -> None:
        """Send nothing any more."""


class PackingLink(Link):
    """A link that takes messages of this project's own protocol as bytes."""

    copies_positions, keeps_positions = True, False

    def deliver(self, delivery: Delivery) -> None:
        self.put_replies(encode(delivery))

    def publish(self, values: NewestValues) -> None:
        if payload := values.packed():
            self.put_values(payload)

    def publish_image(self, stream_id: int, delivery: Delivery, *, in_order: bool) -> None:
        self.put_image(stream_id, encode(delivery))

    def put_replies(self, payload: bytes) -> None:
        """Send a message of `deliver`."""
        raise NotImplementedError

    def put_values(self, payload: bytes) -> None:
        """Send a message of `publish`."""
        raise NotImplementedError

    def put_image(self, stream_id: int, payload: bytes) -> None:
        """Send a message of `publish_image`."""
        raise NotImplementedError
