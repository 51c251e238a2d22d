"""Programs and serial ports of the machine, which scripts use if the operator allows it (``--allow-machine``)."""

from __future__ import annotations

import math
import time

from simx_server.scripting.interpreter import Waiting

from .base import ApiPart
from .effects import runs_code

_FAILED, _STARTED = -1, 1
_NOT_ALLOWED = "scripts start no programs and use no serial ports on a server without --allow-machine"


class ProcessFunctions(ApiPart, effect="changes"):
    """Functions for other programs and devices. Without ``--allow-machine`` they fail as V-REP's do without them."""

    @runs_code
    def launchExecutable(self, file: str, arguments: str = "", _shown: int = 1) -> int:
        """Start a program in the workspace and return 1, or -1 if it cannot be started. The file is one of the
        workspace, or a command that the system finds, which may have @ in front. It goes on when the server ends. A
        server needs --allow-machine for it; a replay starts none.
        """
        programs = self._world.programs
        if not programs.is_allowed:
            self._say_once(
                f"{_NOT_ALLOWED}: start '{file[:200]}' yourself"
                + (f" (arguments: {arguments[:200]})" if arguments else "")
            )
            return _FAILED
        return self._told(programs.start(file, arguments), _STARTED)

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

    def serialOpen(self, port: str, baud_rate: int = 9600) -> int:
        """Open a serial port, such as /dev/ttyUSB0, with 8 data bits and without parity; return its handle, or -1 if it
        cannot be opened. The end of the run closes it. A server needs --allow-machine for it, and the extra `serial`;
        a recording has what was read.
        """
        ports = self._world.serial_ports
        if not ports.is_allowed:
            self._say_once(f"{_NOT_ALLOWED}, such as '{port[:200]}'")
            return _FAILED
        handle, problem = ports.open(port, baud_rate)
        return self._told(problem, handle)

    def serialClose(self, port: int) -> None:
        """Close a serial port."""
        self._world.serial_ports.close(port)

    def serialSend(self, port: int, data: bytes) -> int:
        """Send data and return how many bytes the device has taken, -1 if the device is gone."""
        return self._world.serial_ports.send(port, data)

    def serialRead(
        self, port: int, length: int, blocking: bool = False, closing: bytes = b"", seconds: float = 0.0
    ) -> bytes | Waiting:
        """Return the received bytes, at most `length`. A blocking read waits in a thread until that many are there,
        until `closing` was received, which belongs to the result, or for some seconds of the wall clock (0: any time).
        """
        if not blocking:
            return self._world.serial_ports.read(port, length)
        return self._read_whole(port, length, closing, seconds)

    def _read_whole(self, port: int, length: int, closing: bytes, seconds: float) -> Waiting:
        end = time.monotonic() + seconds if seconds > 0 else math.inf
        while True:
            data = self._world.serial_ports.read_whole(port, length, closing, end)
            if data is not None:
                return (data,)
            yield

    def serialCheck(self, port: int) -> int:
        """Return how many received bytes wait to be read, -1 if the device is gone."""
        return self._world.serial_ports.waiting(port)

    serialPortOpen = serialOpen
    serialPortClose = serialClose
    serialPortSend = serialSend
    serialPortRead = serialRead

    def _told(self, problem: str, result: int) -> int:
        """Return a result, or -1 with a line in the status bar if there was a problem."""
        if not problem:
            return result
        self._world.status_bar.add(problem)
        return _FAILED
