"""Send answers to clients: answers to batches of one client that follow closely leave in one message.

A message costs both processes more than a few calls do, and most scripts read something right after they have set
something. So answers that no client waits for, such as those to sets, are kept for a moment and leave with the next.
"""

from __future__ import annotations

import logging
from collections.abc import Iterable

from simx_client.protocol.commands import ANSWERED
from simx_client.protocol.messages import Call, Reply
from simx_server.service.clients.sessions import ClientSession

from .replies import Messages

logger = logging.getLogger(__name__)

LINGER = 100e-6
"""Seconds that answers wait for the next batch while the server has nothing else to do. When a client of this host
sends two messages in a row, the second one comes within that time.
"""

MOST_KEPT = 100
"""Replies that wait for more, and batches they wait for; a client may send faster than it is answered."""


class Outbox:
    """Replies to one client at a time. Physics thread only."""

    def __init__(self, messages: Messages) -> None:
        """Make an empty outbox."""
        self.messages = messages
        self._session: ClientSession | None = None
        self.is_keeping = False
        """Replies are kept for the next ones."""

        self._replies: list[Reply] = []
        self._is_awaited = False
        """The client waits for one of the replies."""

        self._batches = 0
        """Batches served since there is something to send."""

    def put(self, session: ClientSession, replies: list[Reply], *, is_awaited: bool = True) -> None:
        """Add replies for the next ``send``, behind all earlier ones.

        Args:
            is_awaited: they must not wait for others.
        """
        if session is not self._session:
            self.send()
            self._session, self.is_keeping = session, True
        self._replies += replies
        self._is_awaited |= is_awaited

    def send_what_is_awaited(self) -> None:
        """Send after a batch, unless all replies may wait for the next ones."""
        if self._session is None:
            return
        self._batches += 1  # not each of them is answered
        if self._is_awaited or len(self._replies) >= MOST_KEPT or self._batches >= MOST_KEPT:
            self.send()

    def send_before(self, calls: Iterable[Call]) -> None:
        """Send, if executing these calls may take long."""
        if self._session is not None and any(map(_may_take_long, calls)):
            self.send()

    def send(self) -> None:
        """Send the replies that are kept. Never raises: oversized replies concern one client, not the server."""
        session, self._session, self.is_keeping = self._session, None, False
        if session is None:
            return
        replies, self._replies = self._replies, []
        self._is_awaited, self._batches = False, 0
        try:
            session.link.deliver(self.messages.delivery(session, replies))
        except Exception:
            logger.exception("%d answers to client %s cannot be sent", len(replies), session.name)


def _may_take_long(call: Call) -> bool:
    command = ANSWERED.get(call.command)
    return command is not None and (command.waits_for_scripts or not command.answers_soon)
