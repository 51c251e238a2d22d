"""Start, pause, stop, scenes, and the status bar."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .registry import handler

if TYPE_CHECKING:
    from ..simulation import Simulation


@handler("simxStartSimulation")
def start_simulation(sim: Simulation) -> None:
    """Also resumes; nothing when it runs."""
    sim.start()


@handler("simxPauseSimulation")
def pause_simulation(sim: Simulation) -> None:
    sim.pause()


@handler("simxStopSimulation")
def stop_simulation(sim: Simulation) -> None:
    """V-REP needs a few passes to stop; here it has stopped when the answer comes."""
    sim.parameters.stop_requests += 1
    sim.stop()


@handler("simxCloseScene")
def close_scene(sim: Simulation) -> None:
    """Leaves an empty scene. Raises CommandError while not stopped."""
    sim.close()


@handler("simxAddStatusbarMessage")
def add_statusbar_message(sim: Simulation, message: str) -> None:
    sim.status_bar.add(message)
