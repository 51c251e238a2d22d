"""The state after a step of a recording, by the names of objects, and what differs between two of them."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import NamedTuple

from simx_server.app.server import open_world
from simx_server.joints.joints import JOINT_TYPES
from simx_server.recording.log_file import LogReader
from simx_server.recording.opened import Opened
from simx_server.recording.replaying import replay
from simx_server.scene.objects import ObjectKind
from simx_server.scene.poses.frames import get_pose
from simx_server.settings.settings import Settings
from simx_server.world.world import World


class Quantity(NamedTuple):
    """One quantity of an object; two sort by object and name."""

    owner: str
    name: str
    unit: str


class Named(NamedTuple):
    """The state after a step."""

    time: float
    """Seconds since the start of the run."""

    values: Mapping[Quantity, tuple[float, ...]]


class Departure(NamedTuple):
    """A quantity that differs."""

    quantity: Quantity
    one: tuple[float, ...] | None
    """None: the first recording has no such object."""

    other: tuple[float, ...] | None
    size: float
    """The largest difference of its numbers; infinite where one is missing."""


def state_after(recording: Path, step: int, chosen: Settings) -> Named:
    """Replay a recording up to a step.

    Args:
        recording: the file.
        step: counted from 1 over all runs of the recording.
        chosen: settings of this replay, such as `allow_code`.

    Raises:
        Divergence: the replay differs from the recording.
        LogError: the recording cannot be used.
        CommandError, StartError: its scene cannot be opened here.
    """
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="simx-diff-")))
        opened = Opened(LogReader(recording), folder)
        settings = opened.settings(chosen)
        world = open_world(settings, stack, lambda world, _: opened.attach(world))
        replay(opened, world, settings.history, last_step=step)
        return Named(world.simulation.time, _values(world))


def departures(one: Named, other: Named) -> list[Departure]:
    """Return the quantities that differ, the largest difference first."""
    found: list[Departure] = []
    for quantity in sorted(one.values.keys() | other.values.keys()):
        mine, its = one.values.get(quantity), other.values.get(quantity)
        if mine != its:
            size = math.inf if mine is None or its is None else _farthest(mine, its)
            found.append(Departure(quantity, mine, its, size))
    return sorted(found, key=lambda each: -each.size)


def _farthest(one: tuple[float, ...], other: tuple[float, ...]) -> float:
    return max(abs(mine - its) for mine, its in zip(one, other, strict=True))


def _values(world: World) -> dict[Quantity, tuple[float, ...]]:
    sim = world.simulation
    sim.refresh()
    found: dict[Quantity, tuple[float, ...]] = {}
    for handle, item in sim.scene.objects.items():
        place, turn = get_pose(sim, handle)
        found[Quantity(item.name, "position", "m")] = tuple(map(float, place))
        found[Quantity(item.name, "quaternion w, x, y, z", "")] = tuple(map(float, turn))
        if item.kind == ObjectKind.JOINT and sim.joints.joint_type(handle) != JOINT_TYPES["ball"]:
            found[Quantity(item.name, "joint position", "m or rad")] = (sim.joints.position(handle),)
            found[Quantity(item.name, "joint velocity", "m/s or rad/s")] = (sim.joints.velocity(handle),)
    signals = world.signals
    for name, number in (*signals.integers.items(), *signals.floats.items()):
        found[Quantity(f"signal {name}", "value", "")] = (float(number),)
    return found
