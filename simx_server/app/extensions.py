"""Name the parts that a server has beside its world and its service: the lists of the gateways and of the watchers.

A new gateway is a folder with the contract of `gateways/gateway.py`, and a line here. Flags, conflicts of settings and
the embedded form follow. A new watcher overrides events of `service/watcher.py`, and has a line here.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.gateways.descriptors import DescriptorWatch
from simx_server.gateways.gateway import Entry
from simx_server.gateways.lane.gateway import open_lane
from simx_server.gateways.original import open_original
from simx_server.gateways.ros2.opening import open_ros2
from simx_server.gateways.script_ports import open_script_ports
from simx_server.gateways.zenoh.gateway import open_zenoh
from simx_server.gateways.zmq import open_zmq, open_zmq_viewers
from simx_server.gateways.zmq2 import open_zmq2, open_zmq2_viewers
from simx_server.history import History
from simx_server.service.ending import QuitAfterStop
from simx_server.service.service import Service
from simx_server.service.warm_up import RenderWatch, WarmUp
from simx_server.service.watcher import Watcher
from simx_server.settings.settings import Settings

GATEWAYS: Sequence[Entry] = (
    Entry((), open_lane),  # before Zenoh's, which offers it
    Entry(("ports", "listen", "connect"), open_zenoh),
    Entry(("legacy_ports",), open_original),
    Entry(("zmq",), open_zmq),
    Entry(("zmq_viewers",), open_zmq_viewers),
    Entry(("zmq2",), open_zmq2),
    Entry(("zmq2_viewers",), open_zmq2_viewers),
    Entry(("ros2",), open_ros2),
    Entry((), open_script_ports),  # behind those that have ports of the server
)
"""They are opened in this order, and closed in the other one."""

OPENING_SETTINGS = frozenset(name for entry in GATEWAYS for name in entry.settings)
"""Names of the settings each of which lets other processes connect."""


@dataclass(frozen=True, slots=True)
class Watching:
    """The server that a watcher is made for."""

    service: Service
    settings: Settings
    warms_up: bool
    """Images are prepared before a program gets the handle of a vision sensor."""


WATCHERS: Sequence[Callable[[Watching], Watcher | None]] = (
    lambda server: RenderWatch(server.service.world.rendering),
    lambda server: History(server.service, server.settings.history),
    lambda server: (
        WarmUp(server.service.world, at_once=server.settings.record is not None) if server.warms_up else None
    ),
    lambda server: (
        QuitAfterStop(server.service.ending, server.service.simulation)
        if server.settings.quit_after_stop
        else None
    ),
    lambda _server: DescriptorWatch(),
)
"""Each makes a watcher, or none if the settings want none. A recorder, and a keeper of moments for a successor, start
later: when the gateways' own clients are there (`app/server.py`).
"""
