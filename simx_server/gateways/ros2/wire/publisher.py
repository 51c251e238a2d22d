"""A topic that the node publishes. Any thread may put; without a session nothing is sent or counted."""

from __future__ import annotations

import logging
import threading
import time
from typing import Any

from .attachment import Attachment, new_gid
from .endpoint import Described, Endpoint
from .names import Distribution, Kind, Place, key
from .qos import Qos

logger = logging.getLogger(__name__)

HEARTBEAT = 0.5
"""Seconds until a reliable publisher with a cache says which message was its last, as in rmw_zenoh."""


class Publisher(Endpoint):
    """A publisher; with a cache for late subscribers if its topic is transient local."""

    kind = Kind.PUBLISHER

    def __init__(
        self, place: Place, full_name: str, described: Described, qos: Qos, distribution: Distribution
    ) -> None:
        """Make a publisher that is not declared."""
        super().__init__(place, full_name, described, qos, distribution)
        self.key = key(place, full_name, described.dds_name, distribution.hash_of(described.hash))
        self._lock = threading.Lock()
        self._publisher: Any = None
        self._error: type[Exception] = Exception
        """The error of Zenoh, known once it is loaded."""

        self._number, self._gid = 0, b""
        self._last: bytes | None = None
        """The last message of a transient-local topic, which a new session gets too."""

    @property
    def is_wanted(self) -> bool:
        """Return whether someone listens. A transient-local topic is always wanted: late subscribers want it."""
        publisher = self._publisher
        if self.qos.is_transient_local:
            return True
        if publisher is None:
            return False
        try:
            return publisher.matching_status.matching
        except self._error:  # the session is being closed
            return False

    def put(self, payload: bytes | bytearray) -> None:
        """Send a message, or nothing without a session. The call never waits: a message for a full link is lost."""
        with self._lock:
            if self.qos.is_transient_local:
                self._last = bytes(payload)
            self._put(payload)

    def _put(self, payload: bytes | bytearray) -> None:
        if self._publisher is None:
            return
        self._number += 1
        attached = Attachment(self._number, time.time_ns(), self._gid).packed()
        try:
            self._publisher.put(payload, attachment=attached)
        except self._error as error:
            logger.debug("%s cannot be published: %s", self.full_name, error)

    def _declare(self, zenoh: Any, session: Any) -> None:
        drop = zenoh.CongestionControl.DROP
        if self.qos.is_transient_local:
            made = zenoh.ext.declare_advanced_publisher(
                session,
                self.key,
                congestion_control=drop,
                cache=zenoh.ext.CacheConfig(max_samples=self.qos.depth),
                publisher_detection=True,
                sample_miss_detection=zenoh.ext.MissDetectionConfig(
                    heartbeat=None, sporadic_heartbeat=HEARTBEAT
                )
                if self.qos.is_reliable
                else None,
            )
        else:
            made = session.declare_publisher(self.key, congestion_control=drop)
        with self._lock:
            self._error = zenoh.ZError
            self._number, self._gid = 0, new_gid()
            self._publisher = made
            if self._last is not None:
                self._put(self._last)

    def _undeclare(self) -> None:
        with self._lock:
            publisher, self._publisher = self._publisher, None
        if publisher is not None:
            publisher.undeclare()

    def forget(self) -> None:
        super().forget()
        with self._lock:
            self._publisher = None
