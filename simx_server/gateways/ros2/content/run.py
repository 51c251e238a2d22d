"""Start, stop, pause, reset and step the simulation for services; in recordings as calls of the remote API."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from functools import partial
from typing import TYPE_CHECKING, Any, Protocol

from simx_server.errors import CommandError
from simx_server.simulation.simulation import SimulationState

from ..table_call import Call

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation

    from ..client import Ros2Client

START = Call("simxStartSimulation", [])
STOP = Call("simxStopSimulation", [])
PAUSE = Call("simxPauseSimulation", [])

MOST_STEPS = 1_000_000
"""Simulation steps of one request."""

MOST_REQUESTS = 100
"""Requests for steps that are under way or wait for one that is."""


class WrongState(CommandError):
    """The simulation is in a state in which the request has no meaning."""


class Steps:
    """A request for simulation steps that is under way."""

    def __init__(self, count: int, made: Callable[[int], object]) -> None:
        """Make a request.

        Args:
            made: called after each step with the number of steps that were made.
        """
        self.count = self.left = count
        self.made = made
        self.done: Future[None] = Future()


class SpawnedObjects(Protocol):
    """The spawned entities, as far as a reset concerns them; see `standard/spawning.py`."""

    def delete_spawned(self) -> None:
        """Delete all of it."""
        ...

    def orders(self) -> list[Any]:
        """Return what was spawned."""
        ...

    def respawn(self, orders: Sequence[Any], then: Callable[[Sequence[str]], object]) -> None:
        """Spawn again what has gone, and call a function after that with sentences about what failed."""
        ...


class World(Protocol):
    """Whether there is a world; see `standard/worlds.py`."""

    is_loading: bool
    is_unloaded: bool


class Run:
    """The run of the simulation, as services control it. Physics thread."""

    world: World
    spawned: SpawnedObjects
    """Both set when the contents are made (`use`)."""

    def __init__(self, client: Ros2Client, simulation: Simulation) -> None:
        self._client, self._simulation = client, simulation
        self._steps: deque[Steps] = deque()
        """Requests for steps; the first of them is under way."""

    def use(self, world: World, spawned: SpawnedObjects) -> None:
        """Take the world and the spawned entities."""
        self.world, self.spawned = world, spawned

    @property
    def state(self) -> SimulationState:
        """Return the state; a simulation that makes single steps is paused for those who ask."""
        return SimulationState.PAUSED if self._steps else self._simulation.state

    def start(self) -> str:
        """Start, or continue after a pause; return a sentence that says what was done."""
        before = self.state
        if before is SimulationState.RUNNING:
            return "the simulation runs already"
        self._end_steps("the simulation was started")
        self._client.ask(START)
        return "the simulation is started" if before is SimulationState.STOPPED else "the simulation goes on"

    def stop(self) -> str:
        """Stop: the state of the start is restored. Return as `start`."""
        if self.state is SimulationState.STOPPED:
            return "the simulation is stopped already"
        self._client.ask(STOP)
        return "the simulation is stopped"

    def pause(self) -> str:
        """Pause; return as `start`.

        Raises:
            WrongState: the simulation is stopped.
        """
        if self.state is SimulationState.STOPPED:
            raise WrongState("the simulation is stopped, so it cannot be paused; start it first")
        if self._steps:
            self._end_steps("the simulation was paused")
            return "the simulation is paused"
        if self.state is SimulationState.PAUSED:
            return "the simulation is paused already"
        self._client.ask(PAUSE)
        return "the simulation is paused"

    def reset(self) -> str:
        """Restore the state of the start; then run or pause, as before. Return as `start`."""
        before = self.state
        if before is SimulationState.STOPPED:
            return "the simulation is stopped, so it is reset already"
        self._client.ask(STOP)
        self._go_on_as(before)
        return "the simulation is reset"

    def reset_all(self) -> None:
        """Delete what was spawned, and reset. Raises CommandError."""
        before = self.state
        if before is not SimulationState.STOPPED:
            self._client.ask(STOP)
        self.spawned.delete_spawned()
        self._go_on_as(before)

    def reset_but_spawned(self) -> Future[None]:
        """Reset, but keep what was spawned: what the stop takes is spawned again.

        The future is done then; it has a CommandError if something is missing.
        """
        before, done = self.state, Future[None]()
        if before is SimulationState.STOPPED:
            done.set_result(None)
            return done
        orders = self.spawned.orders()
        self._client.ask(STOP)

        def go_on(failures: Sequence[str]) -> None:
            try:
                self._go_on_as(before)
                if failures:
                    raise CommandError("; ".join(failures[:10]))
            except CommandError as problem:
                done.set_exception(problem)
            else:
                done.set_result(None)

        self.spawned.respawn(orders, go_on)
        return done

    def _go_on_as(self, before: SimulationState) -> None:
        calls = {SimulationState.PAUSED: (START, PAUSE), SimulationState.RUNNING: (START,)}
        for call in calls.get(before, ()):
            self._client.ask(call)

    def step(self, count: int) -> Future[None]:
        """Make simulation steps and pause again; return a future that is done then, or has a CommandError.

        Raises as `request`.
        """
        return self.request(count).done

    def request(self, count: int, made: Callable[[int], object] = lambda _: None) -> Steps:
        """Have simulation steps made; return the request.

        Args:
            made: called after each step with the number of steps that were made.

        Raises:
            WrongState: the simulation is not paused.
            CommandError: the count is not valid, or too many requests wait.
        """
        if not 0 < count <= MOST_STEPS:
            raise CommandError(f"a number of steps is from 1 to {MOST_STEPS}, not {count}")
        if self.state is not SimulationState.PAUSED:
            raise WrongState(
                f"single steps are made while the simulation is paused, and it is {self.state.value}; "
                f"{'pause' if self.state is SimulationState.RUNNING else 'start and pause'} it first"
            )
        if len(self._steps) >= MOST_REQUESTS:
            raise CommandError(
                f"{MOST_REQUESTS} requests for steps wait already; ask again when they are answered"
            )
        steps = Steps(count, made)
        self._steps.append(steps)
        if len(self._steps) == 1:
            self._go_on()
        return steps

    def give_up(self, steps: Steps) -> None:
        """End a request before all of its steps are made; its future has a CommandError."""
        if steps not in self._steps:
            return
        is_first = self._steps[0] is steps
        self._steps.remove(steps)
        if is_first and self._steps:
            self._go_on()
        elif is_first:
            self._client.session.set_stepping(False)
            self._client.ask(PAUSE)
        steps.done.set_exception(CommandError("the steps were canceled"))

    def _go_on(self) -> None:
        """Have the next simulation step made."""
        session = self._client.session
        session.set_stepping(True)
        if self._simulation.state is SimulationState.PAUSED:
            self._client.ask(START)
        if self._steps:  # the start may have failed, and the simulation be stopped
            session.trigger(is_running=True)

    def step_finished(self) -> None:
        """Be told of a simulation step; what follows waits until it is recorded."""
        if self._steps:
            self._client.post(partial(self._count, self._steps[0]))

    def _count(self, first: Steps) -> None:
        if not self._steps or self._steps[0] is not first:
            return  # it was interrupted meanwhile
        first.left -= 1
        first.made(first.count - first.left)
        if first.left:
            self._go_on()
            return
        self._steps.popleft()
        if self._steps:
            first.done.set_result(None)
            self._go_on()
            return
        self._client.session.set_stepping(False)
        self._client.ask(PAUSE)
        first.done.set_result(None)

    def run_paused(self) -> None:
        """Be told of a pause."""
        self._interrupt("the simulation was paused by another client before all steps were made")

    def run_stopped(self) -> None:
        """Be told of a stop."""
        failure = self._simulation.failure
        self._interrupt(failure or "the simulation was stopped before all steps were made")

    def _end_steps(self, why: str) -> None:
        """End the requests for steps; the simulation is paused then."""
        if self._steps:
            self._interrupt(f"{why} before all steps were made")
            self._client.ask(PAUSE)

    def _interrupt(self, why: str) -> None:
        """Answer the requests for steps that are under way, which no step follows any more."""
        steps, self._steps = self._steps, deque()
        if not steps:
            return
        self._client.session.set_stepping(False)
        for each in steps:
            each.done.set_exception(CommandError(why))
