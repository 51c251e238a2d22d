"""The loop of the physics thread, which alone touches the simulation.

It takes calls from a queue while it waits for the wall clock and between simulation steps, so a blocking call costs a
round trip and never a simulation step. After each simulation step, every stream that is due is computed once. A
long-running script holds the thread. Other clients are answered meanwhile, see `meanwhile.py`.
"""

from __future__ import annotations

import time

from .service import Service

LOOK = 0.05
"""Least seconds between two looks at work that is due now and then: a look after each turn would cost every call."""


class ServerLoop:
    """Turns a service: its calls, simulation steps and streams. The order of a turn is `Service.TURN`."""

    def __init__(self, service: Service) -> None:
        """Make a loop; ``run`` or ``turn`` drive it."""
        self.service = service
        self._stages = tuple(stage(service) for _, stage in service.TURN)

    def run(self, deadline: float | None = None) -> None:
        """Serve until the server ends, or a time on the monotonic clock."""
        service, next_look = self.service, 0.0
        with service.busy.open():
            while not service.ending.has_come and (deadline is None or time.monotonic() < deadline):
                left = 1.0 if deadline is None else deadline - time.monotonic()
                if service.handling.has_handled:  # a look at what it changed must not wait for the next event
                    left = min(left, next_look - time.monotonic())
                self.turn(max_wait=max(0.0, min(1.0, left)))
                if (now := time.monotonic()) >= next_look:
                    next_look = now + LOOK
                    self.look()
            service.outbox.send()

    def turn(self, max_wait: float = 0.0) -> None:
        """Wait for the first of: an event, a simulation step that is due, ``max_wait``. Then handle it.

        Before a simulation step, everything that has arrived is executed: commands act on the coming step.
        """
        for stage in self._stages:
            if stage(max_wait):
                return

    def look(self) -> None:
        """Let the watchers do what is due now and then."""
        self.service.handling.looked()
        looks = self.service.watchers.look  # one of them may close a gateway, which makes another tuple
        for look in looks:
            look()

    @property
    def advances_alone(self) -> bool:
        """Return whether something happens without calls: simulation steps, regular work, or what was queued."""
        due = self.service.due
        return due.is_running_freely or due.is_idle_wanted or self.service.queue.has_work()
