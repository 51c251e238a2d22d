"""Functions that only read by the table, so that viewers may call them, change nothing visible."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice, product
from pathlib import Path
from typing import Any

import pytest
from real_world import BLOCKING, RealWorld

import simx_client as v
from simx_client.calls.marshalling import Marshal
from simx_client.client import Client
from simx_client.protocol.commands import ANSWERED, Command, Effect, Place
from simx_client.protocol.constants import sim_handle_all

pytestmark = [pytest.mark.slow, pytest.mark.gl]

SCENE = Path(__file__).parents[2] / "conformance" / "scene.xml"
READERS = [command for name, command in ANSWERED.items() if command.only_reads and name == command.name]
NUMBERS = (0, 1, 2, 3, 5, 8, 9, 10, 13, 109, 1000, 1002, 2012, 3003, -1)
"""Types of objects, of data and of parameters."""
MOST = 600
"""Calls of one command."""


@pytest.fixture(scope="module")
def world() -> Iterator[tuple[RealWorld, int]]:
    world = RealWorld(SCENE)
    client = world.client()
    v.simxSetIntegerSignal(client, "i", 1, BLOCKING)
    v.simxSetFloatSignal(client, "f", 1.0, BLOCKING)
    v.simxSetStringSignal(client, "s", b"text", BLOCKING)
    v.simxAuxiliaryConsoleOpen(client, "c", 5, 0, None, None, None, None, BLOCKING)
    v.simxDisplayDialog(client, "d", "text", v.sim_dlgstyle_ok, "", None, None, BLOCKING)
    yield world, client
    world.close()


def noticed(world: RealWorld) -> list[Any]:
    """The state that is visible to others."""
    sim, data = world.simulation, world.simulation.data
    shown = world.parts.user_interface.describe()
    signals = [
        dict(world.parts.signals.integers),
        dict(world.parts.signals.floats),
        dict(world.parts.signals.strings),
    ]
    arrays = [
        array.tobytes()
        for array in (data.qpos, data.qvel, data.ctrl, sim.model.body_pos, sim.model.geom_rgba)
    ]
    objects = [(handle, item.name) for handle, item in sim.scene.objects.items()]
    files = sorted(sim.files.workspace.glob("simx-*"))
    return [
        sim.state,
        sim.model_version,
        world.parts.selection.handles,
        objects,
        signals,
        arrays,
        shown,
        files,
    ]


def arguments(command: Command, handles: list[int]) -> Iterator[tuple[Any, ...]]:
    """Calls that get somewhere, and some that do not."""
    choices: list[list[Any]] = []
    for argument in command.arguments:
        if argument.kind.name == "int":
            choices.append([*handles, -1] if argument.meaning.finder else list(NUMBERS))
        else:
            texts = ["robot", "i", "f", "s", "cube#0", "mass", "pose"]
            known: dict[str, list[Any]] = {"text": texts, "bool": [False, True]}
            choices.append(known.get(argument.kind.name, [argument.kind.default()]))
    return islice(product(*choices), MOST)


@pytest.mark.parametrize("command", READERS, ids=lambda command: command.name)
def test_command_that_only_reads_changes_nothing(world: tuple[RealWorld, int], command: Command) -> None:
    there, client = world
    handles = v.simxGetObjects(client, sim_handle_all, BLOCKING)[1]
    mode = [BLOCKING] if command.place is Place.REMOTE else []
    if command.never_blocking:
        mode = [v.simx_opmode_oneshot]
    before = noticed(there)
    for given in arguments(command, handles):
        if command.place is Place.CARRIED:  # without a public function
            with Client.of(client).batch(check=False) as calls:
                calls.note(Marshal(command), given)
        else:
            getattr(v, command.name)(client, *given, *mode)
    v.simxGetPingTime(client)
    assert noticed(there) == before


def test_those_that_take_away_what_they_read_are_no_readers() -> None:
    taking = {command.name for command in ANSWERED.values() if command.effect is Effect.TAKES}
    assert taking
    assert not taking & {command.name for command in READERS}
    assert len(READERS) > 40
