"""Calls that scripts leave for later, and messages from one script to all others."""

from __future__ import annotations

from typing import Any

from simx_server.errors import CommandError
from simx_server.scripting.interpreter import Function
from simx_server.scripting.script import Scheduled
from simx_server.sim_api.base import ApiPart

_MOST = 1000
"""Maximum number of calls that a script may schedule."""


class SchedulingFunctions(ApiPart):
    """Functions for calls at another time, and for messages."""

    def scheduleExecution(
        self, function: str | Function, arguments: list[Any], moment: float, in_simulation_time: bool = False
    ) -> int:
        """Call a function of this script once at a time of sim.getSystemTime, or of sim.getSimulationTime; return a
        number for sim.cancelScheduledExecution. The call comes before the actuation of the scripts, or while stopped.
        """
        if len(self._script.scheduled) >= _MOST:
            raise CommandError(f"at most {_MOST} calls of a script can be scheduled; cancel some")
        number = next(self._script.schedule_numbers)
        self._script.scheduled[number] = Scheduled(
            self._function(function), tuple(arguments), moment, in_simulation_time
        )
        return number

    def cancelScheduledExecution(self, number: int) -> bool:
        """Cancel a scheduled call; return whether it was still to come."""
        return self._script.scheduled.pop(number, None) is not None

    def broadcastMsg(self, message: dict[str, Any], _options: int = 0) -> None:
        """Call ``sysCall_msg(message, sender)`` of all other scripts, now; the sender is this script's handle."""
        self._world.scripts.broadcast(self._script, message)

    broadcastMessage = broadcastMsg
