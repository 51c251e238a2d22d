"""One world of a crew."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .calls import Caller, Calls
from .shared import Rows, Shared
from .whole import Whole

if TYPE_CHECKING:
    from .lent import Lent


class Member:
    """A world, with the calls of its plan."""

    def __init__(self, place: int, lent: Lent, calls: Calls) -> None:
        self._link, self._turns, self._alone = lent.link, lent.turns, lent.alone
        self._physics = lent.service.world.physics
        caller = Caller(place, lent)
        self.whole = Whole(caller, lent, calls)
        self.shared = Shared(place, caller, lent, calls)

    def reason_against(self) -> str | None:
        """Return why threads cannot make the physics of this world now; None: they can. Within no turn."""
        self._turns.begin()
        try:
            if not self._link.is_direct or not self._alone.is_alone:
                return "other clients, a recording or a history see each step"
            return None if self._physics.may_be_apart else "Python has something to do within physics"
        finally:
            self._turns.end()

    @property
    def physics_seconds(self) -> float:
        """Return how long the physics of the last simulation step took; 0 before the first."""
        course = self.whole.course
        return self.shared.seconds if course is None else course.seconds

    def read_start(self, results: Rows) -> None:
        """Read the state at the start of an episode. Within no turn.

        Raises:
            ConnectionFailed: a read was refused.
        """
        if self.whole.course is not None:
            self.whole.course.read(results)
        else:
            self.shared.read(results)
