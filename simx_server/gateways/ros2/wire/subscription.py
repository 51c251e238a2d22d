"""A topic that the node listens to. Zenoh's threads only keep the newest messages; the physics thread takes them."""

from __future__ import annotations

import logging
import threading
from collections import deque
from collections.abc import Callable
from typing import Any

from simx_server.gateways.zenoh.throttle import Throttle
from simx_server.parts.status_bar import as_log_line

from ...outsider_log import OutsiderLog
from .endpoint import Described, Endpoint
from .names import NO_HASH, Distribution, Kind, Place, key
from .qos import Qos

logger = logging.getLogger(__name__)


class Guard:
    """The part that all endpoints share which take messages of others."""

    def __init__(self, log: OutsiderLog, throttle: Throttle, most_waiting: Callable[[], int]) -> None:
        """Join them.

        Args:
            log: says what others do wrong.
            throttle: slows down those who send more than is executed.
            most_waiting: returns the bytes that all messages together may have while they wait to be executed.
        """
        self._log = log
        self._throttle = throttle
        self._most_waiting = most_waiting
        self._lock = threading.Lock()
        self._waiting = 0
        """Bytes of all messages that wait."""

    def says_no(self, endpoint: Endpoint, key_expression: str, size: int) -> str:
        """Return why a message must not be read; empty if it may be.

        Args:
            key_expression: the key it was sent to, which ends with the hash of the sender's type.
            size: its bytes.
        """
        known, _, spoken = key_expression.rpartition("/")
        if known != endpoint.key.rpartition("/")[0]:  # a request may be for many services
            return f"it is for {key_expression[:200]}; valid: one topic or service at a time"
        if spoken not in (endpoint.described.hash, NO_HASH):
            return (
                f"its sender knows another {endpoint.described.name} (hash {spoken[:80]}); "
                "build it with the messages of this distribution of ROS 2"
            )
        if size > endpoint.most_bytes:
            return f"it has {size} bytes, and at most {endpoint.most_bytes} are read"
        return ""

    def keep(self, size: int) -> bool:
        """Return whether one more message of this many bytes may wait, and count it."""
        with self._lock:
            if self._waiting + size > self._most_waiting():
                return False
            self._waiting += size
            return True

    def release(self, size: int) -> None:
        """Note that a message does not wait any more."""
        with self._lock:
            self._waiting -= size

    def refuse(self, endpoint: Endpoint, why: str, size: int) -> None:
        """Log that a message was thrown away, and have its sender wait."""
        self._log.say(
            logging.WARNING, "a message for %s is thrown away: %s", endpoint.full_name, as_log_line(why)
        )
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
            arrived: called when a message waits and none did before, or when one was taken and others wait, on any
                thread; it has the physics thread `take` the next one.
        """
        super().__init__(place, full_name, described, qos, distribution)
        self.is_listed = is_listed
        self.key = key(place, full_name, described.dds_name, "*")
        self._guard, self._arrived = guard, arrived
        self._lock = threading.Lock()
        self._waiting: deque[bytes] = deque()
        self._is_announced = False
        self._subscriber: Any = None

    def take(self) -> bytes | None:
        """Return the oldest message that waits, None if there is none. Physics thread.

        The next one has its own turn: many large messages together would hold up simulation steps and other clients.
        """
        with self._lock:
            taken = self._waiting.popleft() if self._waiting else None
            self._is_announced = has_more = bool(self._waiting)
        if taken is not None:
            self._guard.release(len(taken))
        if has_more:
            self._arrived(self)
        return taken

    def _take_in(self, sample: Any) -> None:
        """Keep a message. One of Zenoh's threads."""
        size = len(sample.payload)
        if why := self._guard.says_no(self, str(sample.key_expr), size):
            self._guard.refuse(self, why, size)
            return
        with self._lock:
            is_full = len(self._waiting) >= self.qos.depth
            if is_full:
                self._guard.release(len(self._waiting.popleft()))
            has_room = self._guard.keep(size)
            if has_room:
                self._waiting.append(sample.payload.to_bytes())
            is_news = has_room and not self._is_announced
            self._is_announced |= is_news
        if is_news:
            self._arrived(self)
        if not has_room:
            self._guard.refuse(self, "too much waits to be executed", size)
        elif is_full:
            self._guard.slow_down(size)

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
