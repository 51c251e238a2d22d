"""A gateway of a stranger is a folder (`tests/support/json_lines/`) and a line: it opens, serves, bounds and closes."""

from __future__ import annotations

import json
import socket
import threading
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
from json_lines.gateway import JSON_LINES
from processes import PENDULUM, wait_until

from simx_server.app.extensions import GATEWAYS
from simx_server.app.server import open_world
from simx_server.app.serving import Gateways, make_service, open_gateways
from simx_server.gateways.errors import GatewayError
from simx_server.gateways.gateway import Entry, Opening
from simx_server.service.loop import ServerLoop
from simx_server.settings.settings import Settings

TIMEOUT = 20.0


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    with ExitStack() as stack:
        yield stack


def opened(folder: Path, stack: ExitStack, *entries: Entry) -> tuple[ServerLoop, Gateways]:
    """Open these gateways behind the others, and run the loop in a thread."""
    scene = folder / "scene.xml"
    scene.write_text(PENDULUM)
    settings = Settings(scene=str(scene), ports=(0,), workspace=folder)
    world = open_world(settings, stack)
    loop = ServerLoop(make_service(world, settings))
    gateways = stack.enter_context(open_gateways(world, settings, loop.service, (*GATEWAYS, *entries)))
    thread = threading.Thread(target=loop.run)
    thread.start()
    stack.callback(thread.join, TIMEOUT)
    stack.callback(loop.service.ending.request)
    return loop, gateways


class Program:
    """A program that speaks JSON."""

    def __init__(self, gateways: Gateways, stack: ExitStack) -> None:
        port = int(gateways.endpoints[-1].removeprefix("json/127.0.0.1:"))
        self.socket = stack.enter_context(socket.create_connection(("127.0.0.1", port), TIMEOUT))
        self.lines = stack.enter_context(self.socket.makefile("rb"))

    def call(self, *words: Any) -> Any:
        self.socket.sendall(json.dumps(words).encode() + b"\n")
        return json.loads(self.lines.readline())


def test_its_clients_call_and_leave(tmp_path: Path, stack: ExitStack) -> None:
    loop, gateways = opened(tmp_path, stack, JSON_LINES)
    program = Program(gateways, stack)
    code, (hinge,) = program.call("simxGetObjectHandle", "hinge")
    assert code == 0
    assert program.call("simxGetJointPosition", hinge) == [0, [0.0]]
    assert program.call("simxGetJointPosition", 9999)[0] != 0
    assert len(loop.service.clients.sessions) == 1
    program.socket.shutdown(socket.SHUT_RDWR)
    assert wait_until(lambda: not loop.service.clients.sessions, TIMEOUT)


def test_who_breaks_the_rules_is_cut_and_others_go_on(tmp_path: Path, stack: ExitStack) -> None:
    _, gateways = opened(tmp_path, stack, JSON_LINES)
    bystander, bad = Program(gateways, stack), Program(gateways, stack)
    bad.socket.sendall(b"no JSON\n")
    assert bad.lines.readline() == b""
    assert bystander.call("simxGetObjectHandle", "hinge")[0] == 0


def test_it_closes_with_the_server(tmp_path: Path) -> None:
    with ExitStack() as stack, ExitStack() as clients:
        _, gateways = opened(tmp_path, stack, JSON_LINES)
        program = Program(gateways, clients)
        assert program.call("simxGetObjectHandle", "hinge")[0] == 0
        stack.close()
        assert program.lines.readline() == b""


def test_a_gateway_that_cannot_open_closes_those_before_it(tmp_path: Path, stack: ExitStack) -> None:
    before: list[Any] = []

    def fail(opening: Opening) -> None:
        before.extend(opening.opened)
        raise GatewayError("there is no such port")

    with pytest.raises(GatewayError, match="no such port"):
        opened(tmp_path, stack, JSON_LINES, Entry((), fail))
    assert before
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.1", before[-1].port), TIMEOUT)
