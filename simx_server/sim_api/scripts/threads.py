"""Waiting, and switching of a script's thread.

A thread is ``sysCall_thread``, a threaded script of V-REP 3, or a coroutine that a script resumes itself. It is
resumed once per simulation step, before the actuation of the scripts without threads.
"""

from __future__ import annotations

from collections.abc import Generator

from simx_server.errors import CommandError
from simx_server.scripting.bodies import CALL_TYPES
from simx_server.scripting.interpreter import Waiting
from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.effects import reads

_SHORTEST, _LONGEST = 0.001, 0.2
"""Limits of the seconds until a thread switches; V-REP accepts them in setThreadSwitchTiming."""


class ThreadFunctions(ApiPart, effect="changes"):
    """Functions for threads. A wait ends in a later simulation step; times are simulated seconds unless stated
    otherwise.
    """

    CONSTANTS = CALL_TYPES

    def switchThread(self) -> Generator[None, None, tuple[()]]:
        """Suspend the thread until the next simulation step."""
        yield
        return ()

    def step(self) -> Generator[None, None, tuple[()]]:
        """Suspend the thread until the next simulation step: the later name of switchThread."""
        return self.switchThread()

    @reads
    def wait(self, seconds: float, simulation_time: bool = True) -> Generator[None, None, tuple[float]]:
        """Wait for this time, at least until the next simulation step; return the time by which the wait was too
        long.

        Args:
            simulation_time: False counts seconds of the wall clock.
        """
        if seconds < 0:
            raise CommandError(f"a time to wait is a number not below 0, not {seconds}")

        def now() -> float:
            return self._sim.time if simulation_time else self._wall_clock()

        start = now()
        # Rounding must not add a simulation step to a whole number of them.
        while now() - start < seconds - 1e-9:
            yield
        return (max(0.0, now() - start - seconds),)

    @reads
    def waitForSignal(self, name: str) -> Waiting:
        """Wait until a signal of this name and of any type is set; return its value."""
        while True:
            signals = self._world.signals
            for value in (signals.get_integer(name), signals.get_float(name), signals.get_string(name)):
                if value is not None:
                    return (value,)
            yield

    def setThreadAutomaticSwitch(self, enable: bool | int) -> int:
        """Set whether calls of ``sim`` and loops switch automatically; return the previous level.

        False raises a level, true lowers it; a number sets it. They switch at level 0.
        """
        switching = self._script.switching
        before = switching.level
        if isinstance(enable, bool):
            switching.level = max(0, before - 1) if enable else before + 1
        else:
            switching.level = max(0, enable)
        return before

    @reads
    def getThreadAutomaticSwitch(self) -> tuple[bool, int]:
        """Return whether calls of ``sim`` and loops switch automatically, and the level."""
        return self._script.switching.level == 0, self._script.switching.level

    setThreadSwitchAllowed = setThreadAutomaticSwitch
    getThreadSwitchAllowed = getThreadAutomaticSwitch
    setYieldAllowed = setThreadAutomaticSwitch
    getYieldAllowed = getThreadAutomaticSwitch

    def setStepping(self, enable: bool | int) -> int:
        """Set the level: the later opposite of setThreadAutomaticSwitch."""
        return self.setThreadAutomaticSwitch(not enable if isinstance(enable, bool) else enable)

    def setThreadSwitchTiming(self, milliseconds: float) -> int:
        """Set the time after which a call of ``sim`` or a loop switches; the default is 2 ms. Each call counts as
        0.01 ms, in Python as 0.04 ms; each iteration of a loop as 0.2 microseconds, in Python as 0.5.

        Differs: V-REP used the wall clock, which made every run different.
        """
        self._script.switching.seconds = min(max(milliseconds / 1000, _SHORTEST), _LONGEST)
        return 1

    def setThreadIsFree(self, _is_free: bool) -> int:
        """Return 0: in V-REP a thread could run in parallel with the simulation; here it never does, so this has no
        effect.
        """
        return 0

    @reads
    def getThreadSwitchTiming(self) -> float:
        """Return the milliseconds after which a call of ``sim`` or a loop switches."""
        return self._script.switching.seconds * 1000

    def setAutoYieldDelay(self, seconds: float) -> None:
        """Set the time after which a call of ``sim`` or a loop switches: the later form of setThreadSwitchTiming."""
        self.setThreadSwitchTiming(seconds * 1000)

    @reads
    def getAutoYieldDelay(self) -> float:
        """Return the seconds after which a call of ``sim`` or a loop switches."""
        return self._script.switching.seconds

    def acquireLock(self) -> None:
        """Raise the level as setStepping(true) does: no automatic switching until releaseLock."""
        self._script.switching.level += 1

    def releaseLock(self) -> None:
        """Lower the level again."""
        self._script.switching.level = max(0, self._script.switching.level - 1)

    def lockResources(self, _kind: int = 0, _reason: int = 0) -> int:
        """Return 1: a script is never interrupted within a call, so nothing has to be locked."""
        return 1

    def unlockResources(self, _lock: int = 0) -> int:
        """Return 1, as sim.lockResources does."""
        return 1

    def waitForSimulationStart(self) -> Generator[None, None, tuple[()]]:
        """Wait until the simulation runs."""
        while not self._sim.is_running:
            yield
        return ()

    @reads
    def getThreadExistRequest(self) -> bool:
        """Return whether the thread is to end: true once the run is ending."""
        return self._sim.is_stopping

    getThreadExitRequest = getThreadExistRequest

    @reads
    def getThreadId(self) -> int:
        """Return a number that is unique to the script, inside and outside its thread."""
        return self._script.handle

    def setThreadResumeLocation(self, _location: int, _order: int) -> int:
        """Return 0: threads are always resumed before the other scripts' actuation, whatever the location."""
        return 0


# A name that Python's grammar reserves; Lua's does not.
setattr(ThreadFunctions, "yield", ThreadFunctions.step)
