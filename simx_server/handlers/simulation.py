"""Start, pause, stop, scenes, and the status bar."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_client.protocol import constants as c
from simx_server.service.calls.registry import handler
from simx_server.simulation.simulation import SimulationState

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

    V-REP's default scene is there then: floor, lights and view cameras.

    Differs: one scene is loaded at a time; V-REP showed another one that was open.
    """
    world.simulation.close()


@handler("simxAddStatusbarMessage")
def add_statusbar_message(world: World, message: str) -> None:
    world.status_bar.add(message)


def simulation_state(world: World) -> int:
    """Return `sim.simulation_stopped`, `_paused`, `_advancing_firstafterstop`, `_advancing_running` or
    `_advancing_abouttostop`, for scripts; the remote API has no such command.
    """
    simulation = world.simulation
    match simulation.state:
        case SimulationState.STOPPED:
            return c.sim_simulation_stopped
        case SimulationState.PAUSED:
            return c.sim_simulation_paused
        case SimulationState.RUNNING if simulation.is_stopping:
            return c.sim_simulation_advancing_abouttostop
        case SimulationState.RUNNING if simulation.step_count == 0:
            return c.sim_simulation_advancing_firstafterstop
        case _:
            return c.sim_simulation_advancing_running
