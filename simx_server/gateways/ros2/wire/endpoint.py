"""One endpoint of the node: its key, its token, and its part of the Zenoh session while there is one."""

from __future__ import annotations

from typing import Any, Protocol

from .names import Distribution, Kind, Place, endpoint_token
from .qos import Qos

MOST_BYTES = 1 << 20
"""Bytes of a command or of a request; a larger one is thrown away."""


class Described(Protocol):
    """The type of a topic or service, as `messages` describes it."""

    @property
    def name(self) -> str:
        """Return the name, such as ``sensor_msgs/msg/JointState``."""
        ...

    @property
    def dds_name(self) -> str:
        """Return the name in keys, such as ``sensor_msgs::msg::dds_::JointState_``."""
        ...

    @property
    def hash(self) -> str:
        """Return the hash in keys, such as ``RIHS01_a13e…``."""
        ...


class Endpoint:
    """The common part of publishers, subscriptions and services.

    `declare` and `undeclare` are for the thread of the session, which alone calls them.
    """

    kind: Kind
    key: str
    """The key expression, whose last part is the hash, or `*` for those of all distributions."""

    most_bytes = MOST_BYTES
    """Bytes of a message that is read."""

    def __init__(
        self, place: Place, full_name: str, described: Described, qos: Qos, distribution: Distribution
    ) -> None:
        """Make an endpoint that is not declared.

        Args:
            full_name: with namespace.
        """
        self.full_name, self.described, self.qos = full_name, described, qos
        self._place, self._distribution = place, distribution
        self.is_listed = True
        """Whether the graph shows it."""

        self._token: Any = None

    def declare(self, zenoh: Any, session: Any, node_id: int, number: int) -> None:
        """Declare the endpoint, then its token.

        Args:
            number: different from those of all endpoints of the session.

        Raises:
            zenoh.ZError: the session is closed.
        """
        self._declare(zenoh, session)
        if self.is_listed:
            token = endpoint_token(
                self._place,
                str(session.info.zid()),
                (node_id, number),
                self.kind,
                self.full_name,
                self.described.dds_name,
                self._distribution.hash_of(self.described.hash),
                self.qos,
            )
            self._token = session.liveliness().declare_token(token)

    def undeclare(self) -> None:
        """Take the endpoint back. Raises zenoh.ZError: the session is closed."""
        token, self._token = self._token, None
        if token is not None:
            token.undeclare()
        self._undeclare()

    def forget(self) -> None:
        """Note that the session has gone, and everything declared with it."""
        self._token = None

    def _declare(self, zenoh: Any, session: Any) -> None:
        raise NotImplementedError

    def _undeclare(self) -> None:
        raise NotImplementedError
