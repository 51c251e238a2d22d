"""Programs and serial ports of the machine, which scripts of V-REP may use and scripts here may not."""

from __future__ import annotations

from simx_server.scripting.interpreter import Waiting

from .base import ApiPart
from .effects import runs_code

_FAILED = -1


class ProcessFunctions(ApiPart, effect="changes"):
    """Functions for other programs and devices: they fail as V-REP's do without the program."""

    @runs_code
    def launchExecutable(self, file: str, arguments: str = "", _shown: int = 1) -> int:
        """Return -1, V-REP's result when a program cannot be started.

        Not here: scripts start no programs; the log says which one to start.
        """
        self._say_once(
            f"scripts start no programs on this server: start '{file[:200]}' yourself"
            + (f" (arguments: {arguments[:200]})" if arguments else "")
        )
        return _FAILED

    def systemSemaphore(self, key: str, acquire: bool) -> Waiting | None:
        """Acquire or release a semaphore that all simulations of this user on this machine share; the end of a server
        releases those that it has. A thread of a script waits until it is free, other calls fail.
        """
        if not acquire:
            self._world.semaphores.release(key)
        elif not self._world.semaphores.acquire(key):
            return self._until_acquired(key)
        return None

    def _until_acquired(self, key: str) -> Waiting:
        while not self._world.semaphores.acquire(key):
            yield
        return ()

    def serialOpen(self, port: str, _baud_rate: int = 9600) -> int:
        """Return -1, V-REP's result when a port cannot be opened. Not here: scripts reach no serial ports."""
        self._say_once(f"scripts reach no serial ports on this server, such as '{port[:200]}'")
        return _FAILED

    def serialClose(self, _port: int) -> int:
        """Return -1. Stand-in: no serial port is open."""
        return self._without_port()

    def serialSend(self, _port: int, _data: bytes) -> int:
        """Return -1. Stand-in: no serial port is open."""
        return self._without_port()

    def serialRead(self, _port: int, _length: int, _blocking: bool = False) -> None:
        """Return nil. Stand-in: no serial port is open."""
        self._without_port()

    def serialCheck(self, _port: int) -> int:
        """Return -1. Stand-in: no serial port is open."""
        return self._without_port()

    serialPortOpen = serialOpen
    serialPortClose = serialClose
    serialPortSend = serialSend
    serialPortRead = serialRead

    def _without_port(self) -> int:
        self._say_once("no serial port is open: sim.serialOpen returns -1 on this server")
        return _FAILED
