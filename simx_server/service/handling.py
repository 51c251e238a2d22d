"""Handle what the queue gives: execute a message, or do what an event says, and settle what it has left for later."""

from __future__ import annotations

import logging
import time
from typing import TYPE_CHECKING

from .queue.box import Arrival, Event

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation

    from .answers.outbox import Outbox
    from .calls.addresses import CallsAtOnce
    from .calls.batches import Batches
    from .calls.busy import BusyDesk
    from .calls.serving import Serving
    from .calls.work import Work
    from .queue.inbox import Inbox

logger = logging.getLogger(__name__)


class Handling:
    """Handles one thing after the other. Physics thread."""

    def __init__(
        self,
        simulation: Simulation,
        queue: Inbox,
        at_once: CallsAtOnce,
        batches: Batches,
        outbox: Outbox,
        busy: BusyDesk,
        serving: Serving,
    ) -> None:
        self._simulation, self._queue, self._at_once, self._batches = simulation, queue, at_once, batches
        self._outbox, self._busy, self._serving = outbox, busy, serving
        self._has_handled = False

    def handle(self, event: Event | Arrival) -> None:
        """Handle an event or a message; a failure is logged, and the server goes on."""
        self._has_handled = True
        began = time.perf_counter()
        try:
            if not (isinstance(event, Arrival) and self._at_once.answer(event.client, event.work)):
                self._execute(event)
        except Exception:
            logger.exception("a request could not be dealt with; the server goes on")
        finally:
            self._queue.served(time.perf_counter() - began)
        if self._serving.is_active:
            self._outbox.send()
        elif self._outbox.is_keeping:
            self._outbox.send_what_is_awaited()

    def _execute(self, event: Event | Arrival) -> None:
        """Do what may take long."""
        outer = self._busy.begin()
        try:
            if isinstance(event, Arrival):
                self._batches.execute(event.client, event.work)
            else:
                self._outbox.send()
                event()
        finally:
            self._busy.go_back_to(outer)

    def settle(self) -> None:
        """Do what calls have left for later: a start, a stop, another scene."""
        if not self._simulation.is_settled:
            self._outbox.send()
            self._simulation.settle()

    def execute(self, client: str, work: Work) -> None:
        """Execute a message of a client of this process at once; its thread is the physics thread meanwhile."""
        self.handle(Arrival(client, work))
        self.settle()
        self._outbox.send()

    @property
    def has_handled(self) -> bool:
        """Return whether something was handled since the last `looked`."""
        return self._has_handled

    def looked(self) -> None:
        """Note that the watchers have looked at what was handled."""
        self._has_handled = False
