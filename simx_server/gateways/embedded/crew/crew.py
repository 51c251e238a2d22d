"""The worlds of a crew: who makes the steps of which, and when."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from simx_client.errors import ConnectionFailed
from simx_client.transport.direct import Plan, Refusal
from simx_server.joints.native.loading import crew_form

from .calls import Calls, width_of
from .lent import Lent
from .member import Member
from .shared import Physics, Rows

Places = NDArray[np.intp]


if TYPE_CHECKING:
    from simx_server.joints.native._crew import Crew as Threads


class Crew:
    """Worlds that step together; see `simx_client.transport.direct.Crew`."""

    def __init__(self, lent: Sequence[Lent], plan: Plan, threads: int) -> None:
        """Prepare the steps; episodes have to be started already.

        Raises:
            ConnectionFailed: the worlds cannot step in threads, with the reason.
        """
        compiled, reason = crew_form()
        if compiled is None:
            raise ConnectionFailed(f"steps in threads need compiled code: {reason}")
        count = len(lent)
        self._members: list[Member] = [
            Member(
                place,
                each,
                Calls(
                    None if plan.starts is None else plan.starts[place],
                    plan.writes[place],
                    plan.reads[place],
                    plan.steps,
                ),
            )
            for place, each in enumerate(lent)
        ]
        for member in self._members:
            if reason := member.reason_against():
                raise ConnectionFailed(reason)
        starts = () if plan.starts is None else plan.starts[0]
        self.widths: tuple[int, int, Sequence[int]] = (
            width_of(starts),
            width_of(plan.writes[0]),
            self._members[0].shared.widths(),
        )
        self._compiled = compiled
        self._crew: Threads = compiled.Crew(count, threads)
        self._steps = plan.steps
        self._ahead = threads - 1
        """Worlds that may wait for another thread, before this one makes physics too."""

        self._is_lent = np.zeros(count, bool)
        self._lent_count = 0
        self._lock = threading.RLock()
        """Held while compiled code has worlds in hand: a turn of one of them waits for it."""

    def reason_against(self, place: int) -> str | None:
        """Return why threads cannot make the physics of a world now; None: they can. Call it in an episode."""
        return None if self._is_lent[place] else self._members[place].reason_against()

    def physics_seconds(self, place: int) -> float:
        """Return how long the physics of the last simulation step of a world took."""
        return self._members[place].physics_seconds

    @property
    def is_whole(self) -> bool:
        """Return whether compiled code makes the steps of all worlds."""
        return self._lent_count == len(self._members)

    def started(self, places: Places, results: Rows) -> None:
        """Let compiled code step the worlds in which an episode was started, if nothing else has to; read them."""
        for place in _listed(places):
            self._lend(place)
            self._members[place].read_start(results[place])

    def give_back(self, places: Sequence[int] | None = None) -> None:
        """Prepare worlds, or all, for calls."""
        for place in range(len(self._members)) if places is None else places:
            if self._is_lent[place]:
                self._members[place].whole.take_over()

    def _lend(self, place: int) -> None:
        member = self._members[place]
        if not self._is_lent[place] and member.whole.lend(partial(self._take_back, place)):
            self._crew.put(place, member.whole.course)
            self._is_lent[place] = True
            self._lent_count += 1

    def _take_back(self, place: int) -> None:
        """Give a world back to the turns. Within a turn of it, in any thread."""
        with self._lock:
            if self._is_lent[place]:
                self._is_lent[place] = False
                self._lent_count -= 1
                self._crew.put(place, None)
                self._members[place].whole.settle()

    def restart(self, places: Places, values: Rows, results: Rows) -> Places:
        """Start another episode in some worlds; return those where calls have to."""
        with self._lock:
            if self.is_whole:
                refused = self._crew.restart(places, values, results)
                return np.array(refused, np.intp) if refused else _NONE
            lent = self._is_lent[places]
            refused = self._crew.restart(places[lent], values, results)
        return np.union1d(places[~lent], np.array(refused, np.intp))

    def step(self, places: Places, values: Rows, results: Rows) -> list[Refusal]:
        """Make the steps of some worlds; return the calls that failed."""
        if not self.is_whole:
            for place in _listed(places[~self._is_lent[places]]):
                self._lend(place)
        with self._lock:
            lent = places if self.is_whole else places[self._is_lent[places]]
            failed: list[int] = self._crew.step(lent, values, results, self._steps) if len(lent) else []
            courses = {place: self._members[place].whole.lent_course for place in failed}
        if not failed and lent is places:
            return []
        refusals: list[Refusal] = []
        running: dict[int, Physics] = {}
        for place in _listed(np.setdiff1d(places, lent)):
            running[place] = self._members[place].shared.run(values[place], results[place])
        for place, course in courses.items():
            member = self._members[place]
            refused = member.whole.take_over()
            refusals += refused
            if course.outcome == self._compiled.REFUSED:
                running[place] = member.shared.run(values[place], results[place])
            elif not refused:
                left = self._steps - course.done - 1
                running[place] = member.shared.run(values[place], results[place], left)
        return refusals + self._step_apart(running)

    def _step_apart(self, running: dict[int, Physics]) -> list[Refusal]:
        """Make steps of which Python makes a part: its physics in threads, while Python is with other worlds."""
        refusals: list[Refusal] = []
        crew = self._crew

        def go_on(place: int, *, is_first: bool) -> None:
            shared, physics = self._members[place].shared, running[place]
            try:
                if is_first:
                    apart = next(physics)
                else:
                    made = shared.made()
                    apart = physics.throw(made) if isinstance(made, BaseException) else physics.send(made)
            except StopIteration as end:
                refusals.extend(end.value)
                return
            crew.put(place, shared.course_of(apart))
            crew.submit(place, apart.flags)

        try:
            for place in running:
                go_on(place, is_first=True)
                while (made := crew.next(self._ahead)) >= 0:
                    go_on(made, is_first=False)
            while (made := crew.next(_ALL)) >= 0:
                go_on(made, is_first=False)
        except BaseException:
            self._abandon(running)
            raise
        return refusals

    def _abandon(self, running: dict[int, Physics]) -> None:
        """End steps that an error has interrupted: Ctrl-C, or one of this program."""
        while self._crew.next(_ALL) >= 0:
            pass
        for physics in running.values():
            physics.close()

    def close(self) -> None:
        """End the threads, and give the worlds back. Idempotent."""
        self.give_back()
        self._crew.close()


_NONE = np.zeros(0, np.intp)
_ALL = -1


def _listed(places: Places) -> list[int]:
    return places.tolist()
