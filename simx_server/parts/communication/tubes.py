"""Tubes: two scripts that open a tube of the same name are connected, and each reads what the other writes."""

from __future__ import annotations

from collections import deque
from dataclasses import field
from typing import TYPE_CHECKING

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import CommandError
from simx_server.simulation.part import Part

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation

MAX_PACKETS = 10_000
"""Most unread packets that one end keeps."""


@dataclass(eq=False)
class _End:
    """One end of a tube."""

    handle: int
    name: tuple[int, str]
    arrived: deque[bytes]
    waiting: deque[bytes] = field(default_factory=deque[bytes])
    """Packets written before the other end was opened."""
    other: _End | None = None


class Tubes(Part):
    """All tubes of the present run, whose end closes them."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._ends: dict[int, _End] = {}
        self._next_handle = 1

    def run_stopped(self) -> None:
        self._ends.clear()

    def open(self, header: int, name: str, size: int) -> int:
        """Open an end that keeps `size` unread packets, then drops the oldest; return its handle.

        It is connected to an unconnected end with this header and name, if there is one. Raises CommandError.
        """
        if not 0 < size <= MAX_PACKETS:
            raise CommandError(f"a tube keeps 1 to {MAX_PACKETS} packets, not {size}")
        self._sim.limits.check("tubes", len(self._ends) + 1, "close some")
        end = _End(self._next_handle, (header, name), deque(maxlen=size))
        self._next_handle += 1
        alone = next(
            (each for each in self._ends.values() if each.name == end.name and each.other is None), None
        )
        self._ends[end.handle] = end
        if alone is not None:
            end.other, alone.other = alone, end
            end.arrived.extend(alone.waiting)
            alone.waiting.clear()
        return end.handle

    def write(self, handle: int, data: bytes) -> None:
        """Write a packet; before the other end is open, the packet waits for it. Raises CommandError."""
        end = self._get(handle)
        if end.other is not None:
            end.other.arrived.append(data)
            return
        end.waiting.append(data)
        if len(end.waiting) > (end.arrived.maxlen or 0):
            end.waiting.popleft()

    def read(self, handle: int) -> bytes | None:
        """Return the oldest packet, or None. Raises CommandError."""
        end = self._get(handle)
        return end.arrived.popleft() if end.arrived else None

    def status(self, handle: int) -> tuple[bool, int, int]:
        """Return whether an end is connected, and the numbers of unread packets here and at the other end.

        Raises CommandError.
        """
        end = self._get(handle)
        written = end.waiting if end.other is None else end.other.arrived
        return end.other is not None, len(end.arrived), len(written)

    def close(self, handle: int) -> None:
        """Close an end; the other one may read the packets that arrived, and is unconnected. Raises CommandError."""
        end = self._get(handle)
        if end.other is not None:
            end.other.other = None
        del self._ends[handle]

    def _get(self, handle: int) -> _End:
        end = self._ends.get(handle)
        if end is None:
            raise CommandError(f"no tube with handle {handle} is open; tubes end with the run")
        return end
