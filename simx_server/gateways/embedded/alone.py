"""The simulation step of a client that is alone: made at once, without a turn of the loop.

A turn first asks which other clients wait for a step or have sent something. If it is known that there are none, the
step is the same round of the loop (`service/rounds.py`): streams, watchers and counters notice it as any other step.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from time import perf_counter
from typing import TYPE_CHECKING

from simx_client.protocol.commands import TRIGGER
from simx_server.service.answers.answers import DONE, Answer
from simx_server.simulation.simulation import SimulationState

if TYPE_CHECKING:
    from simx_server.joints.stepping.apart import Apart, Made
    from simx_server.service.calls.direct import DirectCall
    from simx_server.service.clients.sessions import ClientSession
    from simx_server.service.service import Service

    from .turns import Turns

_RUNNING = SimulationState.RUNNING


class Alone:
    """Makes the steps of one client. Within a turn."""

    def __init__(self, service: Service, turns: Turns, session: ClientSession) -> None:
        self._turns, self._session, self._sessions = turns, session, service.clients.sessions
        self._simulation, self._queue, self._due = service.simulation, service.queue, service.due
        self._busy, self._rounds, self._executor = service.busy, service.rounds, service.executor
        self._watchers, self._world = service.watchers, service.world
        self._answer = DONE

    @property
    def is_alone(self) -> bool:
        """Return whether a trigger of the client makes a step at once, and nothing comes before or behind it.

        Otherwise interrupted batches of clients, or messages in the queue, may wait for a step.
        """
        session = self._session
        return (
            session.is_waiting
            and self._simulation.state is _RUNNING
            and len(self._sessions) == 1
            and self._executor.log_of_calls is None
            and not self._turns.has_gateways
            # Images of streams are awaited, and they have to be made by then.
            and not session.streams.single
            and session.interrupted is None
            and not session.before_trigger
            and not self._queue.has_work()
            and not self._due.is_paced
            and not self._simulation.parts.holds_step()
        )

    def step(self, call: DirectCall) -> Answer:
        """Make the step if `is_alone`; return the answer to the trigger.

        Args:
            call: that of the trigger, which counts it.
        """
        return self.finish(call, self._world.step)

    def finish(self, call: DirectCall, step: Callable[[], object]) -> Answer:
        """Make the step as `step`; the argument `step` makes what is left of it."""
        self._begin(call)
        outer = self._busy.begin()
        try:
            self._rounds.finish_step(step)
        finally:
            self._busy.go_back_to(outer)
        return self._end()

    def step_apart(self, call: DirectCall) -> Generator[Apart, Made, Answer]:
        """Make the step as `step`; the caller makes the physics that needs no Python."""
        self._begin(call)
        outer = self._busy.begin()
        try:
            yield from self._rounds.make_step_apart()
        finally:
            self._busy.go_back_to(outer)
        return self._end()

    @property
    def is_unwatched(self) -> bool:
        """Return whether nothing but the client notices a step: no stream, no watcher, no part of the world."""
        return not (
            self._session.streams.by_id or self._watchers.round_made or self._simulation.parts.await_steps()
        )

    def _begin(self, call: DirectCall) -> None:
        began = call.begin()
        self._answer = DONE
        self._session.add_trigger(self)
        if began is not None:
            call.record(perf_counter() - began)

    def _end(self) -> Answer:
        if not self._session.is_stepping or self._queue.has_work():
            # The run has ended, or a script has asked for more.
            self._turns.note_change()
        return self._answer

    # --- in the place of a future ----------------------------------------------------------------

    def set_result(self, _result: None) -> None:
        """Do nothing: `step` returns the answer."""

    def set_exception(self, problem: BaseException) -> None:
        """Take the reason why the step cannot be made; the client gets it before other errors of the stop."""
        self._answer = self._executor.failure(self._session, TRIGGER, problem)
