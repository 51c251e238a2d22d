"""Which blocking calls of a client wait for the next simulation step, as all of them did in V-REP.

The client says with each call how it is paced (`Pace`); only the server knows when a step was made.
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
        """Note a paced call; return whether it is to be executed after the next step only."""
        if call.delay_ms <= Pace.EVERY:
            return True
        try:
            key = _key(call)
            if key in self._made:
                return True
        except (IndexError, TypeError):  # wrong arguments, which its execution will refuse
            return False
        if len(self._made) >= MOST_REMEMBERED:
            return True
        self._made.add(key)
        return False

    def step_made(self) -> None:
        """Forget what was called before this step."""
        self._made.clear()


def _key(call: Call) -> tuple[object, ...]:
    """What makes two calls the same command: the function and its identifying arguments."""
    command = ANSWERED.get(call.command)
    if command is None:
        return (call.command,)
    return (command.name, *[call.arguments[position] for position in command.key_positions])
