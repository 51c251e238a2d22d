"""One client over Zenoh: the publishers that reach it."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from functools import partial
from typing import Any

from simx_client.protocol.messages import Delivery
from simx_client.protocol.zenoh import keys
from simx_server.service.answers.link import PackingLink

from .posting import Postman

logger = logging.getLogger(__name__)


class ZenohLink(PackingLink):
    """The publishers that reach one client."""

    def __init__(
        self,
        zenoh: Any,
        session: Any,
        realm: str,
        client: str,
        postman: Postman,
        ended: Callable[[], object],
    ) -> None:
        """Declare the publishers.

        Args:
            ended: called once when the client has left: its name is free for clients of all gateways.
        """
        self._postman, self._ended = postman, ended
        self._lock = threading.Lock()
        self._sending = 0
        """Threads that send a reply at present: the publisher cannot be undeclared meanwhile."""

        self._is_closed = False
        reliable = zenoh.Reliability.RELIABLE
        self._zenoh, self._session = zenoh, session
        self._realm, self._client = realm, client
        self._drop = zenoh.CongestionControl.DROP
        self._replies = session.declare_publisher(
            keys.reply(realm, client),
            congestion_control=zenoh.CongestionControl.BLOCK,
            reliability=reliable,
        )
        self._stream = session.declare_publisher(
            keys.stream(realm, client), congestion_control=self._drop, reliability=reliable
        )

    def put_replies(self, payload: bytes) -> None:
        self._postman.send(partial(self._reply, payload), len(payload))

    def _reply(self, payload: bytes) -> None:
        with self._lock:
            if self._is_closed:
                return
            self._sending += 1
        try:
            self._put(self._replies.put, payload)
        finally:
            with self._lock:
                self._sending -= 1
                is_last = self._is_closed and not self._sending
            if is_last:
                self._replies.undeclare()

    def put_values(self, payload: bytes) -> None:
        self._put(self._stream.put, payload)

    def publish_image(self, stream_id: int, delivery: Delivery, *, in_order: bool) -> None:
        if in_order:  # on another key a later reply may overtake it
            self.deliver(delivery)
        else:
            super().publish_image(stream_id, delivery, in_order=in_order)

    def put_image(self, stream_id: int, payload: bytes) -> None:
        key = keys.image(self._realm, self._client, stream_id)
        self._put(self._session.put, key, payload, congestion_control=self._drop)

    def _put(self, put: Callable[..., None], *arguments: Any, **options: Any) -> None:
        """Send, unless the client has left or the session is closed, as may happen before an image is ready."""
        try:
            put(*arguments, **options)
        except self._zenoh.ZError as error:
            logger.debug("nothing can be sent to client %s any more: %s", self._client, error)

    def close(self) -> None:
        """Stop sending. The call does not wait for a thread that still sends a reply to a client that does not read."""
        with self._lock:
            if self._is_closed:
                return
            self._is_closed = True
            is_last = not self._sending
        self._ended()
        if is_last:
            self._replies.undeclare()
        self._stream.undeclare()
