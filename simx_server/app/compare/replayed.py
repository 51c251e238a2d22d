"""The states of a recording of this project, by replaying it: as it was, or with a changed scene."""

from __future__ import annotations

import logging
import tempfile
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

import mujoco

from simx_server.app.server import open_world
from simx_server.errors import CommandError
from simx_server.joints.joints import JOINT_TYPES
from simx_server.recording.log_file import LogReader
from simx_server.recording.opened import Opened
from simx_server.recording.replaying import replay
from simx_server.scene.naming.paths import resolve
from simx_server.scene.objects import ObjectKind
from simx_server.scene.poses.frames import get_pose
from simx_server.settings.settings import Settings
from simx_server.world.world import World

from .quantities import FORCE, JOINT, ORIENTATION, POSITION, VELOCITY, WIDTHS
from .trajectories import Collector, Quantity, Run

Change = Callable[[mujoco.MjSpec], None]


def replayed(
    recording: Path,
    quantities: Collection[Quantity] | None = None,
    *,
    change: Change | None = None,
    chosen: Settings | None = None,
) -> Run:
    """Replay a recording, and return its states after each step.

    Args:
        recording: a file of ``simx-server --record``.
        quantities: those to return, whose owners are names or paths of objects; None: all of all objects.
        change: changes the scene before it is compiled; the states are then not compared with the recorded ones.
        chosen: settings of this replay, such as `allow_code`.

    Raises:
        Divergence: the replay differs from the recording.
        CommandError, StartError: it cannot be replayed here.
    """
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="simx-compare-")))
        opened = Opened(LogReader(recording), folder)
        settings = opened.settings(chosen or Settings())

        def attach(world: World, _: Path) -> None:
            opened.attach(world)
            if change is not None:
                files = world.simulation.files
                files.sources = replace(files.sources, change=change)

        world = open_world(settings, stack, attach)
        sampler = _Sampler(world, quantities)
        replay(opened, world, settings.history, after_step=sampler.sample, compares=change is None)
        return sampler.collector.run()


class _Sampler:
    """Samples a world after each simulation step."""

    def __init__(self, world: World, quantities: Collection[Quantity] | None) -> None:
        self._world = world
        self._wanted = quantities
        self.collector = Collector()

    def sample(self) -> None:
        time = self.collector.at(self._world.simulation.time)
        if time is not None:
            self._world.simulation.refresh()
            self.collector.add(time, list(self._values()))

    def _values(self) -> Iterator[tuple[Quantity, Sequence[float]]]:
        if self._wanted is None:
            for handle, item in self._world.simulation.scene.objects.items():
                for name in WIDTHS:
                    yield from self._value(Quantity(item.name, name), handle)
            return
        for quantity in self._wanted:
            try:
                handle = resolve(self._world.simulation.scene, quantity.owner)
            except CommandError:
                continue  # an object that is not there, at least now
            yield from self._value(quantity, handle)

    def _value(self, quantity: Quantity, handle: int) -> Iterator[tuple[Quantity, Sequence[float]]]:
        sim = self._world.simulation
        if quantity.name in (POSITION, ORIENTATION):
            yield quantity, get_pose(sim, handle)[quantity.name == ORIENTATION]
        elif (
            sim.scene.get(handle).kind == ObjectKind.JOINT
            and sim.joints.joint_type(handle) != JOINT_TYPES["ball"]
        ):
            read = {JOINT: sim.joints.position, VELOCITY: sim.joints.velocity, FORCE: sim.joints.force}
            if quantity.name in read:
                yield quantity, [read[quantity.name](handle)]


def silenced() -> None:
    """Print errors only: a replay warns of versions each time."""
    logging.getLogger("simx_server").setLevel(logging.ERROR)
