"""A client of a service of others. Any thread may call; the answers come on Zenoh's threads."""

from __future__ import annotations

import threading
import time
from concurrent.futures import Future
from typing import Any

from .attachment import Attachment, new_gid
from .endpoint import Described, Endpoint
from .names import Distribution, Kind, Place, key
from .qos import Qos

TIMEOUT = 10.0
"""Seconds that a server has to answer."""

MOST_BYTES = 1 << 20
"""Bytes of an answer; a larger one is thrown away."""


class NotAnswered(Exception):
    """A call was not answered; the text says why."""


class ServiceClient(Endpoint):
    """A client, which calls all complete servers and takes the first answer, as rmw_zenoh does."""

    kind = Kind.CLIENT

    def __init__(
        self, place: Place, full_name: str, described: Described, distribution: Distribution
    ) -> None:
        """Make a client that is not declared."""
        super().__init__(place, full_name, described, Qos(), distribution)
        self.key = key(place, full_name, described.dds_name, distribution.hash_of(described.hash))
        self._lock = threading.Lock()
        self._zenoh: Any = None
        self._querier: Any = None
        self._number, self._gid = 0, b""

    @property
    def is_served(self) -> bool:
        """Return whether a server is there."""
        querier = self._querier
        if querier is None:
            return False
        try:
            return bool(querier.matching_status.matching)
        except self._zenoh.ZError:  # the session is being closed
            return False

    def call(self, payload: bytes) -> Future[bytes]:
        """Send CDR of a request; the future has CDR of the response, or raises NotAnswered."""
        answer: Future[bytes] = Future()

        def arrived(reply: Any) -> None:
            if reply.ok is not None and not answer.done():
                if len(reply.ok.payload) > MOST_BYTES:
                    answer.set_exception(self._failure(f"the answer has more than {MOST_BYTES} bytes"))
                else:
                    answer.set_result(reply.ok.payload.to_bytes())

        def ended() -> None:
            if not answer.done():
                answer.set_exception(self._failure(f"no server has answered within {TIMEOUT:g} s"))

        with self._lock:
            querier = self._querier
            if querier is None:
                answer.set_exception(self._failure("there is no connection to ROS 2"))
                return answer
            self._number += 1
            attached = Attachment(self._number, time.time_ns(), self._gid).packed()
        try:
            callback = self._zenoh.handlers.Callback(arrived, ended, indirect=False)
            querier.get(callback, payload=payload, attachment=attached)
        except self._zenoh.ZError as error:
            answer.set_exception(self._failure(str(error)))
        return answer

    def _failure(self, why: str) -> NotAnswered:
        return NotAnswered(f"the call of {self.full_name} has failed: {why}")

    def _declare(self, zenoh: Any, session: Any) -> None:
        made = session.declare_querier(
            self.key,
            target=zenoh.QueryTarget.ALL_COMPLETE,
            consolidation=zenoh.ConsolidationMode.NONE,
            timeout=TIMEOUT,
        )
        with self._lock:
            self._zenoh, self._querier = zenoh, made
            self._number, self._gid = 0, new_gid()

    def _undeclare(self) -> None:
        with self._lock:
            querier, self._querier = self._querier, None
        if querier is not None:
            querier.undeclare()

    def forget(self) -> None:
        super().forget()
        with self._lock:
            self._querier = None
