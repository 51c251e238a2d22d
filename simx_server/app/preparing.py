"""Do once, before the forks of a process, what each server would do at its start: imports and tables, so no threads.

A server that follows a crashed one is then ready a few hundred milliseconds earlier on a busy machine, and all share
the memory.
"""

from __future__ import annotations

import contextlib
import importlib

from simx_server.scripting.interpreter import ScriptError
from simx_server.scripting.lua import prepared
from simx_server.settings.settings import Settings
from simx_server.sim_api.namespaces import Namespaces
from simx_server.world.world import World


def prepare(world: World, settings: Settings) -> None:
    """Import the gateways that the settings open, and describe the API if a script or such a gateway needs it."""
    has_zmq = any((settings.zmq, settings.zmq_viewers, settings.zmq2, settings.zmq2_viewers))
    if has_zmq:
        from simx_server.gateways.zmq.gateway import missing

        missing()  # it imports cbor2
    if settings.ros2 is not None:
        importlib.import_module("simx_server.gateways.ros2.gateway")
    if world.scripts.all():
        importlib.import_module("simx_server.scripting.lua.interpreter")
    if has_zmq or world.scripts.all():
        names = Namespaces.names()
        with contextlib.suppress(ScriptError):  # without lupa Lua scripts do not run, and say so
            prepared.chunks()
            prepared.names(names)
