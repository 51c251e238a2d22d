"""Start, pause, stop, scenes, and the status bar."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .registry import handler

if TYPE_CHECKING:
    from simx_server.world.world import World


@handler("simxStartSimulation")
def start_simulation(world: World) -> None:
    """Keep a running simulation as it is."""
    world.simulation.start()


@handler("simxPauseSimulation")
def pause_simulation(world: World) -> None:
    world.simulation.pause()


@handler("simxStopSimulation")
def stop_simulation(world: World) -> None:
    """End stepped mode of all clients; a simulation that is stopped already keeps it.

    Differs: V-REP needs a few simulation steps to stop; here it has stopped when the call returns.
    """
    world.simulation.stop()


@handler("simxCloseScene")
def close_scene(world: World) -> None:
    """Raises CommandError while not stopped.

    Differs: the result is an empty scene, since one is loaded at a time; V-REP showed another open one, or its default
    scene.
    """
    world.simulation.close()


@handler("simxAddStatusbarMessage")
def add_statusbar_message(world: World, message: str) -> None:
    world.status_bar.add(message)
