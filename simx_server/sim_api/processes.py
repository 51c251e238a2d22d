"""Programs and serial ports of the machine, which scripts of V-REP may use and scripts here may not."""

from __future__ import annotations

from .base import ApiPart

_FAILED = -1


class ProcessFunctions(ApiPart):
    """Functions for other programs and devices: they fail as V-REP's do without the program."""

    def launchExecutable(self, file: str, arguments: str = "", _shown: int = 1) -> int:
        """Return -1, V-REP's result when a program cannot be started.

        Not here: scripts start no programs; the log says which one to start.
        """
        self._say_once(
            f"scripts start no programs on this server: start '{file[:200]}' yourself"
            + (f" (arguments: {arguments[:200]})" if arguments else "")
        )
        return _FAILED

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
