"""One call of a function of the namespaces of scripts, which may wait for simulation steps.

The client waits for it alone, so its answer says as well what came of things that it has left for later: a start, a
stop, another scene.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Generator, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

from simx_server.service.clients.sessions import ClientSession

from .executor import Executor

if TYPE_CHECKING:
    from simx_server.service.monitoring.log_of_calls import Called

Results = tuple[Any, ...]
Waits = Generator[None, None, Results]
"""Yields once per simulation step, and returns the results."""

_Result = TypeVar("_Result")


class LastingCall:
    """A call under way. Physics thread."""

    def __init__(self, executor: Executor, session: ClientSession, name: str) -> None:
        """Make a call that has not started.

        Args:
            name: of the function, as the client gives it.
        """
        self.name = name
        self._executor, self._session = executor, session
        self._rest: Waits | None = None
        self._problem: Exception | None = None
        """Why it waits in vain."""

        self._noted: Called | None = None

    def begin(self, counted: str, noted: str, arguments: Sequence[Any], *, only_reads: bool) -> None:
        """Count the call, and note it for the history.

        Args:
            counted: the name under which the client's calls are counted.
            noted: the name that the history has.
        """
        self._executor.metrics.called(self._session.client, 1)
        self._session.called[counted] += 1
        if self._executor.log_of_calls is not None:
            self._noted = self._executor.note(self._session, noted, arguments, None, only_reads=only_reads)

    @property
    def is_waiting(self) -> bool:
        """Return whether it waits for a simulation step."""
        return self._rest is not None

    def run(self, function: Callable[[], Results | Waits]) -> Results | None:
        """Run the function until it ends, or waits for a simulation step.

        Returns:
            The results; None if it waits.

        Raises:
            Exception: what the function raises.
        """
        outcome = self._timed(function)
        if not isinstance(outcome, Generator):
            return outcome
        self._rest = outcome
        return self.go_on()

    def go_on(self) -> Results | None:
        """Continue it because a simulation step was made, or none will come for a while; as `run`."""
        rest, problem, self._problem = self._rest, self._problem, None
        assert rest is not None
        try:
            self._timed(lambda: rest.throw(problem) if problem else next(rest))
        except StopIteration as end:
            self._rest = None
            return end.value
        except Exception:
            self._rest = None
            raise
        return None

    def wait_for(self, rest: Waits) -> None:
        """Wait for the work that has started already."""
        self._rest = rest

    def fail(self, problem: Exception) -> None:
        """Have it fail when it is continued, if it waits: no simulation step comes."""
        if self.is_waiting:
            self._problem = problem

    def abandon(self) -> Waits | None:
        """Forget what waits, and return it: the client has left, or says good-bye."""
        rest, self._rest, self._problem = self._rest, None, None
        return rest

    def answered(self, status: int, values: Sequence[Any]) -> None:
        """Note the answer for the history."""
        if self._noted is not None:
            self._noted.finish(status, values)
            self._noted = None

    def settled(self) -> Exception | None:
        """Do what the call has left for later; return why that has failed, if it has."""
        simulation = self._executor.world.simulation
        problems = [] if simulation.is_settled else simulation.settle()
        return problems[0] if problems else None

    def _timed(self, piece: Callable[[], _Result]) -> _Result:
        """Run a piece of it, which is timed, and is what the server is busy with."""
        executor = self._executor
        outer, began = executor.begin(self._session.client, self.name), time.perf_counter()
        try:
            return piece()
        finally:
            executor.metrics.executed(self.name, time.perf_counter() - began)
            executor.end(outer)
