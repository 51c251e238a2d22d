"""Random programs give the same with the short ways of an embedded client as by messages' values."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from seeds import seeds

import simx_client as v
from simx_client.client import Client
from simx_client.connection.clients import CLIENTS
from simx_client.connection.embedded import EmbeddedConnection
from simx_server.gateways.embedded.transport import EmbeddedTransport
from simx_server.service import due

SCENE = """
<mujoco>
  <option timestep="0.005"/>
  <worldbody>
    <body name="arm" pos="0 0 1">
      <joint name="hinge" axis="0 1 0" ref="0.25" range="-3 3" limited="true"/>
      <geom name="link" size="0.05" pos="0.3 0 0"/>
      <body name="tip" pos="0.3 0 0"><joint name="slider" type="slide" axis="0 0 1"/><geom size="0.05"/></body>
    </body>
    <body name="wheel" pos="1 0 1"><joint name="axle" axis="0 0 1"/><geom size="0.1" pos="0.1 0 0"/></body>
  </worldbody>
  <actuator><motor joint="hinge"/><motor joint="slider"/><motor joint="axle"/></actuator>
  <custom>
    <text name="simx:joint:hinge" data="motor=on control=position max_force=50"/>
    <text name="simx:joint:slider" data="motor=on control=position max_force=50"/>
    <text name="simx:joint:axle" data="cyclic=yes motor=on control=position"/>
  </custom>
</mujoco>
"""

MODES = {
    "streaming": v.simx_opmode_streaming,
    "buffer": v.simx_opmode_buffer,
    "oneshot": v.simx_opmode_oneshot,
    "blocking": v.simx_opmode_blocking,
    "discontinue": v.simx_opmode_discontinue,
    "remove": v.simx_opmode_remove,
}
READ = ("buffer",) * 60 + ("streaming",) * 6 + tuple(MODES)
SET = ("oneshot", "oneshot", "blocking")

Step = Callable[[int, random.Random], Any]


def reading(read: Callable[..., Any], *names: str) -> Step:
    def step(client: int, chance: random.Random) -> Any:
        mode = chance.choice(READ)
        return mode, read(client, handle_of(client, chance.choice(names)), MODES[mode])

    return step


def setting(write: Callable[..., Any], *names: str) -> Step:
    def step(client: int, chance: random.Random) -> Any:
        mode, value = chance.choice(SET), chance.choice((0, 0.1, -1.5, 7.0, 1e300, math.nan))
        return mode, write(client, handle_of(client, chance.choice(names)), value, MODES[mode])

    return step


def place(client: int, handle: int, mode: int) -> Any:
    return v.simxGetObjectPosition(client, handle, -1, mode)


def paused(client: int, chance: random.Random) -> Any:
    handle = handle_of(client, "hinge")
    return (
        v.simxPauseCommunication(client, True),
        v.simxGetJointPosition(client, handle, v.simx_opmode_buffer),
        v.simxSetJointTargetPosition(client, handle, chance.uniform(-1, 1), v.simx_opmode_oneshot),
        v.simxPauseCommunication(client, False),
    )


def restart(client: int, _: random.Random) -> Any:
    return (
        v.simxStopSimulation(client, v.simx_opmode_blocking),
        v.simxSynchronous(client, True),
        v.simxStartSimulation(client, v.simx_opmode_blocking),
    )


JOINTS = ("hinge", "slider", "axle")
STEPS: list[tuple[int, Step]] = [
    (50, reading(v.simxGetJointPosition, *JOINTS, "arm")),
    (3, reading(place, "tip", "wheel")),
    (10, setting(v.simxSetJointTargetPosition, *JOINTS, "arm")),
    (5, setting(v.simxSetJointPosition, *JOINTS)),
    (12, lambda client, _: v.simxSynchronousTrigger(client)),
    (1, lambda client, _: v.simxGetPingTime(client)[0]),
    (1, lambda client, _: v.simxGetLastErrors(client, v.simx_opmode_blocking)),
    (1, lambda client, _: v.simxGetInMessageInfo(client, v.simx_headeroffset_server_state)),
    (1, lambda client, _: v.simxGetInMessageInfo(client, v.simx_headeroffset_scene_id)),
    (1, paused),
    (1, restart),
]
_handles: dict[str, int] = {}


def handle_of(client: int, name: str) -> int:
    if name not in _handles:
        _handles[name] = v.simxGetObjectHandle(client, name, v.simx_opmode_blocking)[1]
    return _handles[name]


def told(client: Client, seed: int) -> list[Any]:
    """Return the result of each call of a random program, and the time of the newest value."""
    chance, weights = random.Random(seed), [weight for weight, _ in STEPS]
    found: list[Any] = []
    restart(client.id, chance)
    for name in (*JOINTS, "arm", "tip", "wheel"):
        handle_of(client.id, name)
    for (_, step), number in zip(chance.choices(STEPS, weights, k=500), range(500), strict=True):
        found.append((number, repr(step(client.id, chance)), v.simxGetLastCmdTime(client.id)))
    found.append(sorted(counted(client).items()))
    return found


def counted(client: Client) -> dict[str, int]:
    """How often the server has executed each function, for calls and streams."""
    times = transport_of(client)._service.metrics.command_times
    return {name: sum(each.counts) for name, each in times.items()}


def transport_of(client: Client) -> EmbeddedTransport:
    found = CLIENTS.get(client.id)
    assert isinstance(found, EmbeddedConnection)
    assert isinstance(found._direct, EmbeddedTransport)
    return found._direct


def without_short_ways(client: Client, monkeypatch: pytest.MonkeyPatch) -> None:
    """Have each call executed by its handler, and each value of a stream computed after its step."""
    monkeypatch.setattr(transport_of(client), "copies_positions", False)
    monkeypatch.setattr(transport_of(client)._service.addresses, "shortcut", lambda _: None)
    monkeypatch.setattr(transport_of(client), "stream_way", lambda *_: None)


@pytest.mark.parametrize("seconds", [0.0, math.inf], ids=["due at each look", "due after steps"])
@pytest.mark.parametrize("seed", seeds(8))
def test_short_ways_change_nothing(
    seed: int, seconds: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(due, "IDLE_INTERVAL", seconds)
    file = tmp_path / "scene.xml"
    file.write_text(SCENE)
    results: list[list[Any]] = []
    for is_short in (True, False):
        _handles.clear()
        with Client.embedded(str(file)) as client:
            if not is_short:
                without_short_ways(client, monkeypatch)
            results.append(told(client, seed))
    assert results[0] == results[1]
