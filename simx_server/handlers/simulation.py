"""Start, pause, stop, scenes, and the status bar."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .registry import handler

if TYPE_CHECKING:
    from simx_server.world.world import World


@handler("simxStartSimulation")
def start_simulation(world: World) -> None:
    """Also resumes; nothing when it runs."""
    sim = world.simulation
    sim.start()


@handler("simxPauseSimulation")
def pause_simulation(world: World) -> None:
    sim = world.simulation
    sim.pause()


@handler("simxStopSimulation")
def stop_simulation(world: World) -> None:
    """Ends stepped mode of all clients too; nothing when stopped already, then stepped mode stays.

    Differs: V-REP needs a few passes to stop; here it has stopped when the answer comes.
    """
    sim = world.simulation
    sim.stop()


@handler("simxCloseScene")
def close_scene(world: World) -> None:
    """Raises CommandError while not stopped.

    Differs: it leaves an empty scene, as one is loaded at a time; V-REP showed another open one, or its default scene.
    """
    sim = world.simulation
    sim.close()


@handler("simxAddStatusbarMessage")
def add_statusbar_message(world: World, message: str) -> None:
    world.status_bar.add(message)
