"""The end of the server: by a signal or a script, or on request of a client after the others have left."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from typing import TYPE_CHECKING

from simx_server.simulation.simulation import Simulation

from .queue.inbox import Inbox
from .watcher import Watcher

if TYPE_CHECKING:
    from .calls.executor import Executor
    from .clients.sessions import ClientSession

logger = logging.getLogger(__name__)


class QuitAfterStop(Watcher):
    """``--quit-after-stop``: the server ends with its first run, unless a new one goes on from a step of it."""

    def __init__(self, ending: Ending, simulation: Simulation) -> None:
        self._ending, self._simulation = ending, simulation

    def run_stopped(self) -> None:
        if not self._simulation.is_going_back:
            self._ending.request()


class Ending(Watcher):
    """Whether the server ends. Physics thread, except where a method says so."""

    def __init__(
        self,
        simulation: Simulation,
        inbox: Inbox,
        sessions: Mapping[str, ClientSession],
        executor: Executor,
    ) -> None:
        """Start without an end.

        Args:
            executor: knows whose call is being executed.
        """
        self._simulation, self._inbox, self._sessions = simulation, inbox, sessions
        self._executor = executor
        self._asked_by: str | None = None
        self.has_come = False

    def request(self) -> None:
        """End as soon as the present piece of work is done. Any thread."""
        self._simulation.give_up()  # long-running work reads this, and may contain no call of ours for a while
        self._inbox.post(self.now)

    def now(self) -> None:
        """End: no call is executed any more."""
        self._simulation.give_up()
        self.has_come = True

    def when_left(self) -> None:
        """End on request of the client that is being served, after the others have left."""
        self._asked_by = self._executor.client or None
        if self._asked_by is None:  # a script of the operator
            self.request()
        elif others := self._end_if_left():
            text = f"the server ends when these clients have left: {', '.join(others)}"
            logger.info("%s", text)
            if session := self._sessions.get(self._asked_by):
                session.errors.append(text)

    def left(self, client: str) -> None:
        self._end_if_left()

    def _end_if_left(self) -> list[str]:
        """End, if a client has requested it and no other is connected. Return the names of the others."""
        others = [
            session.name
            for session in self._sessions.values()
            if session.client != self._asked_by and not session.is_onlooker
        ]
        if self._asked_by is not None and not others:
            self.request()
        return others
