"""The interface between a connection and the outside: the contract of all ways to a server.

`lanes.py` chooses between Zenoh and the lane of one host; the server's package has the transport of an embedded
simulation, see `direct.py`, and one for tests.
"""

from __future__ import annotations

import math
from typing import Protocol

from simx_client.protocol.messages import Welcome


class Transport(Protocol):
    """Messages to and from one server. A connection uses it under its lock."""

    @property
    def is_connected(self) -> bool:
        """Return whether a server is available."""
        ...

    @property
    def was_lost(self) -> bool:
        """Return whether the server was lost since the last greeting, even if another is available already."""
        ...

    def greet(self, timeout: float) -> Welcome:
        """Greet the server, or greet it again after it came back.

        Raises:
            ConnectionFailed: no server answered in time, or it refused.
        """
        ...

    def send(self, payload: bytes, deadline: float = math.inf) -> None:
        """Send a batch; batches arrive in order.

        While the receiver's queue is full this waits, until a deadline on the monotonic clock. A payload not
        sent by then is sent later, when the queue has room.
        """
        ...

    def receive(self, timeout: float, *, is_soon: bool = False) -> bytes | None:
        """Return the next delivery, waiting at most ``timeout`` seconds; None without one.

        Returns early with None when the server is lost.

        Args:
            is_soon: the delivery should take no longer than a round trip.
        """
        ...

    def is_still(self) -> bool:
        """Return whether the server is there and everything that it has sent was taken, if this is known at once.

        Then `receive`, `newest` and `images` have nothing.
        """
        ...

    def newest(self) -> bytes | None:
        """Return the newest values of the small streams; None if they were taken already."""
        ...

    def images(self) -> list[bytes]:
        """Return the newest image of each image stream, without those taken already."""
        ...

    def close(self) -> None:
        """Close the connection. Idempotent."""
        ...
