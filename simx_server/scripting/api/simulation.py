"""The simulation as a whole: its time and state, the clock on the wall, random numbers."""

from __future__ import annotations

import random
import time
from typing import NoReturn

from simx_client.protocol import constants as c
from simx_server.world.simulation import SimulationState

from ...errors import CommandError
from ...handlers import files
from .base import ApiPart

_MILLISECONDS = 1 << 31
"""The clock in milliseconds begins again at this number, so that it stays an integer of 32 bits."""


class SimulationFunctions(ApiPart):
    """Seconds."""

    _random: random.Random | None = None
    """The script's own numbers; made when the first is asked for."""

    def getSimulationTime(self) -> float:
        """Of this run; 0 when stopped."""
        return self._sim.time

    def getSimulationTimeStep(self) -> float:
        """Of one pass."""
        return self._sim.time_step

    def setSimulationTimeStep(self, seconds: float) -> None:
        """Only while stopped."""
        self._sim.time_step = seconds

    def getSimulationState(self) -> int:
        """sim.simulation_stopped, _paused, _advancing_firstafterstop, _advancing_running, _advancing_abouttostop."""
        match self._sim.state:
            case SimulationState.STOPPED:
                return c.sim_simulation_stopped
            case SimulationState.PAUSED:
                return c.sim_simulation_paused
            case SimulationState.RUNNING if self._sim.is_stopping:
                return c.sim_simulation_advancing_abouttostop
            case SimulationState.RUNNING if self._sim.pass_count == 0:
                return c.sim_simulation_advancing_firstafterstop
            case _:
                return c.sim_simulation_advancing_running

    def getSimulationStopping(self) -> bool:
        """Whether the run is to end: a script asked for it, or it is ending."""
        return self._sim.is_stopping

    def startSimulation(self) -> int:
        """Also resumes. As soon as no pass and no script is under way; 1."""
        self._sim.soon(self._sim.start)
        return 1

    def pauseSimulation(self) -> int:
        """As soon as no pass and no script is under way; 1."""
        self._sim.soon(self._sim.pause)
        return 1

    def stopSimulation(self, _wait: bool = False) -> int:
        """At the end of this pass, or as soon as no script is under way; 1.

        Partly: it never waits for the stop, which ends the script.
        """
        self._sim.stop_soon()
        return 1

    def loadScene(self, file: str) -> int:
        """Instead of the present one, which ends the script; only while stopped, as soon as no script is under way; 1.

        Partly: files are MJCF or URDF, and for a `.ttt` file the one that stands for it.
        """
        files.load_scene_of_server(self._world, file)
        return 1

    def closeScene(self) -> int:
        """Leaves an empty one; only while stopped, as soon as no script is under way; 1."""
        if self._sim.is_running:
            raise CommandError("a scene can be closed only while the simulation is stopped; stop it first")
        self._sim.soon(self._sim.close)
        return 1

    def saveScene(self, _file: str) -> NoReturn:
        """Not here: scenes are files that people write."""
        raise CommandError("scenes are not saved here: write what is to stay into the scene's MJCF file")

    def saveModel(self, _base: int, _file: str | None = None) -> NoReturn:
        """Not here: models are files that people write."""
        raise CommandError("models are not saved here: write what is to stay into the model's MJCF file")

    def announceSceneContentChange(self) -> int:
        """Partly: nothing here can be undone, so this does nothing; 0."""
        return 0

    def quitSimulator(self) -> None:
        """Ends the server, only while stopped."""
        self._world.parameters.booleans.set(c.sim_boolparam_exit_request, True)

    def getRealTimeSimulation(self) -> int:
        """1 when simulated time follows the clock on the wall, else 0."""
        return int(self._world.parameters.booleans.get(c.sim_boolparam_realtime_simulation))

    def getSystemTime(self) -> float:
        """Seconds of the clock on the wall, from some moment on."""
        return time.monotonic()

    def getSystemTimeInMs(self, since: int = -1) -> int:
        """Milliseconds of the clock on the wall; with an earlier result, those since then. -1, -2: the clock itself."""
        now = int(time.monotonic() * 1000) % _MILLISECONDS
        return now if since < 0 else (now - since) % _MILLISECONDS

    def getRandom(self, seed: int | None = None) -> float:
        """Return a number from 0 to below 1. Each script has its own sequence, the same in every run or for a seed."""
        if self._random is None or seed is not None:
            self._random = random.Random(self._owner if seed is None else seed)
        return self._random.random()

    def isRealTimeSimulationStepNeeded(self) -> int:
        """1: a script runs when its pass is due, never before."""
        return 1

    def getSimulationPassesPerRenderingPass(self) -> int:
        """1: pictures are made when somebody asks for them."""
        return 1

    def adjustRealTimeTimer(self, _instance: int, _seconds: float) -> None:
        """Partly: has no effect, as the server paces the simulation steps."""
