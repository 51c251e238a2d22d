"""Keep the last minutes of a run, within bounds of time and memory. Physics thread only."""

from __future__ import annotations

from bisect import bisect_left
from operator import attrgetter
from typing import TYPE_CHECKING

from simx_server.errors import CommandError
from simx_server.service.monitoring.log_of_calls import CallsOfStep, LogOfCalls
from simx_server.service.watcher import Watcher

from .moments import Moment, take

if TYPE_CHECKING:
    from simx_server.scene.editing.twins import Twins
    from simx_server.service.service import Service

SECONDS = 120.0
"""Simulated seconds that are kept while a web viewer is open."""

_NONE = CallsOfStep((), 0, 0, False)
_STEP = attrgetter("step")


class History(Watcher):
    """The moments of the present run, or of the last one, in order; and the calls of clients before each.

    It is kept while a client wants it, or always.
    """

    def __init__(self, service: Service, seconds: float | None = None) -> None:
        """Make an empty history.

        Args:
            seconds: simulated seconds to keep also while no client wants a history; None: nothing then; 0: never any.
        """
        self._service = service
        self._world, self._sim = service.world, service.simulation
        self._always = seconds
        self.seconds = SECONDS if seconds is None else seconds
        self._wanted_by: set[str] = set()
        self._moments: list[Moment] = []
        self._calls: list[CallsOfStep] = []
        """Those before each of the moments."""

        self._size = self._size_of_calls = 0
        self._log = LogOfCalls()
        self._handle_at_start = self._sim.scene.next_handle
        self.version = 0
        """Changes when moments that were kept are gone, other than the oldest ones."""

        self._watch()

    # --- who wants it ----------------------------------------------------------------------------

    def want(self, client: str, wanted: bool) -> None:
        """Keep a history for a client until it does not want it any more, or has left."""
        if wanted:
            self._wanted_by.add(client)
        else:
            self._wanted_by.discard(client)
        self._watch()

    @property
    def is_kept(self) -> bool:
        """Return whether the following steps are kept."""
        return self.seconds > 0 and (self._always is not None or bool(self._wanted_by))

    @property
    def log(self) -> LogOfCalls:
        return self._log

    def _watch(self) -> None:
        """Have the server loop note calls, or not."""
        self._service.executor.note_in(self._log if self.is_kept else None)

    def _forget_those_who_left(self) -> None:
        if self._wanted_by and not self._wanted_by <= self._service.clients.sessions.keys():
            self._wanted_by &= self._service.clients.sessions.keys()
            self._watch()

    # --- what is kept ----------------------------------------------------------------------------

    @property
    def steps(self) -> tuple[int, int] | None:
        """Return the first and the last step that is kept; None: none is. Steps between them may be missing."""
        return (self._moments[0].step, self._moments[-1].step) if self._moments else None

    @property
    def size(self) -> int:
        """Return about how many bytes are kept."""
        return self._size + self._size_of_calls

    @property
    def handle_at_start(self) -> int:
        """Return the handle that the next new object had when the run started."""
        return self._handle_at_start

    def moment(self, step: int) -> Moment:
        """Return the moment of a step. Raises CommandError: it is not kept."""
        return self._moments[self._place(step)]

    def before(self, step: int) -> Moment | None:
        """Return the moment of the step before a step that is kept; None: it is not kept."""
        place = self._place(step)
        moment = self._moments[place - 1] if place else None
        return moment if moment is not None and moment.step == step - 1 else None

    def calls(self, step: int) -> CallsOfStep:
        """Return the calls that belong to a step. Raises CommandError: the step is not kept."""
        return self._calls[self._place(step)]

    def nearest(self, step: int) -> int:
        """Return the last kept step up to this one, or the first one. Raises CommandError: none is kept."""
        if not self._moments:
            raise CommandError(self._nothing())
        place = bisect_left(self._moments, step + 1, key=_STEP)
        return self._moments[max(0, place - 1)].step

    def find_change(self, step: int, direction: int) -> int:
        """Return the nearest step with a call that changes something, before (-1) or after (1) a kept one; -1: none.

        Raises:
            CommandError: the step is not kept.
        """
        place = self._place(step) + direction
        while 0 <= place < len(self._moments):
            if self._calls[place].has_changes:
                return self._moments[place].step
            place += direction
        return -1

    def cut(self, step: int) -> None:
        """Forget all moments after a step: a new run goes on from it."""
        place = self._place(step) + 1
        for moment, calls in zip(self._moments[place:], self._calls[place:], strict=True):
            self._size -= moment.size
            self._size_of_calls -= calls.size
        del self._moments[place:], self._calls[place:]
        self._log.take()
        self.version += 1

    def _place(self, step: int) -> int:
        place = bisect_left(self._moments, step, key=_STEP)
        if place == len(self._moments) or self._moments[place].step != step:
            raise CommandError(self._nothing() if not self._moments else self._missing(step))
        return place

    def _missing(self, step: int) -> str:
        first, last = self._moments[0].step, self._moments[-1].step
        return f"step {step} is not kept; kept are steps {first} to {last}; choose one of them"

    def _nothing(self) -> str:
        if self.seconds <= 0:
            return "no step is kept, because the server was started with --history 0; choose more seconds"
        return (
            "no step is kept; steps are kept while a web viewer is open, or with simx-server --history SECONDS; "
            "start the simulation"
        )

    # --- events ----------------------------------------------------------------------------------

    def run_starting(self) -> None:
        if not self._sim.is_going_back:
            self.clear()
            self._handle_at_start = self._sim.scene.next_handle

    def run_started(self) -> None:
        if not self._sim.is_going_back and self.is_kept:
            self._keep(_NONE)

    def step_finished(self) -> None:
        if self._wanted_by:
            self._forget_those_who_left()
        if self._service.executor.log_of_calls is not None:
            self._keep(self._log.take())

    def awaits_steps(self) -> bool:
        return bool(self._wanted_by) or self._service.executor.log_of_calls is not None

    def scene_changed(self) -> None:
        self.clear()

    def model_changed(self, twins: Twins | None) -> None:
        if not self._sim.is_running and twins is not None:
            self.clear()  # an edit while the simulation is stopped: its model belongs to no moment

    def clear(self) -> None:
        """Forget everything."""
        if self._moments:
            self.version += 1
        self._moments.clear()
        self._calls.clear()
        self._log.take()
        self._size = self._size_of_calls = 0

    def _keep(self, calls: CallsOfStep) -> None:
        before = self._moments[-1] if self._moments else None
        moment = take(self._world, before)
        self._moments.append(moment)
        self._calls.append(calls)
        self._size += moment.size
        self._size_of_calls += calls.size
        self._drop_old(moment.step)

    def _drop_old(self, newest: int) -> None:
        """Forget the oldest moments beyond the seconds or the memory, and the oldest calls beyond theirs."""
        limits = self._sim.limits
        oldest = newest - round(self.seconds / self._sim.time_step)
        dropped = 0
        count = len(self._moments)
        while dropped < count - 1 and (self._moments[dropped].step < oldest or self._size > limits.history):
            self._size -= self._moments[dropped].size
            self._size_of_calls -= self._calls[dropped].size
            dropped += 1
        if dropped:
            del self._moments[:dropped], self._calls[:dropped]
        place = 0
        while self._size_of_calls > limits.history_calls and place < len(self._calls):
            calls = self._calls[place]
            if calls.calls:
                self._size_of_calls -= calls.size
                self._calls[place] = CallsOfStep((), calls.left_out + len(calls.calls), 0, calls.has_changes)
            place += 1
