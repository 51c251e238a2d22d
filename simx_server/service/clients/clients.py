"""The connected clients: every one joins and leaves here, by whichever gateway it comes."""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Container
from functools import partial
from typing import TYPE_CHECKING

from simx_client.protocol.constants import sim_api_errormessage_report
from simx_server.errors import CommandError
from simx_server.service.answers.link import Link
from simx_server.service.queue.inbox import Inbox
from simx_server.service.watcher import Watcher
from simx_server.simulation.simulation import SimulationState

from .admission.entrance import Entrance
from .admission.places import Places
from .sessions import MAX_DEPARTED, ClientSession, Departed

if TYPE_CHECKING:
    from simx_server.service.calls.serving import Serving
    from simx_server.service.monitoring.metrics import Metrics
    from simx_server.service.watcher import Watchers
    from simx_server.world.world import World

logger = logging.getLogger(__name__)

WITHIN = Entrance()
"""Of a client within this process."""


class Clients(Watcher):
    """The present clients and the newest of those that have left. Physics thread, except where a method says so."""

    def __init__(
        self,
        world: World,
        inbox: Inbox,
        metrics: Metrics,
        watchers: Watchers,
        serving: Serving,
        starting_port: int | None,
    ) -> None:
        """Start without clients.

        Args:
            starting_port: a client that comes by this port starts a stopped simulation; see also `start_by`.
            serving: knows whether a script runs, which a start has to wait for.
        """
        self._world, self._inbox, self._metrics, self._watchers = world, inbox, metrics, watchers
        self._simulation = simulation = world.simulation
        self._starting_ports: list[Container[int]] = [(starting_port,)] if starting_port is not None else []
        self._serving = serving
        self.sessions: dict[str, ClientSession] = {}
        self.departed: deque[Departed] = deque(maxlen=MAX_DEPARTED)
        self.places = Places(lambda: simulation.limits, self.sessions)

    def start_by(self, ports: Container[int]) -> None:
        """Have clients that come by further ports start a stopped simulation."""
        self._starting_ports.append(ports)

    def join(
        self,
        client: str,
        name: str,
        port: int,
        link: Link,
        *,
        calls_sim: bool = False,
        is_onlooker: bool = False,
        entrance: Entrance | None = WITHIN,
    ) -> ClientSession:
        """Add a client that says hello. A second hello (after a loss) starts a new session.

        Args:
            calls_sim: its messages hold calls of the namespaces of scripts, and not of the table.
            is_onlooker: the end of the server does not wait for it.
            entrance: where it has come in; None: it has a place already, as a client of a recording had.

        Raises:
            LimitReached: all places for it are taken; nothing has changed.
        """
        if entrance is not None and client not in self.sessions:
            self.places.check(entrance)
        self._end(client)
        self._inbox.open(client)
        if again := [each for each in self.departed if each.client == client]:
            self.departed.remove(again[0])
        session = ClientSession(
            client,
            name,
            port,
            link,
            calls_sim=calls_sim,
            is_onlooker=is_onlooker,
            entrance=entrance or WITHIN,
        )
        self.sessions[client] = session
        logger.info("client %s joined by port %d", name, port)
        for react in self._watchers.joined:
            react(session)
        has_returned = any(welcomes(session) for welcomes in self._watchers.welcomes)
        if (
            any(port in ports for ports in self._starting_ports)
            and not session.may_only_read
            and not has_returned
        ):
            self._start_by(port)
        return session

    def _start_by(self, port: int) -> None:
        """Start a stopped simulation: in V-REP the service behind this port existed only while one ran."""
        if self._simulation.state is not SimulationState.STOPPED:
            return
        if self._serving.is_active:
            self._inbox.hold(partial(self._start_for, port))
        else:
            self._start_for(port)

    def _start_for(self, port: int) -> None:
        logger.info("starting the simulation, as port %d exists only while one runs", port)
        for react in self._watchers.started:
            react()
        try:
            self._simulation.start()
        except CommandError as problem:
            logger.error("%s", problem)

    def depart(self, client: str) -> None:
        """Remove a client after everything that it has sent is executed; later messages are not. Any thread."""
        self._inbox.leave(client, partial(self.leave, client))

    def leave(self, client: str) -> None:
        """Remove a client with its streams and its stepped mode."""
        self._inbox.close(client)
        self._end(client)

    def end_stepping(self, client: str, why: str) -> None:
        """End the stepped mode of a client that is silent, so that the simulation goes on."""
        session = self.sessions.get(client)
        if session is None or not session.is_stepping:
            return
        for react in self._watchers.stepping_lost:
            react(client)
        logger.warning("client %s steps no more: %s", session.name, why)
        session.lose_stepping(f"the server ended the stepped mode of this client: {why}")

    def abandon_calls(self) -> None:
        """Abandon calls with a step under way, as the server ends."""
        for session in self.sessions.values():
            session.abandon_call()

    def others_wait_for(self, client: str) -> bool:
        """Return whether others wait for the end of a client's call: their messages, or the simulation that they use.

        Those who only look on do not count, nor does the simulation of a client that steps it.
        """
        if self._inbox.has_something_of_others(client):
            return True
        session = self.sessions.get(client)
        if self._simulation.state is not SimulationState.RUNNING or (session and session.is_stepping):
            return False
        return any(each is not session and not each.is_onlooker for each in self.sessions.values())

    def report_dropped(self, _max_wait: float = 0.0) -> bool:
        """Report dropped messages to their clients, so that flooding cannot fill the memory unnoticed.

        A stage of a turn, which goes on.
        """
        if self._inbox.dropped:
            limits = self._simulation.limits
            for (client, name), count in self._inbox.take_dropped().items():
                self._metrics.lost(count)
                if session := self.sessions.get(client):
                    session.has_lost(count, str(limits.reached(name, "wait for answers now and then")))
        return False

    def script_stopped(self, problem: str) -> None:
        """Report an error of a script, or of a simulation step, to every client: no single call has caused it."""
        if self._world.parameters.error_report_mode & sim_api_errormessage_report:
            for session in self.sessions.values():
                # The error of a call that waited is there already.
                if not (session.errors and session.errors[-1].endswith(problem)):
                    session.errors.append(problem)

    def run_stopped(self) -> None:
        """End stepped mode of every client, which must enable it again for each run.

        If the run cannot continue, the calls that wait for its steps fail.
        """
        if failure := self._simulation.failure:
            for session in self.sessions.values():
                session.fail_triggers(failure)
        for session in self.sessions.values():
            session.set_stepping(False)

    def _end(self, client: str) -> None:
        session = self.sessions.pop(client, None)
        if session is None:
            return
        self.departed.append(
            Departed(
                client,
                session.name,
                session.port,
                session.may_only_read,
                self._metrics.client_calls.get(client, 0),
                dict(session.called),
                self._metrics.age,
            )
        )
        for react in self._watchers.left:
            react(client)
        session.abandon_call()
        session.set_stepping(False)
        session.streams.clear()  # an awaited image refers to its client: this breaks the cycle
        session.link.close()
        logger.info("client %s left", session.name)
