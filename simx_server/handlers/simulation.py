"""Start, pause, stop, scenes, and the status bar."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import CommandError
from ..library import find_scene, shipped_scenes
from .registry import handler

if TYPE_CHECKING:
    from ..simulation import Simulation

_FILE_IS_ON_CLIENT = 1
"""Option bit 0 of simxLoadScene."""


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


@handler("simxLoadScene")
def load_scene(sim: Simulation, path: str, options: int) -> None:
    """Load a file of the workspace, one beside the present scene, or a shipped scene.

    Raises:
        CommandError: not stopped, no such file, a file elsewhere, or a file on the client's side.
        SceneError: the file is no good; the old scene stays.
    """
    if sim.is_running:
        raise CommandError("a scene can be loaded only while the simulation is stopped; stop it first")
    if options & _FILE_IS_ON_CLIENT:
        raise CommandError(
            "loading a scene file from the client's side (options bit 0) comes in a later version; "
            "put the file into the server's workspace and call with options 0"
        )
    found = find_scene(path, sim.workspace).resolve()
    if not any(found.is_relative_to(folder) for folder in _open_folders(sim)):
        raise CommandError(
            f"{path!r} lies outside the server's workspace {sim.workspace}; "
            "move it there, or start the server with --workspace"
        )
    sim.load(found)


@handler("simxCloseScene")
def close_scene(sim: Simulation) -> None:
    """Leaves an empty scene. Raises CommandError while not stopped."""
    sim.close()


@handler("simxAddStatusbarMessage")
def add_statusbar_message(sim: Simulation, message: str) -> None:
    sim.status_bar.add(message)


def _open_folders(sim: Simulation) -> list[Path]:
    folders = [sim.workspace.resolve(), shipped_scenes().resolve()]
    if sim.scene.path is not None:
        folders.append(sim.scene.path.resolve().parent)
    return folders
