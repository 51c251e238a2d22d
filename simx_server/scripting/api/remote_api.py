"""What scripts of V-REP scenes call to offer the remote API: ``simExtRemoteApiStart``, later ``simRemoteApi.start``.

Here the server offers it all the time, at the ports that it was started with, so there is nothing to start: a script is
told so in the status bar and goes on.
"""

from __future__ import annotations

from .base import ApiPart


class RemoteApiNamespace(ApiPart):
    """``simRemoteApi``; ports are those a script names, which need not be the server's."""

    def start(
        self, port: int, _max_packet_size: int = 1300, _debug: bool = False, _pre_enable_trigger: bool = False
    ) -> int:
        """Partly: no other port is opened; 1."""
        self._world.status_bar.add(
            f"the remote API is offered at the ports the server was started with; a script asked for port {port}: "
            f"start the server with --port {port} if clients are to connect there"
        )
        return 1

    def stop(self, _port: int) -> int:
        """Partly: clients stay connected; 1."""
        return 1

    def reset(self, _port: int) -> int:
        """Partly: clients stay connected; 1."""
        return 1


class RemoteApiFunctions(ApiPart):
    """The same by the names of the old plug-in, as ``simExtRemoteApiStart``."""

    def extRemoteApiStart(
        self, port: int, _max_packet_size: int = 1300, _debug: bool = False, _pre_enable_trigger: bool = False
    ) -> int:
        """Partly: no other port is opened; 1."""
        return RemoteApiNamespace(self._world, self._script).start(port)

    def extRemoteApiStop(self, _port: int) -> int:
        """Partly: clients stay connected; 1."""
        return 1

    def extRemoteApiReset(self, _port: int) -> int:
        """Partly: clients stay connected; 1."""
        return 1
