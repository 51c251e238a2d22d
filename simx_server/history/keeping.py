"""Keep the last moments of the world where a crash of this process does not reach them: in a `Journal`.

After each simulation step one moment is written; while the simulation stands still, one after changes. The state before
the present run is kept beside them, because the end of the run restores it.
"""

from __future__ import annotations

import logging
import time
from typing import TYPE_CHECKING

import mujoco

from simx_server.service.watcher import Watcher

from .journal import Block, Journal
from .moments import Moment, take
from .packing import NotPackable
from .writing import First, Kind, Run, Writer

if TYPE_CHECKING:
    from simx_server.service.service import Service

logger = logging.getLogger(__name__)

KEPT = 3
"""Moments of a run that are kept, beside the state before it; only the last one if they are large."""

LARGE = 64 << 20
"""Bytes of the journal above which they are large."""

LEAST = 16 << 20
"""Bytes of the journal above which the keeper writes it again, with the needed blocks only."""

SLOW = 0.005
"""Seconds of processor time for a moment above which `SHARE` also limits what clients cause."""

SHARE = 0.1
"""Maximum share of the time for writing steps that no client triggers, and the same for writing edited models. So the
keeper omits steps only of a simulation that is much faster than real time, and moments of a model that it has not
written yet.
"""


class Keeper(Watcher):
    """Writes moments of a server's world into a journal. Physics thread only."""

    def __init__(self, service: Service, journal: Journal) -> None:
        """Note the scene, which has just been loaded; `start` writes."""
        self._service, self._journal = service, journal
        self._world, self._sim = service.world, service.simulation
        self.first = First.of(self._sim.scene, self._sim.model)
        names = tuple(type(part).__name__ for part in self._sim.parts.remembering)
        self._writer = Writer(self.first, names)
        self._base: Moment | None = None
        self._last: Moment | None = None
        self._blocks: list[tuple[Block, set[int]]] = []
        """That of the state before the run, and those of the last moments; with the sections that they use."""

        self._turn_at = LEAST
        self._models_due = self._due = 0.0
        self._complaint = ""

    def start(self, base: Moment | None = None) -> None:
        """Replace what the journal has by the present world, and write from now on.

        Args:
            base: of a recovered run, the state before it.
        """
        self._base = self._last = base or take(self._world, None)
        try:
            self._blocks = [self._block(Kind.STOPPED, self._base)]
            if self._sim.is_running:
                self._last = take(self._world, self._base)
                self._blocks.append(self._block(Kind.STEP, self._last))
            self._turn()
        except (NotPackable, OSError) as problem:
            self._complain(str(problem))
        self._service.watchers.add(self)

    # --- when to write ---------------------------------------------------------------------------

    def look(self) -> None:
        """Write a moment if the world has changed while no step is due."""
        if not self._service.due.is_running_freely:
            self._keep_in_time(SLOW)

    def run_starting(self) -> None:
        self._keep()

    def run_started(self) -> None:
        self._keep()

    def step_finished(self) -> None:
        # A client that steps the simulation counts its steps.
        self._keep_in_time(0.0 if self._service.due.is_running_freely else SLOW)

    def run_stopped(self) -> None:
        self._keep()

    # --- how -------------------------------------------------------------------------------------

    def _keep_in_time(self, free: float) -> None:
        """Write the present world, unless that takes too much of the time.

        Args:
            free: seconds of processor time that do not count.
        """
        if time.perf_counter() < self._due:
            return
        began = time.thread_time()  # on a busy machine the wall clock counts the work of others too
        self._keep()
        if (seconds := time.thread_time() - began) > free:
            self._due = _due(seconds)

    def _keep(self) -> None:
        """Write the present world, unless it is the one that was written last."""
        if self._sim.is_going_back or not self._may_write(self._sim.model):
            return
        moment = take(self._world, self._last)
        try:
            block, used = self._block(Kind.STEP if self._sim.is_running else Kind.STOPPED, moment)
            if self._blocks and block == self._blocks[-1][0]:
                return
            for each in (*self._writer.unwritten, block):
                self._journal.append(each)
            self._writer.unwritten.clear()
            self._note(moment, block, used)
            if self._journal.size > self._turn_at:
                self._turn()
        except (NotPackable, OSError) as problem:
            self._complain(str(problem))

    def _block(self, kind: Kind, moment: Moment) -> tuple[Block, set[int]]:
        try:
            return self._writer.block(kind, moment, self._run())
        finally:
            if self._writer.seconds:
                self._models_due = _due(self._writer.seconds)
                self._writer.seconds = 0.0

    def _run(self) -> Run:
        sim, sessions = self._sim, self._service.clients.sessions
        clients = self._service.returning.awaited()
        clients |= {client: (each.name, each.is_stepping) for client, each in sessions.items()}
        return sim.state.value, sim.time_step, sim.physics_step, sim.scene_is_of_client, clients

    def _note(self, moment: Moment, block: Block, used: set[int]) -> None:
        self._last = moment
        if block.kind == Kind.STOPPED:
            self._base = moment
            self._blocks.clear()
        elif self._blocks[-1][0][:2] == block[:2]:  # the same step, after further calls
            self._blocks.pop()
        self._blocks.append((block, used))
        kept = KEPT if self._journal.size < LARGE else 1
        del self._blocks[1 : len(self._blocks) - kept]

    def _may_write(self, model: mujoco.MjModel) -> bool:
        """Return whether this model is written, or may be now."""
        written = (self.first.model, *(each.model for each in (self._base, self._last) if each is not None))
        return any(model is each for each in written) or time.perf_counter() >= self._models_due

    def _turn(self) -> None:
        """Write the journal again, with the needed blocks only."""
        used = {key for _, keys in self._blocks for key in keys}
        self._journal.restart([*self._writer.keep_only(used), *(block for block, _ in self._blocks)])
        self._writer.unwritten.clear()
        self._turn_at = max(LEAST, 2 * self._journal.size)

    def _complain(self, problem: str) -> None:
        """Log, once, that moments cannot be kept."""
        if problem != self._complaint:
            self._complaint = problem
            logger.warning(
                "the simulation cannot be kept as it is now, so a crash would lose what follows: %s", problem
            )


def _due(seconds: float) -> float:
    """Return when the next work of a kind may start, after one of this much processor time."""
    return time.perf_counter() + seconds * (1.0 / SHARE - 1.0)
