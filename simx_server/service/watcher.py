"""The events of the service, for recordings, histories, metrics and others that only look on. Physics thread only."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from simx_server.simulation.part import Part

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation

    from .clients.sessions import ClientSession


class Watcher(Part):
    """Base class: every method may be overridden, and does nothing here. It receives the events of `Part` too."""

    needs_whole_batches = False
    """It must see each batch as a whole: no batch is cut while it watches, and no call is executed without one."""

    # --- clients ---------------------------------------------------------------------------------

    def joined(self, session: ClientSession) -> None:
        """React to a client that has joined."""

    def welcomes(self, session: ClientSession) -> bool:
        """Return whether a client that has joined goes on with what it did before, so that it starts no simulation."""
        return False

    def left(self, client: str) -> None:
        """React to a client that has left."""

    def stepping_lost(self, client: str) -> None:
        """React before a client loses its stepped mode."""

    # --- calls -----------------------------------------------------------------------------------

    def batch_comes(self, client: str, payload: bytes) -> None:
        """React before a message of a client is executed."""

    def batch_goes_on(self, client: str) -> None:
        """React before the rest of a batch is executed, which has waited."""

    def call_goes_on(self, client: str, connection: int) -> None:
        """React before a call of the ZeroMQ remote API is continued, which has waited."""

    def function_answered(self, client: str, message: bytes | str) -> None:
        """React to a message from within a function of a client of that API, or to why none is awaited any longer."""

    # --- the loop --------------------------------------------------------------------------------

    def started(self) -> None:
        """React before the server starts the simulation."""

    def round_made(self, *, is_advancing: bool) -> None:
        """React to a round of the loop: a simulation step, or only streams and regular work; see `rounds.py`."""

    @property
    def wants_idle(self) -> bool:
        """Return whether `idle` has something to do now. Only asked if `idle` is overridden."""
        return True

    def idle(self) -> None:
        """Do a piece of work for which the simulation must be stopped or paused; called in rounds without a step."""

    def look(self) -> None:
        """Do what is due now and then; called after turns of the loop."""

    def read_while_busy(self) -> None:
        """Queue what has arrived while the physics thread, which reads it otherwise, is busy. Another thread."""

    def ending(self) -> None:
        """React before the server stops the simulation in order to exit."""

    def ended(self) -> None:
        """React to that stop."""


class Watchers:
    """All watchers of a service. For each event it has the methods that override it: the others cost nothing."""

    __slots__ = (
        "_all", "_simulation", "batch_comes", "batch_goes_on", "call_goes_on", "ended", "ending", "function_answered",
        "idlers", "joined", "left", "look", "need_whole_batches", "read_while_busy", "round_made", "started",
        "stepping_lost", "welcomes",
    )  # fmt: skip

    def __init__(self, simulation: Simulation) -> None:
        """Make an empty list.

        Args:
            simulation: its events go to the watchers too.
        """
        self._simulation = simulation
        self._all: tuple[Watcher, ...] = ()
        self._sort()

    def add(self, *watchers: Watcher) -> None:
        """Notify these watchers from now on, after the others."""
        self._all = (*self._all, *watchers)
        self._simulation.parts.attach(*watchers)
        self._sort()

    def remove(self, watcher: Watcher) -> None:
        """Notify a watcher no more."""
        self._all = tuple(each for each in self._all if each is not watcher)
        self._simulation.parts.detach(watcher)
        self._sort()

    def _sort(self) -> None:
        """Find the methods to call for each event. The hot path reads these tuples."""
        self.joined = self._overriding("joined")
        self.welcomes = self._overriding("welcomes")
        self.left = self._overriding("left")
        self.stepping_lost = self._overriding("stepping_lost")
        self.batch_comes = self._overriding("batch_comes")
        self.batch_goes_on = self._overriding("batch_goes_on")
        self.call_goes_on = self._overriding("call_goes_on")
        self.function_answered = self._overriding("function_answered")
        self.started = self._overriding("started")
        self.round_made = self._overriding("round_made")
        self.look = self._overriding("look")
        self.read_while_busy = self._overriding("read_while_busy")
        self.ending = self._overriding("ending")
        self.ended = self._overriding("ended")
        self.idlers = tuple(each for each in self._all if type(each).idle is not Watcher.idle)
        self.need_whole_batches = any(each.needs_whole_batches for each in self._all)

    def _overriding(self, event: str) -> tuple[Callable[..., Any], ...]:
        return tuple(
            getattr(each, event)
            for each in self._all
            if getattr(type(each), event) is not getattr(Watcher, event)
        )
