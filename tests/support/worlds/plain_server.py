"""A server process over Zenoh with the plain world: it starts at once, and its pictures are made at once.

``python plain_server.py`` serves on a free port, which it prints. ``simxGetObjects`` gives as many handles as
there are clients; ``simxGetStringSignal`` gives a megabyte.
"""

from __future__ import annotations

import sys
from concurrent.futures import Future
from typing import Any, cast

from plain_world import HANDLERS, PlainSimulation

from simx_client.protocol.commands import BY_NAME
from simx_server.gateways.zenoh.gateway import ZenohGateway
from simx_server.service.calls.registry import Handler
from simx_server.service.clock import Pacer
from simx_server.service.loop import ServerLoop
from simx_server.service.service import build_service

MEGABYTE = bytes(1_000_000)


def _picture(sim: PlainSimulation, handle: int, options: int) -> Future:
    future: Future = Future()
    future.set_result(([640, 480], bytes([sim.passes % 256]) * (640 * 480 * 3)))
    return future


def main() -> None:
    functions = {
        "simxGetVisionSensorImage": _picture,
        "simxGetObjects": lambda sim, kind: list(range(len(loop.service.clients.sessions))),
        "simxGetStringSignal": lambda sim, name: MEGABYTE,
    }
    handlers = {name: Handler(BY_NAME[name], function, False) for name, function in functions.items()}
    loop = ServerLoop(build_service(cast(Any, PlainSimulation()), {**HANDLERS, **handlers}, Pacer(1.0)))
    gateway = ZenohGateway(loop.service, ports=[0])
    sys.stdout.write(f"{gateway.ports[0]}\n")
    sys.stdout.flush()
    loop.run()


if __name__ == "__main__":
    main()
