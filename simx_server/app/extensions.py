"""Name the parts that a server has beside its world and its loop: the one list of the gateways.

A new one is a folder with the contract of `gateways/gateway.py`, and a line here. Flags, conflicts of settings and the
embedded form follow.
"""

from __future__ import annotations

from collections.abc import Sequence

from simx_server.gateways.gateway import Entry
from simx_server.gateways.lane.gateway import open_lane
from simx_server.gateways.original.gateway import open_original
from simx_server.gateways.ros2.opening import open_ros2
from simx_server.gateways.script_ports import open_script_ports
from simx_server.gateways.zenoh.gateway import open_zenoh
from simx_server.gateways.zmq import open_zmq, open_zmq_viewers

GATEWAYS: Sequence[Entry] = (
    Entry((), open_lane),  # before Zenoh's, which offers it
    Entry(("ports", "listen", "connect"), open_zenoh),
    Entry(("legacy_ports",), open_original),
    Entry(("zmq",), open_zmq),
    Entry(("zmq_viewers",), open_zmq_viewers),
    Entry(("ros2",), open_ros2),
    Entry((), open_script_ports),  # behind those that have ports of the server
)
"""They are opened in this order, and closed in the other one."""

OPENING_SETTINGS = frozenset(name for entry in GATEWAYS for name in entry.settings)
"""Names of the settings each of which lets other processes connect."""
