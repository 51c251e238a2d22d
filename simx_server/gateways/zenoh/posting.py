"""Send reliable messages, also to clients that may not read them.

Zenoh blocks the sender while the queue of a link is full, for at most one second, and then cuts the link. The physics
thread must not wait for each such client. While all clients read, the physics thread sends directly, because that is
fastest. After it had to wait once, threads send instead, one for each client, until all clients have read in time for a
while.
"""

from __future__ import annotations

import logging
import threading
import time
from collections import deque
from collections.abc import Callable

logger = logging.getLogger(__name__)

Send = Callable[[], object]

LONG = 0.02
"""Seconds that sending takes only when a link is full."""

CAREFUL, MOST_CAREFUL = 300, 60.0
"""Threads send for this multiple of the time that the physics thread has waited, up to this number of seconds. The
period is short because a thread adds a tenth of a millisecond to each reply, and a machine that was busy for a moment
does not mean that a client does not read.
"""

MUCH_UNSENT = 4 << 20
"""Unsent bytes of one client above which the server executes nothing for it, until half of them are sent."""

IDLE = 5.0
"""Seconds without work after which a thread ends."""


class Care:
    """Records whether some client does not read its messages; one instance for all clients."""

    def __init__(self) -> None:
        self._until = -1.0

    @property
    def is_due(self) -> bool:
        return time.monotonic() < self._until

    def sent(self, began: float) -> None:
        """Record that a send has finished that started at this time of the monotonic clock."""
        now = time.monotonic()
        if now - began > LONG:
            self._until = max(self._until, now + min(MOST_CAREFUL, CAREFUL * (now - began)))


class Postman:
    """Sends to one client, in order. Any thread."""

    def __init__(self, care: Care, fall_behind: Callable[[bool], object]) -> None:
        """Make a postman with nothing to send.

        Args:
            fall_behind: called with True when much is unsent, and with False when that has ended; on any thread.
        """
        self._care = care
        self._fall_behind = fall_behind
        self._is_behind = False
        self._changed = threading.Condition()
        self._unsent: deque[tuple[Send, int]] = deque()
        self._size = 0
        self._is_working = False
        """There is a thread."""

    def send(self, send: Send, size: int) -> None:
        """Send now, or put the message into the queue of the thread.

        Args:
            size: bytes of the message.
        """
        with self._changed:
            is_mine = not self._unsent and not self._care.is_due
            if not is_mine:
                self._unsent.append((send, size))
                self._size += size
                if not self._is_working:
                    self._is_working = True
                    threading.Thread(target=self._work, name="simx-send", daemon=True).start()
                if self._size > MUCH_UNSENT and not self._is_behind:
                    self._is_behind = True
                    self._fall_behind(True)
                self._changed.notify()
                return
        began = time.monotonic()
        send()
        self._care.sent(began)

    def _work(self) -> None:
        while True:
            with self._changed:
                if not self._unsent and not self._changed.wait_for(lambda: bool(self._unsent), IDLE):
                    self._is_working = False
                    return
                send, size = self._unsent[0]  # stays there until it is sent, so that nothing overtakes it
            began = time.monotonic()
            try:
                send()
            except Exception:
                logger.exception("something cannot be sent")
            self._care.sent(began)
            with self._changed:
                self._unsent.popleft()
                self._size -= size
                if self._is_behind and self._size < MUCH_UNSENT // 2:
                    self._is_behind = False
                    self._fall_behind(False)
