"""Start, pause, stop, scenes, and the status bar."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .registry import handler

if TYPE_CHECKING:
    from simx_server.world.simulation import Simulation


@handler("simxStartSimulation")
def start_simulation(sim: Simulation) -> None:
    """Also resumes; nothing when it runs."""
    sim.start()


@handler("simxPauseSimulation")
def pause_simulation(sim: Simulation) -> None:
    sim.pause()


@handler("simxStopSimulation")
def stop_simulation(sim: Simulation) -> None:
    """Ends stepped mode of all clients too; nothing when stopped already, then stepped mode stays.

    Differs: V-REP needs a few passes to stop; here it has stopped when the answer comes.
    """
    sim.stop()


@handler("simxCloseScene")
def close_scene(sim: Simulation) -> None:
    """Raises CommandError while not stopped.

    Differs: it leaves an empty scene, as one is loaded at a time; V-REP showed another open one, or its default scene.
    """
    sim.close()


@handler("simxAddStatusbarMessage")
def add_statusbar_message(sim: Simulation, message: str) -> None:
    sim.status_bar.add(message)
