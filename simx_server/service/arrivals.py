"""The stages of a turn that take messages: wait for the first one, or execute those at hand before a round is made."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from .answers.outbox import LINGER

if TYPE_CHECKING:
    from .answers.outbox import Outbox
    from .clock import Pacer
    from .due import Due
    from .handling import Handling
    from .queue.inbox import Inbox

SERVING = 0.05
"""Most seconds that clients are served before a step without pacing: the time that a step usually stands for."""

SERVING_WHEN_LATE = 0.01
"""The same for a step that is due by the wall clock: clients were served while it was not due."""


class Arrivals:
    """Takes from the queue. Physics thread."""

    def __init__(self, queue: Inbox, handling: Handling, outbox: Outbox, due: Due, pacer: Pacer) -> None:
        self._queue, self._handling, self._outbox, self._due, self._pacer = (
            queue, handling, outbox, due, pacer
        )  # fmt: skip

    def await_one(self, max_wait: float) -> bool:
        """Wait for a message or event and handle it; return False without a wait if a round is due.

        Args:
            max_wait: seconds.
        """
        wait = min(max_wait, self._due.seconds_until_round())
        if wait <= 0:
            return False
        queue, handling, outbox = self._queue, self._handling, self._outbox
        event = queue.wait(min(wait, LINGER) if outbox.is_keeping else wait)
        if event is None:
            outbox.send()
            return True
        handling.handle(event)
        handling.settle()
        # Mostly the next one is here already. Take only one: a simulation step may be due by now.
        if outbox.is_keeping and (event := queue.wait(0)) is not None:
            handling.handle(event)
            handling.settle()
        return True

    def take_all(self, _max_wait: float) -> bool:
        """Handle what is at hand: commands act on the coming step."""
        for event in self._queue.at_hand(self.serving_time()):
            self._handling.handle(event)
            self._handling.settle()  # after each, however many came together
        self._outbox.send()
        self._handling.settle()
        return False

    def serving_time(self) -> float:
        """Return how many seconds clients are served at most before the step that is due."""
        is_late = self._due.is_paced and math.isfinite(self._pacer.speed)
        return SERVING_WHEN_LATE if is_late else SERVING
