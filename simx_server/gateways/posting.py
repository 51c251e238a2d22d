"""Sending what must arrive, to clients that may not read it.

Zenoh has whoever sends wait while the queue of a link is full, for a second at most, and then cuts the link off. The
physics thread must not wait for each such client. So it sends by itself while all read, as that is quickest; once it
had to wait, threads send for it, one for each client, until all clients have read in time for a while.
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
"""Seconds that sending takes only where a link is full."""

CAREFUL, MOST_CAREFUL = 300, 60.0
"""Threads send for so many times as long as the physics thread has waited, and for so many seconds at most: a machine
that was busy for a moment is no client that does not read, and a thread costs each reply a tenth of a millisecond."""

MUCH_UNSENT = 4 << 20
"""Bytes that wait to be sent to one client, from which on nothing is executed for it until half of them is sent."""

IDLE = 5.0
"""Seconds without work after which a thread ends."""


class Care:
    """Whether somebody does not read what it is sent; one for all clients."""

    def __init__(self) -> None:
        self._until = -1.0

    @property
    def is_due(self) -> bool:
        return time.monotonic() < self._until

    def sent(self, began: float) -> None:
        """Sending has begun at this time of the monotonic clock, and is over."""
        now = time.monotonic()
        if now - began > LONG:
            self._until = max(self._until, now + min(MOST_CAREFUL, CAREFUL * (now - began)))


class Postman:
    """Sends to one client, in order. Any thread."""

    def __init__(self, care: Care, fall_behind: Callable[[bool], object]) -> None:
        """Begin with nothing to send.

        Args:
            fall_behind: told that much is unsent, and that it is not any more; on any thread.
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
        """Send now, or have it sent.

        Args:
            size: bytes.
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
