"""The transport to a server in another process: Zenoh, and the lane of one host if the server offers it."""

from __future__ import annotations

from simx_client.protocol.messages import Welcome

from .endpoints import ServerAddress
from .handed import HandedLane, handed_socket
from .lane import Lane, open_lane
from .transport import Transport
from .zenoh import ZenohTransport


def open_link(server: ServerAddress, *, connect_timeout: float, retry: bool, asked_port: int) -> Transport:
    """Return the transport to a server: by the socket that this process was given, or else to the address.

    Raises:
        ConnectionFailed: see `ZenohTransport`.
        ValueError: the variable with the socket cannot be read.
    """
    if (door := handed_socket()) is not None:
        return HandedLane(door, asked_port)
    return Lanes(server, connect_timeout=connect_timeout, retry=retry, asked_port=asked_port)


class Lanes:
    """A `Transport` that greets over Zenoh; after that the faster way carries its messages."""

    def __init__(
        self, server: ServerAddress, *, connect_timeout: float, retry: bool, asked_port: int | None = None
    ) -> None:
        """Open a session of Zenoh; see `ZenohTransport`. Raises ConnectionFailed."""
        self._may_use_lane = server.realm is None and server.host_and_port is not None  # not behind a router
        self.lane: Lane | None = None
        """The lane, if it is used since the last greeting."""

        self._was_lost = False
        self._aside: bytes | None = None
        """Values that came over Zenoh and were found by `is_still`."""

        self.zenoh = zenoh = ZenohTransport(
            server,
            connect_timeout=connect_timeout,
            retry=retry,
            asked_port=asked_port,
            lost=self._lose,
        )
        self.send, self.receive = zenoh.send, zenoh.receive

    @property
    def is_connected(self) -> bool:
        return self.zenoh.is_connected

    @property
    def was_lost(self) -> bool:
        return self._was_lost or (self.lane is not None and self.lane.is_broken)

    def greet(self, timeout: float) -> Welcome:
        self._was_lost = False
        welcome = self.zenoh.greet(timeout)
        if self.lane is not None:
            self.lane.close()
        self.lane = open_lane(welcome.local) if self._may_use_lane else None
        self._aside = None
        carrier = self.lane or self.zenoh
        self.send, self.receive = carrier.send, carrier.receive
        return welcome

    def is_still(self) -> bool:
        lane = self.lane
        if lane is None or self._was_lost or self.zenoh.new_images or not lane.is_still():
            return False
        if self._aside is None:
            self._aside = self.zenoh.newest()
        return self._aside is None

    def newest(self) -> bytes | None:
        values = None if self.lane is None else self.lane.newest()
        if values is None:  # where the server finds no memory
            values, self._aside = self._aside, None
        return self.zenoh.newest() if values is None else values

    def images(self) -> list[bytes]:
        images = self.zenoh.images()
        return images if self.lane is None else self.lane.images() + images

    def close(self) -> None:
        if self.lane is not None:
            self.lane.close()
        self.zenoh.close()

    def _lose(self) -> None:
        """Note that the server is lost, and end a wait for the lane; a thread of Zenoh."""
        self._was_lost = True
        if (lane := self.lane) is not None:
            lane.break_off()
