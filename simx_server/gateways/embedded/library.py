"""The functions of scripts for a program in this process, which calls them as those of the simulator's C library.

The program is a client as those of the ZeroMQ remote API: it has a session, and a script without text whose namespaces
it uses. Every run is stepped by it.
"""

from __future__ import annotations

import time
from collections.abc import Generator
from typing import Any, cast

from simx_server.errors import CommandError
from simx_server.limits import LimitReached
from simx_server.scripting.interpreter import Waiting
from simx_server.service.loop import ServerLoop
from simx_server.service.watcher import Watcher
from simx_server.simulation.simulation import SimulationState

from ..zmq.calls import invoke
from ..zmq.clients import FIRST_HANDLE, ZmqClients
from ..zmq.peer import Peer
from .turns import Turns

_CONNECTION = 1
_FIRST_HANDLE = FIRST_HANDLE + 1_000_000
"""Clients of a ZeroMQ gateway may be there too."""

_WAITED = 0.001
"""Seconds until a thread that waits for other clients checks again whether it can make the step."""

_RUNNING = SimulationState.RUNNING


class Library(Watcher):
    """A ``simx_client.transport.direct.Library``. Any thread calls it; each call takes a turn."""

    def __init__(self, loop: ServerLoop, turns: Turns, client: str, name: str) -> None:
        """Join the server.

        Args:
            client: the client's id, which also gives its role.
            name: the client's name, for logs and lists.

        Raises:
            LimitReached: all places for clients are taken.
        """
        self._loop, self._turns, self._service = loop, turns, loop.service
        self._simulation = loop.service.simulation
        self._answers: list[dict[str, Any]] = []
        self._clients = ZmqClients(
            self._service,
            {_CONNECTION: Peer(_CONNECTION)},
            lambda _peer, answer: self._answers.append(answer),
            first_handle=_FIRST_HANDLE,
        )
        turns.begin()
        try:
            self._client = self._clients.join(client, name, 0)
            self._service.watchers.add(self)
            turns.note_change()
        except LimitReached:
            self._service.watchers.remove(self._clients)
            raise
        finally:
            turns.end()

    # --- calls -----------------------------------------------------------------------------------

    def call(self, function: str, arguments: list[Any]) -> tuple[Any, ...]:
        """Call a function by its full name (``sim.getObjectHandle``); return its results.

        Args:
            arguments: plain values, as `scripting.interpreter` describes them.

        Raises:
            CommandError: the function does not exist or fails; the text gives the reason.
        """
        self._begin()
        try:
            if self._service.watchers.need_whole_batches:
                return self._by_message(function, arguments)
            state = self._simulation.state
            outcome = invoke(self._client, function, arguments)
            if isinstance(outcome, Generator):
                outcome = self._finish(outcome)
            self._settle()
            self._client.session.called[function] += 1
            if self._simulation.state is not state:
                self._turns.note_change()
            return outcome
        finally:
            self._turns.end()

    def _begin(self) -> None:
        if not self._turns.begin():
            raise CommandError("a call within a simulation step of this thread cannot be answered")

    def _finish(self, waiting: Waiting) -> tuple[Any, ...]:
        """Make the simulation steps that a function waits for; return its results."""
        while True:
            try:
                next(waiting)
            except StopIteration as end:
                return end.value
            if not self._advance():
                self._give_way()

    def _settle(self) -> None:
        """Do what a call has left for later, such as a start. Raises CommandError: it has failed."""
        if not self._simulation.is_settled:
            for problem in self._simulation.settle():
                raise problem

    def _by_message(self, function: str, arguments: list[Any]) -> tuple[Any, ...]:
        """Make a call in the form of a message, which a recording contains."""
        from cbor2 import dumps  # of the extra; only recordings need it

        payload = dumps({"func": function, "args": arguments})
        self._answers.clear()
        self._clients.serve(self._client.key, _CONNECTION, payload)
        while not self._answers:
            self._advance()
        self._turns.note_change()
        answer = self._answers.pop()
        if (problem := answer.get("err")) is not None:
            raise CommandError(str(problem))
        return tuple(cast("list[Any]", answer["ret"]))

    # --- steps -----------------------------------------------------------------------------------

    def step(self, *, if_running: bool) -> None:
        """Make one simulation step if the simulation runs; else let regular work have its turn, such as the scripts'.

        Args:
            if_running: False makes no step in any case.

        Raises:
            CommandError: the run has ended because it could not go on; the text gives the reason.
        """
        self._begin()
        try:
            if if_running and self._simulation.state is _RUNNING:
                self._advance()
                if failure := self._simulation.failure:
                    raise CommandError(failure)
            else:
                self._loop.turn()
        finally:
            self._turns.end()

    def _advance(self) -> bool:
        """Make a simulation step, for which others may have to be awaited; return whether one was made."""
        simulation, session, loop = self._simulation, self._client.session, self._loop
        before = simulation.step_count
        session.allow_steps(True)
        try:
            while simulation.state is _RUNNING and simulation.step_count == before:
                loop.turn()
                if simulation.step_count == before and self._service.due.seconds_until_round() > 0.0:
                    self._give_way()
        finally:
            session.allow_steps(False)
        has_advanced = simulation.step_count != before
        if not has_advanced:
            loop.turn()
        return has_advanced

    def _give_way(self) -> None:
        """Let others have their turn while clients that step have not triggered yet."""
        self._turns.end()
        try:
            time.sleep(_WAITED)
        finally:
            self._turns.begin()

    def run_started(self) -> None:
        """Have the run wait for this program's steps: a stop has ended the stepped mode of every client."""
        self._client.level = 1
        self._client.set_stepping()

    # --- the end ---------------------------------------------------------------------------------

    def close(self) -> None:
        """Leave the server. Idempotent."""
        if self._client.key not in self._service.clients.sessions or not self._turns.begin():
            return
        try:
            self._service.watchers.remove(self)
            self._service.watchers.remove(self._clients)
            self._service.clients.leave(self._client.key)
        finally:
            self._turns.end()
