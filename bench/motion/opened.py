"""A scene or model that is opened without a server and runs."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Generator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.app.server import open_world
from simx_server.settings.settings import Settings
from simx_server.world.world import World

Array = NDArray[np.float64]


@dataclass
class Running:
    """A world whose simulation runs, and how long its steps have taken."""

    world: World
    seconds: float = 0.0
    """Processor time of the simulation steps."""
    steps: int = 0
    errors: int = 0

    @property
    def model(self) -> mujoco.MjModel:
        return self.world.simulation.model

    @property
    def data(self) -> mujoco.MjData:
        return self.world.simulation.data

    def handle(self, name: str) -> int:
        """Return the handle of an object."""
        return self.world.simulation.scene.resolve(name)

    def step(self, count: int, before: Callable[[], object] | None = None) -> None:
        """Make simulation steps; `before` is called before each."""
        for _ in range(count):
            if before is not None:
                before()
            began = time.process_time()
            self.world.step()
            self.seconds += time.process_time() - began
            self.steps += 1

    @property
    def share(self) -> float:
        """Return the processor time of the steps as a part of the simulated time."""
        return self.seconds / (self.steps * self.world.simulation.time_step) if self.steps else 0.0


_ON_THE_FLOOR = """
<mujoco model="{model}">
  <include file="parts/settings.xml"/>
  <include file="parts/default_scene.xml"/>
  <include file="models/{model}.xml"/>
</mujoco>"""


@contextmanager
def running(scene: str, model: str | None = None) -> Generator[Running]:
    """Open a scene, model or file of V-REP, and start its simulation.

    Args:
        scene: a shipped scene or a file; not used with `model`.
        model: a shipped model, which stands alone on the default floor.
    """
    with ExitStack() as stack:
        if model is not None:
            folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
            file = folder / f"{model}_alone.xml"
            file.write_text(_ON_THE_FLOOR.format(model=model))
            scene = str(file)
        world = open_world(Settings(scene=scene), stack)
        world.simulation.start()
        stack.callback(world.simulation.stop)
        yield Running(world)
