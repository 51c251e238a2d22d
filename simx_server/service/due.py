"""Decide when the next round of the loop is due: a simulation step, or only streams and regular work.

This is where pacing is decided for steps: the clock (`clock.py`) while the simulation runs freely, the triggers of
stepped clients, a film that holds steps. `calls/pacing.py` decides which calls wait for a step.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from operator import attrgetter
from typing import TYPE_CHECKING

from simx_server.simulation.simulation import SimulationState

if TYPE_CHECKING:
    from simx_server.world.world import World

    from .clients.returning import Returning
    from .clients.sessions import ClientSession
    from .clock import Pacer
    from .watcher import Watchers

IDLE_INTERVAL = 0.02
"""Seconds between two executions of the streams while no simulation step is due."""

HELD = 0.002
"""Seconds until a held simulation step (`Part.holds_step`) is checked again."""

_RUNNING = SimulationState.RUNNING

_STREAMS, _IS_STEPPING = attrgetter("streams.by_id"), attrgetter("is_stepping")
_WANTS_IDLE = attrgetter("wants_idle")
"""Each turn asks for these; a generator would take three times as long."""


class Due:
    """Knows what the next round waits for. Physics thread."""

    def __init__(
        self,
        world: World,
        sessions: Mapping[str, ClientSession],
        pacer: Pacer,
        returning: Returning,
        watchers: Watchers,
    ) -> None:
        self._world, self._simulation, self._sessions = world, world.simulation, sessions
        self._pacer, self._returning, self._watchers = pacer, returning, watchers
        self._next_idle_round = 0.0
        self.is_paced = False
        """Whether simulation steps follow the wall clock at present."""

    @property
    def is_running_freely(self) -> bool:
        """Return whether simulation steps follow automatically: no client steps, and the simulation is running."""
        if self._simulation.state is not _RUNNING:
            return False
        return True not in map(_IS_STEPPING, self._sessions.values())

    @property
    def is_waiting_for_trigger(self) -> bool:
        """Return whether a running simulation waits until stepped clients trigger (parameter 45)."""
        return self._simulation.state is _RUNNING and bool(self._is_waiting_for_trigger())

    def _is_waiting_for_trigger(self) -> bool | None:
        """Return whether stepped clients have to trigger; None: there are none."""
        is_waiting = None
        for session in self._sessions.values():  # `any` takes three times as long
            if session.is_stepping:
                if session.is_waiting:
                    return True
                is_waiting = False
        return is_waiting

    @property
    def is_advancing(self) -> bool:
        """Return whether the next round makes a simulation step."""
        return self._simulation.state is _RUNNING and not self.is_waiting_for_trigger

    @property
    def is_idle_wanted(self) -> bool:
        """Return whether there is regular work for a simulation that is stopped or paused."""
        if self._simulation.state is _RUNNING:
            return False
        return self._world.scripts.phases.want_idle or any(map(_WANTS_IDLE, self._watchers.idlers))

    def seconds_until_round(self) -> float:
        """Return the seconds until a round is due, if nothing arrives before; infinity for none."""
        if self._simulation.state is _RUNNING:
            is_waiting = self._is_waiting_for_trigger()
            if is_waiting is None:
                if self._returning.is_awaiting and (awaited := self._returning.seconds_left()) > 0:
                    return awaited
                if not self.is_paced:
                    self.is_paced = True
                    self._pacer.restart()  # the time of a stop, a pause or stepped mode is not caught up
                if (left := self._pacer.seconds_left()) > 0 or not math.isinf(self._pacer.speed):
                    return left
                return HELD if self._simulation.parts.holds_step() else 0.0
            self.is_paced = False
            if not is_waiting:
                return HELD if self._simulation.parts.holds_step() else 0.0
        else:
            self.is_paced = False
            if self.is_idle_wanted:
                return max(0.0, self._next_idle_round - time.monotonic())
        if any(map(_STREAMS, self._sessions.values())):
            return max(0.0, self._next_idle_round - time.monotonic())
        return math.inf

    def are_streams_due(self) -> bool:
        """Return whether streams are to be computed now, although no simulation step is made."""
        return (
            time.monotonic() >= self._next_idle_round
            and not self.is_running_freely
            and any(map(_STREAMS, self._sessions.values()))
        )

    def round_made(self) -> None:
        """Note that a round was made."""
        self._next_idle_round = time.monotonic() + IDLE_INTERVAL
