"""The simulation and its scene."""

from __future__ import annotations

from .command import Command, Effect
from .meanings import LOAD_OPTIONS, SCENE_FILE

SIMULATION = (
    Command(
        name="simxStartSimulation",
        doc="Start the simulation, or resume it when paused.",
        effect=Effect.CONTROLS,
        legacy_id=0x1007,
        twin="sim.startSimulation",
    ),
    Command(
        name="simxPauseSimulation",
        doc="Pause the simulation.",
        effect=Effect.CONTROLS,
        legacy_id=0x1007,
        twin="sim.pauseSimulation",
    ),
    Command(
        name="simxStopSimulation",
        doc="Stop the simulation and restore the state before its start; stepped mode ends.",
        effect=Effect.CONTROLS,
        legacy_id=0x1007,
        twin="sim.stopSimulation",
    ),
    Command(
        name="simxLoadScene",
        takes={"scenePathAndName": SCENE_FILE, "options": LOAD_OPTIONS},
        doc="Load a scene while stopped; option bit 0 takes the file from the client's side.",
        effect=Effect.EDITS,
        key=("scenePathAndName",),
        loads_file=True,
        adds_objects=True,
        legacy_id=0x3002,
        twin="sim.loadScene",
    ),
    Command(
        name="simxCloseScene",
        doc="Close the scene while stopped; the default scene is open then.",
        effect=Effect.EDITS,
        legacy_id=0x0005,
        twin="sim.closeScene",
    ),
)
