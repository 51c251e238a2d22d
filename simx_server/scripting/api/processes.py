"""Programs and serial ports of the machine, which scripts of V-REP may use and scripts here may not."""

from __future__ import annotations

from typing import NoReturn

from simx_server.errors import CommandError

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

    def serialClose(self, _port: int) -> NoReturn:
        """Raise an error. Not here: no serial port is open."""
        raise _no_port()

    def serialSend(self, _port: int, _data: bytes) -> NoReturn:
        """Raise an error. Not here: no serial port is open."""
        raise _no_port()

    def serialRead(self, _port: int, _length: int, _blocking: bool = False) -> NoReturn:
        """Raise an error. Not here: no serial port is open."""
        raise _no_port()

    def serialCheck(self, _port: int) -> NoReturn:
        """Raise an error. Not here: no serial port is open."""
        raise _no_port()


def _no_port() -> CommandError:
    return CommandError("no serial port is open: sim.serialOpen returns -1 on this server")
