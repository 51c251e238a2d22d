"""Serial ports of the machine, which scripts open if the operator allows it (``--allow-machine``)."""

from __future__ import annotations

import importlib
import importlib.util
import math
import os
import time
from typing import TYPE_CHECKING, Any

from simx_client.protocol.cli.installing import extra_line
from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import CommandError
from simx_server.simulation.part import Part

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation

    from .outside import Outside

MOST_PORTS = 16
MOST_BYTES = 1 << 20
"""Most bytes of one read."""

BAUD_RATES = range(1, 20_000_001)
_FAILED = -1


@dataclass(eq=False)
class SerialPort:
    """An open port."""

    name: str
    is_of_run: bool
    """It was opened during a run, so the end of the run closes it."""
    device: Any = None
    """pyserial's object; None in a replay."""
    unread: bytes = b""
    """Bytes that were received and that no program has read."""


class SerialPorts(Part):
    """All open ports. Physics thread only; no function of it waits for a device."""

    def __init__(self, sim: Simulation, outside: Outside, *, is_allowed: bool) -> None:
        """`is_allowed`: the operator lets scripts use devices of the machine."""
        self._sim = sim
        self._outside = outside
        self.is_allowed = is_allowed
        self._open: dict[int, SerialPort] = {}
        self._next = 0

    def run_stopped(self) -> None:
        for handle in [handle for handle, port in self._open.items() if port.is_of_run]:
            self.close(handle)

    def scene_changed(self) -> None:
        for handle in list(self._open):
            self.close(handle)

    def open(self, name: str, baud_rate: int) -> tuple[int, str]:
        """Open a port of 8 data bits without parity; return its handle, or -1 and what was wrong.

        Raises:
            CommandError: a baud rate that cannot be, or too many open ports.
        """
        if baud_rate not in BAUD_RATES:
            raise CommandError(
                f"a baud rate is a number from {BAUD_RATES[0]} to {BAUD_RATES[-1]}, not {baud_rate}"
            )
        if len(self._open) >= MOST_PORTS:
            raise CommandError(f"at most {MOST_PORTS} serial ports are open at a time; close some")
        port = SerialPort(name, self._sim.is_running)

        def act() -> list[Any]:
            port.device, problem = _opened(name, baud_rate)
            return [problem]

        (problem,) = self._outside.ask(act, str)
        if problem:
            return _FAILED, problem
        handle, self._next = self._next, self._next + 1
        self._open[handle] = port
        return handle, ""

    def get(self, handle: int) -> SerialPort:
        """Return an open port. Raises CommandError."""
        found = self._open.get(handle)
        if found is None:
            known = ", ".join(f"{number} ('{port.name[:80]}')" for number, port in self._open.items())
            raise CommandError(f"no serial port with handle {handle} is open; open are: {known or 'none'}")
        return found

    def close(self, handle: int) -> None:
        """Close a port. Raises CommandError as `get`."""
        port = self.get(handle)
        del self._open[handle]
        if port.device is not None:
            port.device.close()

    def send(self, handle: int, data: bytes) -> int:
        """Send as much as the device takes at once; return how many bytes, -1 if it is gone. Raises CommandError."""
        port = self.get(handle)

        def act() -> list[Any]:
            try:
                return [os.write(port.device.fileno(), data)]
            except BlockingIOError:
                return [0]
            except OSError:
                return [_FAILED]

        (sent,) = self._outside.ask(act, int)
        return sent

    def waiting(self, handle: int) -> int:
        """Return how many bytes can be read at once, -1 if the device is gone. Raises CommandError."""
        port = self.get(handle)

        def act() -> list[Any]:
            try:
                return [port.device.in_waiting]
            except OSError:
                return [_FAILED]

        (count,) = self._outside.ask(act, int)
        return count if count < 0 else count + len(port.unread)

    def read(self, handle: int, length: int) -> bytes:
        """Return the bytes that are there, at most this many. Raises CommandError."""
        port = self._readable(handle, length)
        self._receive(port, length)
        return self._taken(port, length)

    def read_whole(self, handle: int, length: int, closing: bytes, end: float) -> bytes | None:
        """Return a whole piece, or None while more has to be waited for.

        Args:
            handle: an open port.
            length: bytes of the piece.
            closing: bytes that end it earlier, and belong to it; empty for none.
            end: time of the monotonic clock from which on a part is returned.

        Raises:
            CommandError: no such port, or a length that cannot be.
        """
        port = self._readable(handle, length)
        is_late = self._receive(port, length, end)
        place = port.unread.find(closing) if closing else -1
        if len(port.unread) >= length:
            size = length
        elif place >= 0:
            size = place + len(closing)
        elif is_late:
            size = len(port.unread)
        else:
            return None
        return self._taken(port, size)

    def _readable(self, handle: int, length: int) -> SerialPort:
        if not 0 <= length <= MOST_BYTES:
            raise CommandError(f"a read has 0 to {MOST_BYTES} bytes, not {length}")
        return self.get(handle)

    def _receive(self, port: SerialPort, length: int, end: float = math.inf) -> bool:
        """Get what the device has, up to a length; return whether a time of the monotonic clock is over."""

        def act() -> list[Any]:
            is_late = time.monotonic() >= end
            try:
                data = port.device.read(max(0, length - len(port.unread)))
            except OSError:  # pyserial's errors are such; the device is gone
                data = b""
            return [data, is_late]

        data, is_late = self._outside.ask(act, bytes, bool)
        port.unread += data
        return is_late

    @staticmethod
    def _taken(port: SerialPort, size: int) -> bytes:
        taken, port.unread = port.unread[:size], port.unread[size:]
        return taken


def _opened(name: str, baud_rate: int) -> tuple[Any, str]:
    """Return pyserial's object of a port, or None and what was wrong."""
    if importlib.util.find_spec("serial") is None:
        return None, f"serial ports need a library that is not installed: {extra_line('serial')}"
    serial: Any = importlib.import_module("serial")
    try:
        return serial.Serial(name, baud_rate, timeout=0, exclusive=True), ""
    except (OSError, ValueError) as error:
        return None, f"serial port '{name[:200]}' cannot be opened: {error}"[:1000]
