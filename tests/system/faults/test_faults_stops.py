"""No stop hangs: whatever the clients and scripts of a server do, SIGTERM and Ctrl-C end it soon and cleanly."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from subprocess import Popen
from types import SimpleNamespace
from typing import cast

import pytest
import zenoh
from processes import read_line, running, server, spawn

import simx_client as v
from simx_server.gateways.zenoh.gateway import ZenohGateway
from simx_server.service.clients.admission.places import Entrance
from simx_server.service.server_loop import ServerLoop

pytestmark = [pytest.mark.slow, pytest.mark.gl, pytest.mark.usefixtures("no_connection_left")]

BLOCKING = v.simx_opmode_blocking
SOON = 5.0
"""Seconds; as long as a fleet gives each of its servers."""

SCENE = """
<mujoco>
  <option gravity="0 0 0"/>
  <worldbody>
    <body name="base"><joint name="hinge"/><geom size="0.1" mass="1"/></body>
    <camera name="eye" pos="0 -2 1" xyaxes="1 0 0 0 0 1" resolution="320 240"/>
  </worldbody>
  <custom>{scripts}</custom>
</mujoco>
"""
ENDLESS = (
    '<text name="simx:lua:base" data="function sysCall_actuation() while true do pcall(error) end end"/>'
)
CONNECT = """
import sys; sys.path.insert(0, '.'); import simx_client as v
v.simxStart('127.0.0.1', {port}, True, True, 5000, 5)
"""
PICTURES = """
eye = v.simxGetObjectHandle(0, 'eye', v.simx_opmode_blocking)[1]
v.simxGetVisionSensorImage(0, eye, 0, v.simx_opmode_streaming)
while v.simxGetVisionSensorImage(0, eye, 0, v.simx_opmode_buffer)[0]: pass
print('ready', flush=True)
sys.stdin.read()
"""
FLOOD = """
print('ready', flush=True)
while v.simxGetConnectionId(0) != -1:
    v.simxSetIntegerSignal(0, 'x', 1, v.simx_opmode_oneshot)
    v.simxGetObjects(0, v.sim_handle_all, v.simx_opmode_oneshot)
"""
MEGABYTES = """
from simx_client.connection.clients import CLIENTS
from simx_client.protocol.codec import encode
from simx_client.protocol.messages import Batch, Call
v.simxSetStringSignal(0, 'x', bytes(1_000_000), v.simx_opmode_blocking)
call = encode(Batch(0, 0, [Call(1, 0, 0, 'simxGetStringSignal', ['x'])]))
for _ in range(300): CLIENTS.get(0)._transport.send(call)
print('ready', flush=True)
sys.stdin.read()
"""
Record = Callable[[str, object], None]


@contextlib.contextmanager
def client(port: int, lines: str) -> Iterator[Popen[str]]:
    with running(spawn("-c", CONNECT.format(port=port) + lines)) as process:
        assert read_line(process).strip() == "ready"
        yield process


def scene_file(folder: Path, scripts: str = "") -> Path:
    path = folder / "busy.xml"
    path.write_text(SCENE.format(scripts=scripts))
    return path


def ended(process: Popen[str], number: signal.Signals) -> float:
    """Seconds until a process that is told to end has done so, and well."""
    began = time.monotonic()
    process.send_signal(number)
    assert process.wait(4 * SOON) == 0
    return time.monotonic() - began


def test_with_a_frozen_a_flooding_and_a_watching_client(tmp_path: Path, record_property: Record) -> None:
    with server(scene_file(tmp_path), "--start") as busy, contextlib.ExitStack() as stack:
        frozen = stack.enter_context(client(busy.port, PICTURES))
        frozen.send_signal(signal.SIGSTOP)
        stack.enter_context(client(busy.port, PICTURES))
        stack.enter_context(client(busy.port, FLOOD))
        took = ended(busy.process, signal.SIGTERM)
    record_property(
        "figures", f"SIGTERM with frozen, flooding and watching clients: ended after {took:.2f} s"
    )
    assert took < SOON


def test_with_a_client_that_froze_with_megabytes_on_their_way(
    tmp_path: Path, record_property: Record
) -> None:
    with server(scene_file(tmp_path), "--start") as busy, client(busy.port, MEGABYTES) as frozen:
        frozen.send_signal(signal.SIGSTOP)
        took = ended(busy.process, signal.SIGTERM)
    record_property("figures", f"SIGTERM with megabytes for a frozen client: ended after {took:.2f} s")
    assert took < SOON


def test_within_a_script_that_never_ends(tmp_path: Path, record_property: Record) -> None:
    """The script has a second more."""
    with server(scene_file(tmp_path, ENDLESS), "--start") as busy:
        took = ended(busy.process, signal.SIGINT)
    record_property("figures", f"Ctrl-C within an endless script: ended after {took:.2f} s")
    assert took < SOON


def test_a_fleet_of_three_of_which_one_runs_an_endless_script_and_one_is_frozen(
    tmp_path: Path, record_property: Record
) -> None:
    """The frozen one is killed when its time is over."""
    path = scene_file(tmp_path, ENDLESS)
    with running(spawn("-m", "simx_server", path, "--count", 3, "--port", 0)) as fleet:
        servers = json.loads(read_line(fleet))["servers"]
        cid = v.simxStart("127.0.0.1", servers[1]["ports"][0], True, True, 5000, 5)
        v.simxStartSimulation(cid, v.simx_opmode_oneshot)
        os.kill(servers[0]["pid"], signal.SIGSTOP)
        began = time.monotonic()
        fleet.send_signal(signal.SIGTERM)
        assert fleet.wait(4 * SOON) == 1  # one did not end well
        took = time.monotonic() - began
        for each in servers:
            with pytest.raises(ProcessLookupError):
                os.kill(each["pid"], 0)
    record_property(
        "figures", f"a fleet of three, one frozen, one in an endless script: ended after {took:.2f} s"
    )
    assert took < 2 * SOON


def test_when_zenoh_gives_up_on_a_client_that_takes_nothing(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    class Stuck:
        def close(self) -> None:
            raise zenoh.ZError("close operation timed out! at /x/close.rs:135.")

    gateway = ZenohGateway.__new__(ZenohGateway)
    gateway._session, gateway._zenoh = Stuck(), zenoh
    gateway._loop = cast(ServerLoop, SimpleNamespace(places=SimpleNamespace(close=lambda _door: None)))
    gateway._entrance = cast(Entrance, SimpleNamespace(door="zenoh"))
    gateway.close()
    assert "was not waited for: close operation timed out!" in caplog.text
