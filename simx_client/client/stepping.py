"""Stepped mode: only ``step()`` advances the simulation, with one message per step."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from types import TracebackType
from typing import Generic, TypeVar

from simx_client.calls.strict import Strict
from simx_client.connection.calls import Calls
from simx_client.errors import RemoteError

from .channel import Channel
from .simulation import Simulation, State
from .watching import Watch

T = TypeVar("T")


class Stepping(Strict, Generic[T]):
    """The ``with`` block of ``Client.stepping``. Call the object to make a simulation step."""

    __slots__ = ("_batching", "_before", "_channel", "_simulation", "_watch", "latest")

    def __init__(self, channel: Channel, simulation: Simulation, watch: Callable[[], T]) -> None:
        self._channel, self._simulation = channel, simulation
        self._watch = Watch(channel, watch)
        self._before = State.STOPPED
        self._batching: AbstractContextManager[None] = nullcontext()

    def __repr__(self) -> str:
        batched = (
            f", {self._channel.batched_count} calls set for the next step"
            if self._channel.batched_count
            else ""
        )
        mode = "in stepped mode" if self._channel.is_stepping else "not in stepped mode"
        return f"<Stepping {self._channel.state}, {mode}{batched}>"

    def __enter__(self) -> Stepping[T]:
        """Turn on stepped mode, and start the simulation if it does not run yet."""
        if self._channel.is_stepping:
            raise RuntimeError("this client is stepping already; leave that block before entering another")
        self._before = self._simulation.state
        self._channel.is_stepping = True
        try:
            self._channel.gather(_start)
            self.latest = self._watch.look()
        except BaseException:
            self._end()
            raise
        self._batching = self._channel.batching()
        self._batching.__enter__()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Send the calls set since the last step; then stop, pause or continue the simulation, as before the
        block."""
        try:
            self._batching.__exit__(kind, error, trace)
        finally:
            self._end()

    def __call__(self) -> T:
        """Make one simulation step with everything that was set before it.

        Returns:
            The watched values after this step.

        Raises:
            RemoteError: the server refused a call that was set, or the simulation does not run; the step was
                made if possible.
        """
        return self._make(lambda calls: calls.simxSynchronousTrigger())

    def restart(self) -> T:
        """Stop the simulation, which restores the state of the start, and start it again; one message.

        Returns:
            The watched values before the first step.
        """

        def note(calls: Calls) -> None:
            calls.simxStopSimulation()
            _start(calls)

        return self._make(note)

    latest: T
    """The watched values after the newest step, or before the first one."""

    def _make(self, note: Callable[[Calls], object]) -> T:
        calls = Calls(0, self._channel.where)
        note(calls)
        self._watch.fetch(calls.noted)
        if refused := [answer.failure for answer in calls.noted if answer.code]:
            raise RemoteError(refused)
        self.latest = self._watch.look()
        return self.latest

    def _end(self) -> None:
        self._channel.is_stepping = False

        def note(calls: Calls) -> None:
            if self._before is State.STOPPED:
                calls.simxStopSimulation()
            elif self._before is State.PAUSED:
                calls.simxPauseSimulation()
            calls.simxSynchronous(False)

        self._channel.gather(note)


def _start(calls: Calls) -> None:
    calls.simxSynchronous(True)
    calls.simxStartSimulation()
