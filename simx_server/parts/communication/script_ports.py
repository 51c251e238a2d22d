"""Ports at which scripts offer the remote API: `simRemoteApi.start(20000)`.

In V-REP such a port existed while the script ran. Here a port that a script's text names is open as long as the scene
is loaded, and a client that connects there starts a stopped simulation, since the server has no start button. A port
that a script computes is open from the call to the end of the run.
"""

from __future__ import annotations

import logging
from collections.abc import Collection
from typing import TYPE_CHECKING, Protocol

from simx_server.errors import CommandError
from simx_server.simulation.part import Part

if TYPE_CHECKING:
    from simx_server.parts.status_bar import StatusBar
    from simx_server.simulation.simulation import Simulation

logger = logging.getLogger(__name__)

MOST_PORTS = 16
"""Most ports that the scripts of one scene may open."""

HIGHEST = 65535


class Doors(Protocol):
    """The network as this part sees it; `gateways/script_doors.py` implements it."""

    own: Collection[int]
    """Ports that the server itself offers."""

    def open(self, port: int) -> None:
        """Offer a port to clients. Raises CommandError: it is taken or not allowed."""
        ...

    def close(self, port: int) -> None:
        """Close a port soon, with its clients: answers that are on their way still arrive."""
        ...


class ScriptPorts(Part):
    """The ports of the present scene's scripts. Physics thread only."""

    def __init__(self, sim: Simulation, status_bar: StatusBar) -> None:
        self._sim = sim
        self._status_bar = status_bar
        self.named: set[int] = set()
        """Ports in the texts of the scene's scripts; a client that connects to one starts the simulation."""
        self._open: set[int] = set()
        self._doors: Doors | None = None

    def serve(self, doors: Doors) -> None:
        """Open the ports from now on; a server without network has none of them."""
        self._doors = doors
        for port in sorted(self.named):
            self._open_named(port)

    def scene_changed(self) -> None:
        self._close(set(self._open))
        self.named.clear()

    def run_stopped(self) -> None:
        self._close(self._open - self.named)

    def name(self, ports: Collection[int]) -> None:
        """Note the ports in a script's text, and open them."""
        for port in ports:
            if port not in self.named and len(self.named) < MOST_PORTS:
                self.named.add(port)
                self._open_named(port)

    def start(self, port: int) -> None:
        """Offer the remote API at a port.

        Raises:
            CommandError: the port cannot be opened; the text says why.
        """
        if not 0 < port <= HIGHEST:
            raise CommandError(f"{port} is not a port; those are 1 to {HIGHEST}")
        if self._doors is None or port in self._open or port in self._doors.own:
            return
        if len(self._open) >= MOST_PORTS:
            raise CommandError(
                f"the scripts of a scene may open {MOST_PORTS} ports; stop some with simRemoteApi.stop"
            )
        self._doors.open(port)
        self._open.add(port)
        logger.info("clients reach the remote API at port %d too, which a script has started", port)

    def stop(self, port: int) -> bool:
        """Close a port that scripts have opened; return False for any other one."""
        is_open = port in self._open
        self._close({port} & self._open)
        return is_open

    def is_offered(self, port: int) -> bool:
        """Return whether clients can connect to a port."""
        return port in self._open or (self._doors is not None and port in self._doors.own)

    def _open_named(self, port: int) -> None:
        if self._doors is None:
            return
        try:
            self.start(port)
        except CommandError as problem:
            logger.warning("a script of the scene starts the remote API at port %d, but %s", port, problem)
            self._status_bar.add(f"a script starts the remote API at port {port}, but {problem}")

    def _close(self, ports: Collection[int]) -> None:
        for port in ports:
            self._open.discard(port)
            if self._doors is not None:
                self._doors.close(port)
