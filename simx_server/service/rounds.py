"""Make a round: one simulation step if the simulation advances, the streams in any case, and those who waited go on."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Mapping
from functools import partial
from operator import attrgetter
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from simx_server.joints.stepping.apart import Stepping
    from simx_server.world.world import World

    from .answers.publishing import Publisher
    from .calls.busy import BusyDesk
    from .calls.serving import Serving
    from .calls.waiting import Waiting
    from .clients.sessions import ClientSession
    from .clock import Pacer
    from .due import Due
    from .handling import Handling
    from .monitoring.metrics import Metrics
    from .watcher import Watchers

logger = logging.getLogger(__name__)

_STREAMS = attrgetter("streams.by_id")


class Rounds:
    """Makes the rounds of a loop. Physics thread."""

    def __init__(
        self,
        world: World,
        sessions: Mapping[str, ClientSession],
        pacer: Pacer,
        metrics: Metrics,
        publisher: Publisher,
        waiting: Waiting,
        busy: BusyDesk,
        serving: Serving,
        due: Due,
        handling: Handling,
        watchers: Watchers,
    ) -> None:
        self._world, self._simulation, self._sessions = world, world.simulation, sessions
        self._pacer, self._metrics, self._publisher, self._waiting = pacer, metrics, publisher, waiting
        self._busy, self._serving, self._due = busy, serving, due
        self._handling, self._watchers = handling, watchers

    def release_paced(self, _max_wait: float) -> bool:
        """Continue paced calls if no simulation step will come for a while."""
        if self._waiting.is_for_step and not self._due.is_running_freely:
            self._waiting.end_for_step()
        return False

    def make_due(self, _max_wait: float) -> bool:
        """Make a round if it is due still, and no batch in slices belongs to its step."""
        if self._due.seconds_until_round() <= 0 and not self._waiting.hold_steps:
            outer = self._busy.begin()
            try:
                self.make()
            finally:
                self._busy.go_back_to(outer)
        return True

    def make(self) -> None:
        """Make a round."""
        if self._due.is_advancing:
            self.make_step()
        else:
            self._idle()
            self._end_round(is_advancing=False)

    def make_step(self) -> None:
        """Make a round with a simulation step."""
        self.finish_step(self._world.step)

    def finish_step(self, step: Callable[[], object]) -> None:
        """Make a round with a simulation step.

        Args:
            step: makes what is left of the step.
        """
        self._step(step)
        self._end_round(is_advancing=True)

    def make_step_apart(self) -> Stepping:
        """Make a round with a simulation step, whose physics the caller makes where it needs no Python."""
        began = time.perf_counter()
        try:
            yield from self._world.step_apart()
            self._metrics.passed(self._simulation.time_step, time.perf_counter() - began)
        except KeyboardInterrupt:
            self._interrupted()
            raise
        except Exception as error:
            self._failed(error)
        self._after_step()
        self._end_round(is_advancing=True)

    def count_steps(self, count: int, seconds: float) -> None:
        """Count simulation steps that were made outside, for a client that is alone.

        Args:
            seconds: the time of each.
        """
        self._metrics.passed(self._simulation.time_step, seconds, count)
        self._due.round_made()

    def _end_round(self, *, is_advancing: bool) -> None:
        for react in self._watchers.round_made:
            react(is_advancing=is_advancing)
        self._waiting.count_round()
        self._due.round_made()

    def _step(self, step: Callable[[], object]) -> None:
        try:
            began = time.perf_counter()
            step()
            self._metrics.passed(self._simulation.time_step, time.perf_counter() - began)
        except KeyboardInterrupt:
            self._interrupted()
            raise
        except Exception as error:
            self._failed(error)
        self._after_step()

    def _interrupted(self) -> None:
        """Stop an embedded simulation: a step that is half done cannot be continued."""
        logger.warning("Ctrl-C came within a simulation step, so the simulation is stopped")
        self._handling.handle(self._simulation.stop)

    def _failed(self, error: Exception) -> None:
        logger.exception("the pass failed, so the simulation is stopped")
        problem = f"the pass failed, so the simulation is stopped: {error!r}"
        self._handling.handle(partial(self._simulation.fail, problem))

    def _after_step(self) -> None:
        if self._due.is_paced:
            self._pacer.passed(self._simulation.time_step)
        if any(map(_STREAMS, self._sessions.values())):
            self._publish(after_step=True)
        for session in self._sessions.values():
            # Values read after a trigger are of the new state, including streamed images.
            session.release_triggers(after=session.streams.images_on_the_way())
            session.paced.step_made()
        self._waiting.end_for_step()

    def _idle(self) -> None:
        if self._due.is_idle_wanted:
            self._handling.handle(self._world.idle)
            for idler in self._watchers.idlers:
                self._handling.handle(idler.idle)
        self._publish(after_step=False)

    def _publish(self, *, after_step: bool) -> None:
        self._publisher.publish(
            self._sessions.values(), after_step=after_step, is_bounded=self._serving.may_cut
        )
