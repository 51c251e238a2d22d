"""Decide which blocking calls of a client wait for the next simulation step, as all of them did in V-REP.

Each call carries its pacing (`Pace`), chosen by the client; only the server knows when a step was made.
"""

from __future__ import annotations

from collections import deque
from concurrent.futures import Future

from simx_client.protocol.commands import ANSWERED, Command
from simx_client.protocol.messages import Call, Pace
from simx_client.protocol.table.command import Effect

MOST_REMEMBERED = 4096
"""Calls of one simulation step. A client that makes more of them waits, so it cannot fill the memory."""

MOST_IMAGES = 64
"""Images of one client that a paced call waits for: the newest."""

_CHANGES = (Effect.CHANGES, Effect.EDITS, Effect.RUNS_CODE)


class PacedCalls:
    """The paced calls that one client made since the last simulation step. Physics thread only."""

    def __init__(self) -> None:
        self._made: set[tuple[object, ...]] = set()
        self._has_changed = False
        """One of them has changed something."""

        self._lacks_value = False
        """A stream was armed whose first value comes with the next simulation step."""

        self.images: deque[Future[None]] = deque(maxlen=MOST_IMAGES)
        """Done when an image has left that was requested, in a mode other than blocking, since the last paced call."""

    def must_wait(self, call: Call) -> bool:
        """Record a paced call; return whether it must wait for the next simulation step.

        In V-REP two blocking calls were executed before two different steps. Different reads since the last step may
        see the same state, and so need not wait. A call that changes something has a separate step.
        """
        if call.delay_ms <= Pace.EVERY:
            return True
        command = ANSWERED.get(call.command)
        changes = command is not None and command.effect in _CHANGES
        if self._has_changed or self._lacks_value or (changes and self._made):
            return True
        try:
            key = _key(call, command)
            if key in self._made:
                return True
        except (IndexError, TypeError):  # wrong arguments, which the execution will refuse
            return False
        if len(self._made) >= MOST_REMEMBERED:
            return True
        self._made.add(key)
        self._has_changed = changes
        return False

    def step_comes(self) -> None:
        """Note that the first value of an armed stream comes with the next simulation step."""
        self._lacks_value = True

    def step_made(self) -> None:
        """Forget the calls made before this simulation step."""
        self._made.clear()
        self._has_changed = self._lacks_value = False


def _key(call: Call, command: Command | None) -> tuple[object, ...]:
    """Return the key of a call: the function and its identifying arguments."""
    if command is None:
        return (call.command,)
    return (command.name, *[call.arguments[position] for position in command.key_positions])
