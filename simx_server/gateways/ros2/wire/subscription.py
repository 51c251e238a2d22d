"""A topic that the node listens to. Zenoh's threads only keep the newest messages; the physics thread takes them."""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Callable
from typing import Any

from ...outsider_log import OutsiderLog
from ...throttle import Throttle
from .endpoint import Described, Endpoint
from .names import NO_HASH, Distribution, Kind, Place, key
from .qos import Qos

logger = logging.getLogger(__name__)

MOST_BYTES = 1 << 20
"""Bytes of a message that is a command; a larger one is thrown away."""


class Guard:
    """The part that all endpoints share which take messages of others."""

    def __init__(self, log: OutsiderLog, throttle: Throttle) -> None:
        """Join them.

        Args:
            log: says what others do wrong.
            throttle: slows down those who send more than is executed.
        """
        self._log = log
        self._throttle = throttle

    def says_no(self, endpoint: Endpoint, key_expression: str, size: int) -> str:
        """Return why a message must not be read; empty if it may be.

        Args:
            key_expression: the key it was sent to, which ends with the hash of the sender's type.
            size: its bytes.
        """
        spoken = key_expression.rpartition("/")[2]
        if spoken not in (endpoint.described.hash, NO_HASH):
            return (
                f"its sender knows another {endpoint.described.name} (hash {spoken[:80]}); "
                "build it with the messages of this distribution of ROS 2"
            )
        if size > MOST_BYTES:
            return f"it has {size} bytes, and at most {MOST_BYTES} are read"
        return ""

    def refuse(self, endpoint: Endpoint, why: str, size: int) -> None:
        """Log that a message was thrown away, and have its sender wait."""
        self._log.say(logging.WARNING, "a message for %s is thrown away: %s", endpoint.full_name, why)
        self.slow_down(size)

    def slow_down(self, size: int) -> None:
        """Have the sender of a message wait."""
        self._throttle.slow_down(size)


class Subscription(Endpoint):
    """A subscription to the types of all distributions."""

    kind = Kind.SUBSCRIPTION

    def __init__(
        self,
        place: Place,
        full_name: str,
        described: Described,
        qos: Qos,
        distribution: Distribution,
        *,
        is_listed: bool,
        guard: Guard,
        arrived: Callable[[Subscription], object],
    ) -> None:
        """Make a subscription that is not declared.

        Args:
            is_listed: the graph shows it.
            guard: judges what arrives.
            arrived: called when messages wait and none did before, on any thread; it has the physics thread `take`
                them.
        """
        super().__init__(place, full_name, described, qos, distribution)
        self.is_listed = is_listed
        self.key = key(place, full_name, described.dds_name, "*")
        self._guard, self._arrived = guard, arrived
        self._waiting: deque[bytes] = deque(maxlen=qos.depth)
        self._is_announced = False
        self._subscriber: Any = None

    def take(self) -> list[bytes]:
        """Return the messages that wait, oldest first. Physics thread."""
        self._is_announced = False
        taken: list[bytes] = []
        while self._waiting and len(taken) < self.qos.depth:
            taken.append(self._waiting.popleft())
        if self._waiting:
            self._announce()
        return taken

    def _take_in(self, sample: Any) -> None:
        """Keep a message. One of Zenoh's threads."""
        size = len(sample.payload)
        if why := self._guard.says_no(self, str(sample.key_expr), size):
            self._guard.refuse(self, why, size)
            return
        is_full = len(self._waiting) >= self.qos.depth
        self._waiting.append(sample.payload.to_bytes())
        self._announce()
        if is_full:
            self._guard.slow_down(size)

    def _announce(self) -> None:
        if not self._is_announced:
            self._is_announced = True
            self._arrived(self)

    def _declare(self, zenoh: Any, session: Any) -> None:
        callback = zenoh.handlers.Callback(self._take_in, indirect=False)
        self._subscriber = session.declare_subscriber(self.key, callback)

    def _undeclare(self) -> None:
        subscriber, self._subscriber = self._subscriber, None
        if subscriber is not None:
            subscriber.undeclare()

    def forget(self) -> None:
        super().forget()
        self._subscriber = None
