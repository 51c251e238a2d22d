"""Functions with which scripts of V-REP scenes start the remote API: ``simExtRemoteApiStart``, later
``simRemoteApi.start``.

The server offers the remote API at its own ports in any case.
`parts/communication/script_ports.py` explains when others are open.
"""

from __future__ import annotations

from simx_server.errors import CommandError

from .base import ApiPart

_STARTED, _FAILED = 1, -1

_NOT_THERE, _OFFERED = -1, 0
"""Results of status: no such server; a server that waits for its client."""


class RemoteApiNamespace(ApiPart, effect="changes"):
    """The functions of ``simRemoteApi``."""

    PLUGIN = "simRemoteApi"

    def start(
        self, port: int, _max_packet_size: int = 1300, _debug: bool = False, _pre_enable_trigger: bool = False
    ) -> int:
        """Offer the remote API at a port too, and return 1, or -1 if the port cannot be opened; the log says why. It
        closes with the run, unless the script's text names the port: then it is open as long as the scene.

        Partly: packet size, debug mode and trigger are ignored; any number of clients may connect.
        """
        try:
            self._world.script_ports.start(port)
        except CommandError as problem:
            self._say_once(f"the remote API cannot be started at port {port}: {problem}")
            return _FAILED
        return _STARTED

    def stop(self, port: int) -> int:
        """Close a port that a script has opened, with its clients, and return 1; -1 for any other port.

        Partly: the server's own ports stay open.
        """
        return _STARTED if self._world.script_ports.stop(port) else _FAILED

    def reset(self, port: int) -> int:
        """Return 1, or -1 for a port at which nothing is offered. Partly: clients stay connected."""
        return _STARTED if self._world.script_ports.is_offered(port) else _FAILED

    def status(self, port: int) -> int:
        """Return -1 for a port at which nothing is offered, else 0. Partly: it tells nothing of the clients."""
        return _OFFERED if self._world.script_ports.is_offered(port) else _NOT_THERE


class RemoteApiFunctions(ApiPart, effect="changes"):
    """The same functions with the names of the old plugin, such as ``simExtRemoteApiStart``."""

    def extRemoteApiStart(
        self, port: int, _max_packet_size: int = 1300, _debug: bool = False, _pre_enable_trigger: bool = False
    ) -> int:
        """Do the same as simRemoteApi.start. Partly: as there."""
        return RemoteApiNamespace(self._world, self._script).start(port)

    def extRemoteApiStop(self, port: int) -> int:
        """Do the same as simRemoteApi.stop. Partly: as there."""
        return RemoteApiNamespace(self._world, self._script).stop(port)

    def extRemoteApiReset(self, port: int) -> int:
        """Do the same as simRemoteApi.reset. Partly: as there."""
        return RemoteApiNamespace(self._world, self._script).reset(port)

    def extRemoteApiStatus(self, port: int) -> int:
        """Do the same as simRemoteApi.status. Partly: as there."""
        return RemoteApiNamespace(self._world, self._script).status(port)
