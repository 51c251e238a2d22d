"""Functions with which scripts of V-REP scenes start the remote API: ``simExtRemoteApiStart``, later
``simRemoteApi.start``.

Here the server always offers it, at the ports that it was started with, so there is nothing to start: the call prints
this to the status bar, and the script continues.
"""

from __future__ import annotations

from .base import ApiPart


class RemoteApiNamespace(ApiPart):
    """The functions of ``simRemoteApi``; a port that a script names may differ from the server's."""

    def start(
        self, port: int, _max_packet_size: int = 1300, _debug: bool = False, _pre_enable_trigger: bool = False
    ) -> int:
        """Return 1. Partly: no other port is opened."""
        self._world.status_bar.add(
            f"the remote API is offered at the ports the server was started with; a script asked for port {port}: "
            f"start the server with --port {port} if clients are to connect there"
        )
        return 1

    def stop(self, _port: int) -> int:
        """Return 1. Partly: clients stay connected."""
        return 1

    def reset(self, _port: int) -> int:
        """Return 1. Partly: clients stay connected."""
        return 1


class RemoteApiFunctions(ApiPart):
    """The same functions with the names of the old plugin, such as ``simExtRemoteApiStart``."""

    def extRemoteApiStart(
        self, port: int, _max_packet_size: int = 1300, _debug: bool = False, _pre_enable_trigger: bool = False
    ) -> int:
        """Return 1. Partly: no other port is opened."""
        return RemoteApiNamespace(self._world, self._script).start(port)

    def extRemoteApiStop(self, _port: int) -> int:
        """Return 1. Partly: clients stay connected."""
        return 1

    def extRemoteApiReset(self, _port: int) -> int:
        """Return 1. Partly: clients stay connected."""
        return 1
