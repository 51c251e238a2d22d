"""Answers on their way out: those to batches of one client that came close behind one another leave in one message.

A message costs both processes more than a few calls do. So answers that carry nothing, as those to sets, wait for
those to the client's next batch, if that one is here already and can be answered at once.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable

from simx_client.protocol.commands import ANSWERED
from simx_client.protocol.messages import Call, Reply

from .inbox import Inbox
from .sessions import ClientSession

logger = logging.getLogger(__name__)

MOST_KEPT = 100
"""Replies that wait for more, and batches they wait for; a client may send faster than it is answered."""


class Outbox:
    """Replies to one client at a time. Physics thread only."""

    def __init__(self, inbox: Inbox, pack: Callable[[ClientSession, list[Reply]], bytes]) -> None:
        """Keep nothing yet.

        Args:
            pack: puts replies into a message.
        """
        self._inbox = inbox
        self._pack = pack
        self._session: ClientSession | None = None
        self._replies: list[Reply] = []
        self._batches = 0
        """That were dealt with since there is something to send."""

    def put(self, session: ClientSession, replies: list[Reply]) -> None:
        """Have replies sent with the next ``send``, behind all that were put before."""
        if session is not self._session:
            self.send()
            self._session = session
        self._replies += replies

    @property
    def is_keeping(self) -> bool:
        """Whether replies wait for those to the next batch, which is here."""
        return self._session is not None

    def send_unless_more_comes(self) -> None:
        """To be called when a batch was dealt with: send, if the next one is not of the same client."""
        session = self._session
        if session is None:
            return
        self._batches += 1  # not each of them is answered
        is_full = len(self._replies) >= MOST_KEPT or self._batches >= MOST_KEPT
        if (
            is_full
            or any(reply.values for reply in self._replies)
            or not self._inbox.is_next_of(session.client)
        ):
            self.send()

    def send_before(self, calls: Iterable[Call]) -> None:
        """Send, if executing these may take long."""
        if self._session is not None and any(map(_may_take_long, calls)):
            self.send()

    def send(self) -> None:
        """Send what is kept. Never raises: what no message can hold is one client's trouble, not the engine's."""
        session, self._session = self._session, None
        replies, self._replies = self._replies, []
        self._batches = 0
        if session is not None and replies:
            try:
                session.link.deliver(self._pack(session, replies))
            except Exception:
                logger.exception("%d answers to client %s cannot be sent", len(replies), session.name)


def _may_take_long(call: Call) -> bool:
    command = ANSWERED.get(call.command)
    return command is not None and (command.waits_for_scripts or not command.answers_soon)
