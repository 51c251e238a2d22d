"""Tubes between scripts, see `tubes.py` of the server."""

from __future__ import annotations

from simx_server.scripting.interpreter import Waiting
from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.effects import no_edit, reads


class TubeFunctions(ApiPart, effect="changes"):
    """Functions for tubes. Two scripts that open a tube with the same header and name are connected."""

    def tubeOpen(self, header: int, name: str, size: int, _unused: bool = False) -> int:
        """Open a tube and return its handle. `size`: packets stored until they are read, then the oldest is dropped."""
        return self._world.tubes.open(header, name, size)

    def tubeClose(self, tube: int) -> int:
        self._world.tubes.close(tube)
        return 1

    @no_edit
    def tubeWrite(self, tube: int, data: bytes) -> int:
        """Write a packet; packets written before the other end is open are stored for it."""
        self._world.tubes.write(tube, data)
        return 1

    @no_edit
    def tubeRead(self, tube: int, blocking: bool = False) -> bytes | Waiting | None:
        """Return the oldest packet that has arrived, nil when there is none; blocking waits for one, in a thread."""
        return self._wait_for_packet(tube) if blocking else self._world.tubes.read(tube)

    @reads
    def tubeStatus(self, tube: int) -> tuple[int, int, int]:
        """Return 1 when connected, else 0; the number of packets to read; the number of packets that the other side
        has not read.
        """
        connected, arrived, written = self._world.tubes.status(tube)
        return int(connected), arrived, written

    def _wait_for_packet(self, tube: int) -> Waiting:
        while (data := self._world.tubes.read(tube)) is None:
            yield
        return (data,)
