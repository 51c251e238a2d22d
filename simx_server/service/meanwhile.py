"""Serve clients while a long-running script or search holds the physics thread."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_server.simulation.simulation import SimulationState

from .calls.work import interfere

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation

    from .answers.outbox import Outbox
    from .calls.executor import Executor
    from .calls.serving import Serving
    from .clients.clients import Clients
    from .ending import Ending
    from .handling import Handling
    from .queue.inbox import Inbox

SERVING_DURING_SCRIPT = 0.02
"""Most seconds that others are served each time that a long-running script allows it."""


class Meanwhile:
    """Serves the calls that do not interfere with a script. Physics thread."""

    def __init__(
        self,
        simulation: Simulation,
        queue: Inbox,
        clients: Clients,
        executor: Executor,
        outbox: Outbox,
        serving: Serving,
        handling: Handling,
        ending: Ending,
    ) -> None:
        self._simulation, self._queue, self._clients, self._executor = simulation, queue, clients, executor
        self._outbox, self._serving, self._handling, self._ending = outbox, serving, handling, ending

    def serve_others(self) -> None:
        """Serve the calls that do not interfere with the long-running script that calls this."""
        if self._serving.is_active:
            return
        with self._serving.within_script():
            self._outbox.send()
            executing, waits = self._executor.client, self._brings_on_what_interferes
            for event in self._queue.meanwhile(executing, waits, SERVING_DURING_SCRIPT):
                self._handling.handle(event)
            self._clients.report_dropped()

    def is_end_wanted(self) -> bool:
        """Return whether the server ends, or a client of any gateway waits for the run to stop."""
        is_stopped = self._simulation.state is SimulationState.STOPPED
        return self._ending.has_come or (self._queue.has_stop_waiting and not is_stopped)

    def _brings_on_what_interferes(self, client: str) -> bool:
        """Return whether a batch of this client continues behind a trigger with calls that must wait for a script."""
        session = self._clients.sessions.get(client)
        return session is not None and session.interrupted is not None and interfere(session.interrupted.rest)
