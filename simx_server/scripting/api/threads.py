"""Waiting, and when a script's thread gives way.

A thread is ``sysCall_thread``, a threaded script of V-REP 3, or a coroutine that a script resumes itself. It goes on
once per pass, before the actuation of the scripts without threads.
"""

from __future__ import annotations

import time

from ...errors import CommandError
from ..bodies import CALL_TYPES
from ..interpreter import Waiting
from .base import ApiPart

_SHORTEST, _LONGEST = 0.001, 0.2
"""Seconds a thread may run on; what V-REP takes for setThreadSwitchTiming."""


class ThreadFunctions(ApiPart):
    """What waits is over in a later pass; simulated seconds unless said."""

    CONSTANTS = CALL_TYPES

    def switchThread(self) -> Waiting:
        """Let everything else go on; back in the next pass."""
        yield
        return ()

    def step(self) -> Waiting:
        """The same, by its later name."""
        return self.switchThread()

    def wait(self, seconds: float, simulation_time: bool = True) -> Waiting:
        """Wait so long, at least until the next pass; gives the time that it took too long.

        Args:
            simulation_time: False counts seconds of the clock on the wall.
        """
        if seconds < 0:
            raise CommandError(f"a time to wait is a number not below 0, not {seconds}")

        def now() -> float:
            return self._sim.time if simulation_time else time.monotonic()

        start = now()
        # A whole number of passes must not become one more for rounding.
        while now() - start < seconds - 1e-9:
            yield
        return (max(0.0, now() - start - seconds),)

    def waitForSignal(self, name: str) -> Waiting:
        """Wait until a signal of this name is set, of whatever type; gives its value."""
        while True:
            signals = self._world.signals
            for value in (signals.get_integer(name), signals.get_float(name), signals.get_string(name)):
                if value is not None:
                    return (value,)
            yield

    def setThreadAutomaticSwitch(self, enable: bool | int) -> int:
        """Set whether calls of ``sim`` and loops yield automatically; return the level set before.

        False raises a level, true lowers it; a number sets it. At 0 they do.
        """
        switching = self._script.switching
        before = switching.level
        if isinstance(enable, bool):
            switching.level = max(0, before - 1) if enable else before + 1
        else:
            switching.level = max(0, enable)
        return before

    def getThreadAutomaticSwitch(self) -> bool:
        """Return whether calls of ``sim`` and loops yield automatically."""
        return self._script.switching.level == 0

    def setStepping(self, enable: bool | int) -> int:
        """The later opposite of setThreadAutomaticSwitch."""
        return self.setThreadAutomaticSwitch(not enable if isinstance(enable, bool) else enable)

    def setThreadSwitchTiming(self, milliseconds: float) -> None:
        """Set the time after which a call of ``sim`` or a loop yields; initially 2 ms. Each call counts for 0.01 ms, in
        Python for 0.04 ms; each turn of a loop for 0.2 microseconds, in Python for 0.5.

        Differs: V-REP looked at the wall clock, by which no run was quite like the one before.
        """
        self._script.switching.seconds = min(max(milliseconds / 1000, _SHORTEST), _LONGEST)

    def setThreadIsFree(self, _is_free: bool) -> int:
        """In V-REP a thread could run beside the simulation; here none does, so nothing changes."""
        return 0

    def getThreadExistRequest(self) -> bool:
        """Whether the thread is to end: true once the run is ending."""
        return self._sim.is_stopping

    def getThreadId(self) -> int:
        """A number of the script's own, whether it is called in its thread or not."""
        return self._script.handle

    def setThreadResumeLocation(self, _location: int, _order: int) -> int:
        """Threads go on before the other scripts' actuation, wherever they ask for."""
        return 0
