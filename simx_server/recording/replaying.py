"""Replay a recording as fast as possible, and compare the states."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

from simx_client.protocol.add_ons.windows import ADD_ON as WINDOWS
from simx_server.history import History
from simx_server.simulation.part import Part

from ..viewer.feed import Feed
from ..viewer.messages import ADD_ON
from ..viewer.windows import Windows
from . import state
from .opened import Opened
from .records import Kind, Record
from .replayed import Divergence, Replayed

if TYPE_CHECKING:
    from simx_server.service.service import Service
    from simx_server.world.world import World


class Outcome(NamedTuple):
    """The extent of a replay that was equal to the recording in all compared states."""

    steps: int
    batches: int
    compared: int
    """States of the simulation."""

    has_end: bool
    """False: the server was killed, or could not continue to write."""

    damage: str
    """The part of the file that could not be read; empty when all could."""

    @property
    def problem(self) -> str:
        """Return the reason why this is less than an equal replay; empty when it is one."""
        if self.damage:
            return f"{self.damage}, and only what is before it was compared"
        if not self.compared:
            return "the recording holds no state to compare with"
        return ""

    def __str__(self) -> str:
        cut = (
            ""
            if self.has_end
            else "; the recording goes no further: its server was killed, or could not write on"
        )
        what = f"{self.steps} simulation steps and {self.batches} messages of clients, {self.compared} states compared"
        return what + cut


def replay(
    recording: Opened,
    world: World,
    history: float | None = None,
    *,
    last_step: int | None = None,
    attach: Callable[[Service], object] = lambda _service: None,
    before_step: Callable[[], None] = lambda: None,
    after_step: Callable[[], None] = lambda: None,
    compares: bool = True,
) -> Outcome:
    """Replay all events, and compare the states.

    Args:
        history: simulated seconds of past steps that the recorded server kept, from which clients may have gone on.
        last_step: end after this simulation step, counted from 1 over all runs.
        attach: called with the service before the first event, for watchers.
        before_step, after_step: called before and after each simulation step.
        compares: off repeats the calls in a world that was changed, whose states are other ones.

    Raises:
        Divergence: the states differ, or an event is impossible.
        LogError: the recording cannot be used.
    """
    simulation = world.simulation
    replayed = Replayed(world, has_physics_points=bool(recording.header.get("physics_points")))
    past = History(replayed.service, history)
    replayed.service.watchers.add(past)
    attach(replayed.service)
    world.scripts.add_ons[WINDOWS] = Windows()
    # repeats the single steps of a web viewer
    world.scripts.add_ons[ADD_ON] = Feed(replayed.service, "replay", (), past)
    states = _States(world, compares=compares)
    steps = batches = 0
    for number, (event, belonging, following) in enumerate(recording.events()):
        kind = event[0]
        if kind == Kind.END:
            return Outcome(steps, batches, states.compared, True, "")
        steps += kind == Kind.PASS
        batches += sum(record[0] == Kind.BATCH for record in (event, *belonging))
        is_before_step = following is not None and following[0] in (Kind.PASS, Kind.IDLE)
        for record in belonging:
            if record[0] == Kind.STATE:
                states.expect(record)
            elif record[0] == Kind.WITHIN:
                replayed.await_answer(record)
            else:
                replayed.await_point(number, record)
        replayed.await_room()
        try:
            simulation.settle()
            if kind == Kind.PASS:
                before_step()
            if kind == Kind.RESUMED:
                replayed.resume(*event[1:])
                states.forget()
            else:
                replayed.do(event)
            replayed.do_what_is_due(number if is_before_step else None)
            if kind not in (Kind.PASS, Kind.IDLE):
                simulation.settle()
            states.compare(event, is_before_step=is_before_step, is_last=following is None)
            if kind == Kind.PASS:
                after_step()
            if kind == Kind.PASS and steps == last_step:
                return Outcome(steps, batches, states.compared, True, "")
        except Divergence as problem:
            raise Divergence(
                f"in pass {steps} of the recording, {simulation.time:.3f} s after the start of that run: {problem}"
            ) from None
    return Outcome(steps, batches, states.compared, False, recording.damage)


class _States(Part):
    """The simulation's states beside the recorded ones."""

    def __init__(self, world: World, *, compares: bool) -> None:
        self._world = world
        self._compares = compares
        self._sim = world.simulation
        self._made: deque[list[bytes]] = deque()
        """At stops."""
        self._recorded: deque[list[bytes]] = deque()
        self._of_step: list[bytes] | None = None
        self.compared = 0
        self._sim.parts.attach(self)

    def run_stopping(self) -> None:
        self._made.append(state.digests(self._world))

    def forget(self) -> None:
        """Compare nothing of what came before: the server crashed there, and its last records may be missing."""
        self._made.clear()
        self._recorded.clear()
        self._of_step = None

    def expect(self, record: Record) -> None:
        """Add the digests that were recorded behind an event."""
        _, is_stop, digests = record
        if is_stop:
            self._recorded.append(digests)
        else:
            self._of_step = digests

    def compare(self, event: Record, *, is_before_step: bool, is_last: bool) -> None:
        """Compare the state after an event. Raises Divergence.

        Args:
            is_before_step: stops in the following simulation step are recorded by now, and still to come.
            is_last: the recording was cut off behind this event, perhaps before its stop was written.
        """
        if not self._compares:
            self.forget()
            return
        if event[0] == Kind.PASS:
            made = state.of_step(self._sim.data)
            self._refuse(state.differences_of_step(made, event[1]))
        digests, self._of_step = self._of_step, None
        if digests is not None:
            self._refuse(state.differences(state.digests(self._world), digests))
        while self._made and self._recorded:
            self._refuse(state.differences(self._made.popleft(), self._recorded.popleft()), " at a stop")
        if self._made and not is_last:
            raise Divergence("the simulation stopped, which it did not when it was recorded")
        if self._recorded and not is_before_step:
            raise Divergence("the simulation did not stop, as it did when it was recorded")

    def _refuse(self, differences: list[str], when: str = "") -> None:
        if differences:
            raise Divergence(f"other {', '.join(differences)}{when}")
        self.compared += 1
