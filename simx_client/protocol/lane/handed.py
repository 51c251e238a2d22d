"""A socket by which a server hands connections to one process, see `simx_client.transport.handed`."""

from __future__ import annotations

VARIABLE = "SIMX_SOCKET"
"""The number of this process's end of the socket pair; all connections of the process come from there."""

REQUEST = b"lane"
"""The message that asks for a connection, and comes with it."""
