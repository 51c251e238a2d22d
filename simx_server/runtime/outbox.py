"""Answers on their way out: those to batches of one client that came close behind one another leave in one message.

A message costs both processes more than a few calls do, and most scripts ask for something right after they have set
something. So answers that nobody waits for, as those to sets, stay for a moment, to leave with the next ones.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable

from simx_client.protocol.commands import ANSWERED
from simx_client.protocol.messages import Call, Reply

from .sessions import ClientSession

logger = logging.getLogger(__name__)

LINGER = 100e-6
"""Seconds that answers wait for a next batch, where nothing else is to be done. What a client of this host sends right
behind another message comes within that time."""

MOST_KEPT = 100
"""Replies that wait for more, and batches they wait for; a client may send faster than it is answered."""


class Outbox:
    """Replies to one client at a time. Physics thread only."""

    def __init__(self, pack: Callable[[ClientSession, list[Reply]], bytes]) -> None:
        """Keep nothing yet.

        Args:
            pack: puts replies into a message.
        """
        self._pack = pack
        self._session: ClientSession | None = None
        self._replies: list[Reply] = []
        self._is_awaited = False
        """Somebody waits for one of the replies."""

        self._batches = 0
        """That were dealt with since there is something to send."""

    def put(self, session: ClientSession, replies: list[Reply], *, is_awaited: bool = True) -> None:
        """Have replies sent with the next ``send``, behind all that were put before.

        Args:
            is_awaited: they must not stay for others.
        """
        if session is not self._session:
            self.send()
            self._session = session
        self._replies += replies
        self._is_awaited |= is_awaited

    @property
    def is_keeping(self) -> bool:
        """Whether there are replies that stay for the next ones."""
        return self._session is not None

    def send_what_is_awaited(self) -> None:
        """To be called when a batch was dealt with: send, unless all there is may stay."""
        if self._session is None:
            return
        self._batches += 1  # not each of them is answered
        if self._is_awaited or len(self._replies) >= MOST_KEPT or self._batches >= MOST_KEPT:
            self.send()

    def send_before(self, calls: Iterable[Call]) -> None:
        """Send, if executing these may take long."""
        if self._session is not None and any(map(_may_take_long, calls)):
            self.send()

    def send(self) -> None:
        """Send what is kept. Never raises: what no message can hold is one client's trouble, not the engine's."""
        session, self._session = self._session, None
        if session is None:
            return
        replies, self._replies = self._replies, []
        self._is_awaited, self._batches = False, 0
        try:
            session.link.deliver(self._pack(session, replies))
        except Exception:
            logger.exception("%d answers to client %s cannot be sent", len(replies), session.name)


def _may_take_long(call: Call) -> bool:
    command = ANSWERED.get(call.command)
    return command is not None and (command.waits_for_scripts or not command.answers_soon)
