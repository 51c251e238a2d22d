"""The simulation as a whole: time, state, wall clock, random numbers."""

from __future__ import annotations

import random
import shlex
import time

from simx_client.protocol import constants as c
from simx_client.protocol.files import is_vrep_name
from simx_server.errors import Unsupported
from simx_server.handlers import script_files
from simx_server.handlers.simulation import simulation_state

from .base import ApiPart

_MILLISECONDS = 1 << 31
"""The clock in milliseconds restarts at this number, so that it stays a 32-bit integer."""


class SimulationFunctions(ApiPart):
    """Functions for the simulation. Times are in seconds."""

    _random: random.Random | None = None
    """The script's random numbers; created on first use."""

    def getSimulationTime(self) -> float:
        """Return the time of this run; 0 when stopped."""
        return self._sim.time

    def getSimulationTimeStep(self) -> float:
        """Return the duration of a simulation step."""
        return self._sim.time_step

    def setSimulationTimeStep(self, seconds: float) -> None:
        """Set the duration of a simulation step, only while stopped."""
        self._sim.time_step = seconds

    def getSimulationState(self) -> int:
        """Return sim.simulation_stopped, _paused, _advancing_firstafterstop, _advancing_running or
        _advancing_abouttostop.
        """
        return simulation_state(self._world)

    def getSimulationStopping(self) -> bool:
        """Return whether the run is ending, or a script has requested its end."""
        return self._sim.is_stopping

    def startSimulation(self) -> int:
        """Start or resume the run as soon as the current simulation step and all scripts are done; return 1."""
        self._sim.soon(self._sim.start)
        return 1

    def pauseSimulation(self) -> int:
        """Pause the run as soon as the current simulation step and all scripts are done; return 1."""
        self._sim.soon(self._sim.pause)
        return 1

    def stopSimulation(self, _wait: bool = False) -> int:
        """Stop the run at the end of this simulation step, or as soon as all scripts are done; return 1.

        Partly: it never waits for the stop, which ends the script.
        """
        self._sim.stop_soon()
        return 1

    def loadScene(self, file: bytes) -> int:
        """Replace the scene, which ends the script; only while stopped, as soon as all scripts are done; return 1.

        The argument is a file, `.ttt`, MJCF or URDF, or the content of a `.ttt` file; an empty one
        means V-REP's default scene.
        """
        script_files.load_scene_of_server(self._world, file)
        return 1

    def closeScene(self) -> int:
        """Replace the scene with V-REP's default one; only while stopped, as soon as all scripts are done; return 1."""
        if self._sim.is_running:
            raise Unsupported("a scene can be closed only while the simulation is stopped; stop it first")
        self._sim.soon(self._sim.close)
        return 1

    def saveScene(self, _file: str = "") -> int:
        """Return -1, V-REP's result when a file cannot be written. Not here: people write scenes as files."""
        raise Unsupported(f"scenes are not saved here: {self._how_to_edit('scene')}")

    def saveModel(self, _base: int, _file: str | None = None) -> int:
        """Return -1, V-REP's result when a file cannot be written. Not here: people write models as files."""
        raise Unsupported(f"models are not saved here: {self._how_to_edit('model')}")

    def _how_to_edit(self, what: str) -> str:
        path = self._sim.scene.path
        if path is not None and is_vrep_name(path.name):
            command = f"simx-server {shlex.quote(path.name)} --convert FOLDER"
            return f"write the scene as MJCF with `{command}`, and what is to stay into that file"
        return f"write what is to stay into the {what}'s MJCF file"

    def announceSceneContentChange(self) -> int:
        """Return 0. Partly: nothing can be undone, so this has no effect."""
        return 0

    def quitSimulator(self) -> None:
        """Stop the server, only while the simulation is stopped."""
        self._world.parameters.booleans.set(c.sim_boolparam_exit_request, True)

    def getRealTimeSimulation(self) -> int:
        """Return 1 when simulated time follows the wall clock, else 0."""
        return int(self._world.parameters.booleans.get(c.sim_boolparam_realtime_simulation))

    def getSystemTime(self) -> float:
        """Return seconds of the wall clock since an arbitrary moment."""
        return time.monotonic()

    def getSystemTimeInMs(self, since: int = -1) -> int:
        """Return milliseconds of the wall clock; with an earlier result, those since then. -1, -2: the clock itself."""
        now = int(time.monotonic() * 1000) % _MILLISECONDS
        return now if since < 0 else (now - since) % _MILLISECONDS

    getSystemTimeInMilliseconds = getSystemTimeInMs

    def getRandom(self, seed: int | None = None) -> float:
        """Return a random number from 0 to below 1. Each script has its own sequence, the same in every run; a seed
        starts another one.
        """
        if self._random is None or seed is not None:
            self._random = random.Random(self._owner if seed is None else seed)
        return self._random.random()

    def isRealTimeSimulationStepNeeded(self) -> int:
        """Return 1: a script is called only when its simulation step is due."""
        return 1

    def getSimulationPassesPerRenderingPass(self) -> int:
        """Return 1: images are rendered on request."""
        return 1

    def adjustRealTimeTimer(self, _instance: int, _seconds: float) -> None:
        """Do nothing. Partly: this has no effect, since the server controls the pace automatically."""
