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
    """What the process needs to know."""

    settings: dict[str, Any]
    """Of the server, by the names of flags."""

    rules: dict[str, Any]
    """Fields of `Rules`."""

    program: int
    """The socket of the program, and that of the grader."""

    grader: int


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
    from simx_server.settings.settings import Settings
    from simx_server.world.world import World

    from .rules import PROGRAM, Supervision, rules_of

    class Reporting(Supervision):
        """Says when the run is over; the server goes on until it is ended, so that the program ends in order."""

        def is_over(self) -> None:
            _say({"over": self.over})

    def attach(world: World, service: Service) -> None:
        service.watchers.add(Reporting(rules_of(stage.rules), world.simulation))
        for number, name in ((stage.program, PROGRAM), (stage.grader, "grader")):
            HandedLanes(service, _socket(number), name)

    with ExitStack() as stack:
        try:
            settings = Settings.gather(stage.settings, {})
            assert settings.record is not None
            recorder = Recorder(settings.record, settings)
            stack.callback(recorder.close)
            world = open_world(settings, stack, recorder.watch)
            return run_server(world, settings, _ready, recorder=recorder, attach=attach, is_listed=False)
        except (CommandError, StartError, ValueError) as problem:
            _say({"problem": str(problem)})
            return FAILURE


def _ready(_gateways: object, _world: object) -> None:
    _say({"ready": True})


def _socket(number: int) -> socket.socket:
    return socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET, 0, fileno=number)


def _say(fields: dict[str, Any]) -> None:
    os.write(sys.stdout.fileno(), json.dumps(fields).encode() + b"\n")


if __name__ == "__main__":
    sys.exit(main())
