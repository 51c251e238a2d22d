"""The simulation as a whole: time, state, wall clock, random numbers."""

from __future__ import annotations

import random

from simx_client.protocol import constants as c
from simx_server.editing.saving.packing import pack_model
from simx_server.errors import CommandError, Unsupported
from simx_server.handlers.quantities.simulator import BOOLEANS
from simx_server.handlers.scene_files import saving, script_files
from simx_server.handlers.simulation import simulation_state
from simx_server.scripting.interpreter import Waiting

from .base import ApiPart
from .effects import reads, takes, writes_files

_MILLISECONDS = 1 << 31
"""The clock in milliseconds restarts at this number, so that it stays a 32-bit integer."""


class SimulationFunctions(ApiPart, effect="changes"):
    """Functions for the simulation. Times are in seconds."""

    _random: random.Random | None = None
    """The script's random numbers; created on first use."""

    @reads
    def getSimulationTime(self) -> float:
        """Return the time of this run; 0 when stopped."""
        return self._sim.time

    @reads
    def getSimulationTimeStep(self) -> float:
        """Return the duration of a simulation step."""
        return self._sim.time_step

    def setSimulationTimeStep(self, seconds: float) -> None:
        """Set the duration of a simulation step, only while stopped."""
        self._sim.time_step = seconds

    @reads
    def getSimulationState(self) -> int:
        """Return sim.simulation_stopped, _paused, _advancing_firstafterstop, _advancing_running or
        _advancing_abouttostop.
        """
        return simulation_state(self._world)

    @reads
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

    def stopSimulation(self, wait: bool = False) -> int | Waiting:
        """Stop the run at the end of this simulation step, or as soon as all scripts are done; return 1.

        `wait`: return after the stop; for a thread of a script that outlives the run.
        """
        self._sim.stop_soon()
        if not wait:
            return 1
        if self._script.is_of_run:
            raise CommandError(
                f"a {self._script.kind.text} ends with the run, so it cannot wait for the stop; leave out the argument"
            )
        return self._until_stopped()

    def _until_stopped(self) -> Waiting:
        while self._sim.is_running:
            yield
        return (1,)

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

    @writes_files
    def saveScene(self, file: str = "") -> int | bytes:
        """Save the scene as it is now, also while it runs; return 1, or without a file the content of one.

        The file lies in the workspace; of a path that leads elsewhere only the last part counts. `.ttt` means a file
        of V-REP, for a scene that was read from one; `.xml` means MJCF with a folder of the files that it names; any
        other ending, and no file, mean an archive of them, which is MuJoCo's `.mjz` too. sim.loadScene reads all of
        them.
        """
        if not file:
            return saving.scene_content(self._world).data
        saving.save_scene(self._world, file)
        return 1

    @writes_files
    def saveModel(self, base: int, file: str | None = None) -> int | bytes:
        """Save a model, as sim.saveScene does the scene; return 1, or without a file the content of one."""
        if not file:
            return pack_model(self._world, self._self(base)).data
        saving.save_model(self._world, self._self(base), file)
        return 1

    def announceSceneContentChange(self) -> int:
        """Return 0. Partly: nothing can be undone, so this has no effect."""
        return 0

    def quitSimulator(self) -> None:
        """Stop the server, only while the simulation is stopped."""
        BOOLEANS.set(self._world, c.sim_boolparam_exit_request, True)

    @reads
    def getRealTimeSimulation(self) -> int:
        """Return 1 when simulated time follows the wall clock, else 0."""
        return int(BOOLEANS.get(self._world, c.sim_boolparam_realtime_simulation))

    getIsRealTimeSimulation = getRealTimeSimulation

    @reads
    def getSystemTime(self) -> float:
        """Return seconds of the wall clock since an arbitrary moment."""
        return self._wall_clock()

    @reads
    def getSystemTimeInMs(self, since: int = -1) -> int:
        """Return milliseconds of the wall clock; with an earlier result, those since then. -1, -2: the clock itself."""
        now = int(self._wall_clock() * 1000) % _MILLISECONDS
        return now if since < 0 else (now - since) % _MILLISECONDS

    getSystemTimeInMilliseconds = getSystemTimeInMs

    @takes
    def getRandom(self, seed: int | None = None) -> float:
        """Return a random number from 0 to below 1. Each script has its own sequence, the same in every run; a seed
        starts another one.
        """
        if self._random is None or seed is not None:
            self._random = random.Random(self._owner if seed is None else seed)
        return self._random.random()

    @reads
    def isRealTimeSimulationStepNeeded(self) -> int:
        """Return 1: a script is called only when its simulation step is due."""
        return 1

    @reads
    def getSimulationPassesPerRenderingPass(self) -> int:
        """Return 1: images are rendered on request."""
        return 1

    def adjustRealTimeTimer(self, _instance: int, _seconds: float) -> None:
        """Do nothing. Partly: this has no effect, since the server controls the pace automatically."""
