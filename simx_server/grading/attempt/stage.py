"""The process with the server of one attempt.

It gets the task's scene, rules and settings as a line of JSON, and no checks. The program reaches it by a socket alone.
It prints a line of JSON when it is ready and when the run is over, and ends with its parent.
"""

from __future__ import annotations

import json
import os
import socket
import sys
from contextlib import ExitStack
from typing import Any, NamedTuple

from simx_client.protocol.cli.exit_codes import FAILURE
from simx_server.processes import log_format
from simx_server.processes.lifeline import end_with
from simx_server.sensors.opengl.mujoco_import import import_mujoco


class Stage(NamedTuple):
    """The line of JSON that the process reads."""

    settings: dict[str, Any]
    """Of the server, by the names of flags."""

    rules: dict[str, Any]
    """Fields of `Rules`."""

    program: int
    """The socket of the program."""

    random: dict[str, Any]
    """Random values by the names of properties, as the task's file has them."""

    seed: int


def main() -> int:
    """Serve one attempt. Returns the exit code."""
    stage = Stage(**json.loads(sys.stdin.readline()))
    end_with(sys.stdin.fileno())
    log_format.configure("warning", "text", several=False)
    import_mujoco()
    return _serve(stage)


def _serve(stage: Stage) -> int:
    from simx_server.app.server import open_world, run_server
    from simx_server.errors import CommandError, StartError
    from simx_server.gateways.lane.handed import HandedLanes
    from simx_server.recording import Recorder
    from simx_server.service.service import Service
    from simx_server.settings.gathering import gather
    from simx_server.world.world import World

    from .random_values import set_random
    from .rules import PROGRAM, Supervision, rules_of

    class Reporting(Supervision):
        """Says when the run is over; the server goes on until it is ended, so that the program ends in order."""

        def is_over(self) -> None:
            _say({"over": self.over})

    served: list[Service] = []

    def attach(world: World, service: Service) -> None:
        service.watchers.add(Reporting(rules_of(stage.rules), world.simulation))
        door = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET, 0, fileno=stage.program)
        HandedLanes(service, door, PROGRAM)
        served.append(service)

    def ready(_gateways: object, _world: object) -> None:
        _say({"drawn": set_random(served[0], stage.random, stage.seed)})

    with ExitStack() as stack:
        try:
            settings = gather(stage.settings, {})
            assert settings.record is not None
            recorder = Recorder(settings.record, settings)
            stack.callback(recorder.close)
            world = open_world(settings, stack, recorder.watch)
            return run_server(world, settings, ready, recorder=recorder, attach=attach, is_listed=False)
        except (CommandError, StartError, ValueError) as problem:
            _say({"problem": str(problem)})
            return FAILURE


def _say(fields: dict[str, Any]) -> None:
    os.write(sys.stdout.fileno(), json.dumps(fields).encode() + b"\n")


if __name__ == "__main__":
    sys.exit(main())
