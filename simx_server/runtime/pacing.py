"""Decide which blocking calls of a client wait for the next simulation step, as all of them did in V-REP.

Each call carries its pacing (`Pace`), chosen by the client; only the server knows when a step was made.
"""

from __future__ import annotations

from simx_client.protocol.commands import ANSWERED
from simx_client.protocol.messages import Call, Pace

MOST_REMEMBERED = 4096
"""Calls of one simulation step. A client that makes more of them waits, so it cannot fill the memory."""


class PacedCalls:
    """The paced calls that one client made since the last simulation step. Physics thread only."""

    def __init__(self) -> None:
        self._made: set[tuple[object, ...]] = set()

    def must_wait(self, call: Call) -> bool:
        """Record a paced call; return whether it must wait for the next simulation step."""
        if call.delay_ms <= Pace.EVERY:
            return True
        try:
            key = _key(call)
            if key in self._made:
                return True
        except (IndexError, TypeError):  # wrong arguments, which the execution will refuse
            return False
        if len(self._made) >= MOST_REMEMBERED:
            return True
        self._made.add(key)
        return False

    def step_made(self) -> None:
        """Forget the calls made before this simulation step."""
        self._made.clear()


def _key(call: Call) -> tuple[object, ...]:
    """Return the key of a call: the function and its identifying arguments."""
    command = ANSWERED.get(call.command)
    if command is None:
        return (call.command,)
    return (command.name, *[call.arguments[position] for position in command.key_positions])
