"""Continue the work of a crashed server, and decide from which moment.

After the first crash the next server goes on from the last moment. A server that crashes again at once, at
the same moment, is followed by one that goes on a moment earlier, then by one that stands before the run, then by none.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from simx_server.errors import CommandError
from simx_server.processes.children import how_it_ended
from simx_server.simulation.simulation import SimulationState

from .going_on import restarted_scripts
from .journal import Block, Journal
from .keeping import Keeper
from .recovering import Recovered, chosen_blocks, clients_of, recover
from .writing import First, Kind

if TYPE_CHECKING:
    from simx_server.recording import Recorder
    from simx_server.service.service import Service

logger = logging.getLogger(__name__)

AT_ONCE = 2.0
"""Seconds after it was ready within which a server crashes at once."""

EARLIEST = 2
"""How far back a server may start: 1 is one moment earlier, 2 the state before the run."""

MOST_FAILURES = 12
"""Starts in a row that may fail in good order: the name or a port of the server before may be taken for a while."""

PAUSE = 0.5
"""Seconds after a start that failed."""


@dataclass(frozen=True, slots=True)
class Inheritance:
    """The work that a server continues."""

    journal: Journal
    ended: str = ""
    """How the server before it ended; empty: there was none, or nothing of it is to be continued."""

    back: int = 0
    """See `recovering.chosen_blocks`."""


class Succession:
    """The servers of one place, one after the other, as the process sees it that starts them."""

    def __init__(self) -> None:
        self.journal = Journal()
        self._back = self._failures = 0
        self._how = ""
        self._began_at: tuple[int, int] | None = None
        self._ready_at: float | None = None

    def first(self) -> Inheritance:
        """Return the inheritance of a server that continues nothing."""
        self.journal.clear()
        self._back, self._failures, self._began_at, self._ready_at = 0, 0, None, None
        return Inheritance(self.journal)

    def is_ready(self) -> None:
        """Note that the present server is ready."""
        self._ready_at, self._failures = time.monotonic(), 0

    @property
    def pause(self) -> float:
        """Return the seconds until the next server may be started."""
        return PAUSE if self._failures else 0.0

    def next(self, exit_code: int) -> Inheritance | None:
        """Return the inheritance of the next server after one that has crashed; None: start no other one.

        Args:
            exit_code: of that one; negative for a signal.
        """
        if exit_code >= 0 and self._ready_at is None and self._began_at is not None:
            self._failures += 1
            return (
                Inheritance(self.journal, self._how, self._back) if self._failures <= MOST_FAILURES else None
            )
        self._how = how_it_ended(exit_code)
        newest = self._newest()
        self._back = self._back + 1 if self._is_same(newest) else 0
        self._began_at, self._ready_at = newest, None
        return Inheritance(self.journal, self._how, self._back) if self._back <= EARLIEST else None

    def close(self) -> None:
        """Forget everything."""
        self.journal.close()

    def _newest(self) -> tuple[int, int]:
        """Return kind and number of the last moment."""
        return next(
            (key for key in reversed(self.journal.heads()) if key[0] != Kind.SECTION), (Kind.STOPPED, -1)
        )

    def _is_same(self, newest: tuple[int, int]) -> bool:
        """Return whether a server crashed at once where the one before it had crashed."""
        if self._began_at is None:
            return newest[1] < 0  # it has not even kept its first moment
        is_quick = self._ready_at is None or time.monotonic() - self._ready_at < AT_ONCE
        return is_quick and newest[0] == self._began_at[0] and newest[1] <= self._began_at[1] + 1


def take_over(service: Service, inheritance: Inheritance, recorder: Recorder | None) -> Recovered | None:
    """Continue what the server before this one did, if there was one, and keep moments from now on.

    Args:
        service: with the scene as it was loaded; clients may wait, none was served.
        recorder: starts to record the service.

    Returns:
        The moment of the world; None: it is the world that was loaded.
    """
    keeper = Keeper(service, inheritance.journal)
    recovered = None
    if inheritance.ended:
        recovered = _continue(service, keeper, inheritance, recorder)
    elif recorder is not None:
        recorder.begin(service)
    keeper.start(recovered.base if recovered is not None else None)
    return recovered


def _continue(
    service: Service, keeper: Keeper, inheritance: Inheritance, recorder: Recorder | None
) -> Recovered | None:
    blocks = chosen_blocks(inheritance.journal.read(), inheritance.back)
    what = f"the server ended {inheritance.ended} and was started again"
    if recorder is not None:
        recorder.resumed(what, blocks)
        recorder.begin(service)
    recovered, told = resume(service, keeper.first, what, blocks)
    service.world.status_bar.add(told, logging.ERROR)
    return recovered


def resume(
    service: Service, first: First, what: str, blocks: Sequence[Block]
) -> tuple[Recovered | None, str]:
    """Set a world that has just been loaded to the last moment of a journal, and expect the clients of that time.

    Args:
        first: the scene as it was loaded.
        what: what happened to the server before this one.
        blocks: as `chosen_blocks` returns them.

    Returns:
        The moment of the world, None if it is as it was loaded; and a description of the events.
    """
    if not blocks:
        return None, f"{what}; nothing was kept, so the scene is as it was loaded"
    try:
        recovered = recover(service, first, blocks)
        told = f"{what}; {_described(service, recovered)}"
    except CommandError as problem:
        recovered, told = None, f"{what}; {problem}; the scene is as it was loaded"
    service.returning.expect(clients_of(blocks), told)
    return recovered, told


def _described(service: Service, recovered: Recovered) -> str:
    if recovered.state is SimulationState.STOPPED:
        return "the simulation is stopped, as it was"
    scripts = restarted_scripts(service.world)
    again = f"; these scripts have started again: {', '.join(scripts)}" if scripts else ""
    state = ", paused" if recovered.state is SimulationState.PAUSED else ""
    return f"the simulation goes on from step {recovered.step}, {recovered.time:.3f} s{state}{again}"
