"""Run the scene for a while before something is written of it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from simx_server.simulation.simulation import SimulationState

from .packages import OutputError

if TYPE_CHECKING:
    from simx_server.world.world import World


def run_for(world: World, duration: float, what: str) -> None:
    """Start the simulation and make simulation steps, as fast as possible.

    Args:
        duration: simulated seconds.
        what: the result in a word, for messages.

    Raises:
        OutputError: the run ended before.
    """
    sim = world.simulation
    sim.start()
    steps = max(1, math.ceil(duration / sim.time_step - 1e-9))
    for _ in range(steps):
        world.step()
        if sim.state is not SimulationState.RUNNING:
            raise OutputError(
                f"the run ended or was paused before its {duration:g} s were over, so there is no {what} of its end"
            )
