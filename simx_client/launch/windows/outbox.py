"""Messages that wait for a slow screen. Only the newest image of a window is kept."""

from __future__ import annotations

import threading

from .screen import SHOW, Message


class Outbox:
    """A queue for one reader. Its length is bounded by the number of windows and of messages without images."""

    def __init__(self) -> None:
        self._ready = threading.Condition()
        self._messages: list[Message] = []

    def put(self, message: Message) -> None:
        """Add a message. An image replaces the waiting one of its window, unless another message for the
        window came in between."""
        with self._ready:
            if message[0] == SHOW:
                for index in range(len(self._messages) - 1, -1, -1):
                    waiting = self._messages[index]
                    if waiting[1] == message[1]:
                        if waiting[0] == SHOW:
                            self._messages[index] = message
                            return
                        break
            self._messages.append(message)
            self._ready.notify()

    def take(self, timeout: float | None = None) -> list[Message]:
        """Return all waiting messages, in order; empty after this many seconds without a message."""
        with self._ready:
            if not self._messages:
                self._ready.wait(timeout)
            taken, self._messages = self._messages, []
            return taken
