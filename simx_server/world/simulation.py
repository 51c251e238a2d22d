"""The simulation: the only owner of MjModel and MjData, used by the physics thread alone.

A pass is V-REP's simulation step (50 ms unless said otherwise): a whole number of MuJoCo steps with the joint
controllers between them, then sensing. Simulated time is passes times the pass length, so it does not drift.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from simx_server.errors import CommandError, one_line
from simx_server.files.client_files import ClientFiles
from simx_server.files.scene_search import find_for_client
from simx_server.joints import Joints
from simx_server.joints.crowding import FEW, is_crowded
from simx_server.joints.watch import DIVERGED, StepFailed
from simx_server.limits import Limits
from simx_server.parts.signals import Signals
from simx_server.scene.formats.loader import empty_scene, load_scene
from simx_server.scene.formats.sources import Sources
from simx_server.scene.geometry.overlaps import log_overlaps
from simx_server.scene.objects import Scene
from simx_server.world import physics_warnings
from simx_server.world.hooks import Hooks, Listener, call
from simx_server.world.physics_callbacks import PhysicsCalls
from simx_server.world.saved_state import Snapshot
from simx_server.world.sleepers import Sleepers
from simx_server.world.velocities import Velocities

if TYPE_CHECKING:
    from simx_server.kinematics import IkGroups
    from simx_server.parts.custom_data import CustomData
    from simx_server.parts.drawing import DrawingObjects
    from simx_server.parts.graphs import Graphs
    from simx_server.parts.object_settings import ObjectSettings
    from simx_server.parts.parameters import Parameters
    from simx_server.parts.status_bar import StatusBar
    from simx_server.parts.tubes import Tubes
    from simx_server.parts.user_interface import UserInterface
    from simx_server.scene.collection import Collections
    from simx_server.scene.editing.twins import Twins
    from simx_server.scene.trial.trials import Trials
    from simx_server.scripting import Scripts
    from simx_server.scripting.script_parameters import ScriptParameters
    from simx_server.sensors.distance.meters import Meters
    from simx_server.sensors.force import ForceSensors
    from simx_server.sensors.instant import Instants
    from simx_server.sensors.proximity.proximity import ProximitySensors
    from simx_server.sensors.vision.render_thread import RenderThread
    from simx_server.sensors.vision.vision_sensors import VisionSensors
    from simx_server.world.applied_forces import AppliedForces

logger = logging.getLogger(__name__)

DEFAULT_TIME_STEP = 0.05
"""Seconds; V-REP's default pass."""


class SimulationState(Enum):
    STOPPED = "stopped"
    RUNNING = "running"
    PAUSED = "paused"


class Simulation(Hooks):
    """One world: scene, model, state, joints, signals, and who listens to its life."""

    limits = Limits()
    # Given by `parts.attach_parts` (a bare simulation works without them).
    applied_forces: AppliedForces
    custom_data: CustomData
    drawings: DrawingObjects
    graphs: Graphs
    object_settings: ObjectSettings
    parameters: Parameters
    scripts: Scripts
    script_parameters: ScriptParameters
    ik_groups: IkGroups
    collections: Collections
    instants: Instants
    meters: Meters
    proximity: ProximitySensors
    force: ForceSensors
    vision: VisionSensors
    rendering: RenderThread
    status_bar: StatusBar
    trials: Trials
    tubes: Tubes
    user_interface: UserInterface
    selection: list[int]
    workspace: Path
    stored: dict[Path, int]  # sizes of what clients have stored there

    def __init__(self) -> None:
        super().__init__()
        physics_warnings.listen()
        self.state = SimulationState.STOPPED
        self.client_files = ClientFiles()
        self.version = 0
        """Bumped whenever anything visible may have changed."""
        self.model_version = 0
        """Bumped whenever the model was replaced, its arrays were written or an object was renamed: what keeps a copy
        of it looks here."""
        self.pass_count = 0
        """Passes of this run; 0 when stopped."""
        self.scene_id = 0
        """Another number for every scene that was loaded, and for the empty one after closing."""
        self.dynamics_enabled = True
        """Boolean parameter 6: off, passes go by without physics. Another scene begins with them on."""
        self.signals = Signals(self)
        self.is_stopping = False
        """The run is to end: a script asked for it, or it is ending now."""
        self.physics_calls = PhysicsCalls()
        self.is_ending = False
        """The server has been told to end: no script is given long any more."""
        self._soon: list[Listener] = []
        self.find_file: Callable[[str, bool], Path] = self._find_file
        """The scene file that a text means, or (True) model file. Raises CommandError. A replay has its own."""
        self.sources = Sources.of()
        """Where what scenes and models name is searched, beyond their own folder."""
        self.more_folders: list[Path] = []
        """From which clients may load too."""
        self.scene_is_of_client = False
        """A client sent the scene's file, or one that it is made of."""
        self.own_scene: Path | None = None
        """The scene that the server was started with, which the operator trusts with what it names."""
        self.scene: Scene
        self.model: mujoco.MjModel
        self.data: mujoco.MjData
        self.joints: Joints
        self._velocities = Velocities(self)
        self.sleepers = Sleepers(self)
        self._snapshot: Snapshot | None = None
        self._stale = False
        self._is_rearranged = True
        self._wanted_timestep = 0.002
        self._time_step = DEFAULT_TIME_STEP
        self._adopt_empty()

    @property
    def time(self) -> float:
        """Simulated seconds of this run; 0 when stopped."""
        return self.pass_count * self._time_step

    @property
    def time_step(self) -> float:
        """Length of a pass in seconds."""
        return self._time_step

    @time_step.setter
    def time_step(self, seconds: float) -> None:
        """Only while stopped. The physics step becomes the nearest whole fraction of it."""
        if self.state != SimulationState.STOPPED:
            raise CommandError("the time step can be set only while the simulation is stopped; stop it first")
        if not 0 < seconds <= 10:
            raise CommandError(f"a time step is a number above 0, up to 10 s, not {seconds}")
        count = self._substeps(seconds, self._wanted_timestep)
        self._time_step = float(seconds)
        timestep = self._time_step / count
        if abs(timestep - self.model.opt.timestep) > 1e-12:
            logger.info(
                "physics step is %.6g s, a whole fraction of the pass of %.6g s", timestep, self._time_step
            )
        self.model.opt.timestep = timestep
        self.joints.forget_run()

    @property
    def substeps(self) -> int:
        """Physics steps per pass."""
        return max(1, round(self._time_step / self._wanted_timestep))

    @property
    def is_running(self) -> bool:
        """Started, paused or not."""
        return self.state != SimulationState.STOPPED

    @property
    def is_before_first_pass(self) -> bool:
        """Started, and nothing has been computed yet."""
        return self.is_running and self.pass_count == 0

    def load(self, path: str | Path) -> None:
        """Replace the scene by that of a file, which may name files wherever they are.

        Raises:
            CommandError: not stopped. SceneError: the file is bad; the present scene stays.
        """
        self._require_stopped("a scene can be loaded")
        is_of_client = self.client_files.made(Path(path))
        self.use(*load_scene(path, self.sources), is_of_client=is_of_client)

    def use(self, scene: Scene, model: mujoco.MjModel, *, is_of_client: bool = False) -> None:
        """As `load`, for a scene that is built already. `is_of_client`: from a file that a client sent."""
        self._require_stopped("a scene can be loaded")
        self.limits.check("objects", len(scene.objects), f"'{scene.name}' has {len(scene.objects)}")
        data = self._first_state(scene, model)
        call(self.on_closing)
        self._adopt(scene, model, data)
        logger.info("scene '%s' is loaded with %d objects", scene.name, len(scene.objects))
        log_overlaps(scene, model, self.data)
        self.scene_is_of_client = is_of_client
        call(self.on_load)
        call(self.on_model_changed)

    def close(self) -> None:
        """Leave an empty scene. Raises CommandError while the simulation is not stopped."""
        self._require_stopped("a scene can be closed")
        call(self.on_closing)
        self._adopt_empty()
        call(self.on_close)
        call(self.on_model_changed)

    def start(self) -> None:
        """Start from stopped (everything is saved), resume from paused."""
        if self.state == SimulationState.PAUSED:
            self.state = SimulationState.RUNNING
            call(self.on_resume)
            return
        if self.state == SimulationState.RUNNING:
            return
        call(self.on_starting)
        self._snapshot = Snapshot.take(self)
        self.joints.forget_run()
        self.pass_count = 0
        self.state = SimulationState.RUNNING
        self.refresh()
        self._velocities.restart()
        call(self.on_start)

    def pause(self) -> None:
        """Hold time still; nothing when not running."""
        if self.state == SimulationState.RUNNING:
            self.state = SimulationState.PAUSED
            call(self.on_pause)

    def stop(self) -> None:
        """End the run and bring back, bit for bit, what was saved at its start."""
        if self.state == SimulationState.STOPPED or self._snapshot is None:
            return
        self.is_stopping = True
        self._prepare_stop()
        self.state = SimulationState.STOPPED
        snapshot, self._snapshot = self._snapshot, None
        self.pass_count = 0
        replaced = snapshot.restore(self)
        self.model_edited()
        self.changed()
        self.refresh()
        self._velocities.restart()
        self.is_stopping = False
        call(self.on_stop)
        if replaced:
            call(self.on_model_changed)

    def _prepare_stop(self) -> None:
        """Whatever fails here, the run ends: else nothing could end it any more."""
        for listener in tuple(self.on_stopping):
            try:
                listener()
            except Exception:
                logger.exception(
                    "part of what a stop does first has failed; the simulation stops all the same"
                )

    def advance(self) -> None:
        """One pass; nothing unless running. When the physics diverges, the run is stopped."""
        if self.state != SimulationState.RUNNING:
            return
        call(self.on_pass_begin)
        if self.state != SimulationState.RUNNING:  # a listener may stop the run
            return
        try:
            self._make_physics()
        except (StepFailed, mujoco.FatalError) as error:
            self._give_up(error)
            return
        self._moved()
        self.refresh()
        self._velocities.remember()
        self.joints.measure()
        call(self.on_sensing)
        self.pass_count += 1
        call(self.on_pass_end)
        self.settle()

    def _make_physics(self) -> None:
        """The physics of a pass. Raises StepFailed, mujoco.FatalError."""
        if not self.dynamics_enabled:
            return
        if self._is_rearranged:  # by something else than physics, which keeps shapes apart
            self._is_rearranged = False
            if self.model.ngeom > FEW:
                self._check_room()
        with physics_warnings.once_a_kind():
            if self.sleepers.are_to_wake:
                self.refresh()
            with self.sleepers.watched_awake():
                self.joints.step(self.substeps)
        # MuJoCo looks at the state before each step, so what the last one made of it is not seen by it.
        if not (np.isfinite(self.data.qpos).all() and np.isfinite(self.data.qvel).all()):
            raise StepFailed(DIVERGED)

    def _check_room(self) -> None:
        """Raises StepFailed where so many shapes are near each other that one physics step might take very long."""
        self.refresh()
        if is_crowded(self.model, self.data, self.limits.near_pairs):
            reached = self.limits.reached("near_pairs", "move shapes apart, or remove some")
            raise StepFailed(f"too many shapes are in the same place; {reached}")

    def _give_up(self, error: Exception) -> None:
        """End a run whose physics cannot go on. The stop resets MuJoCo's data, which an error leaves half computed."""
        text = str(error) if isinstance(error, StepFailed) else f"MuJoCo cannot go on: {one_line(error)}"
        what, _, advice = text.partition("; ")
        problem = f"{what} at {self.time:.3f} s; the simulation is stopped"
        logger.error("%s", problem)
        self.stop()
        for tell in self.on_script_stopped:
            tell(f"{problem}; {advice}" if advice else problem)

    def idle(self) -> None:
        """To be called now and then while stopped or paused."""
        call(self.on_idle)
        self.settle()

    def soon(self, action: Listener) -> None:
        """Start, pause or stop when no pass and no script is under way any more: for scripts that ask for it."""
        self._soon.append(action)

    def stop_soon(self) -> None:
        """As `soon`, for `stop`; nothing when stopped."""
        if self.is_running and not self.is_stopping:
            self.is_stopping = True
            self.soon(self.stop)

    @property
    def is_settled(self) -> bool:
        """Whether nothing is to be done soon."""
        return not self._soon

    def settle(self) -> None:
        """Do what was to be done soon; to be called when neither a pass nor a command is under way."""
        while self._soon:
            action = self._soon.pop(0)
            try:
                action()
            except CommandError as problem:
                logger.error("what a script asked for cannot be done: %s", problem)

    def changed(self) -> None:
        """To be called after writing state or model: readers see a new version and fresh kinematics."""
        self.sleepers.wake()
        self._is_rearranged = True
        self._moved()

    def _moved(self) -> None:
        self.version += 1
        self._stale = True

    def model_edited(self) -> None:
        """To be called after writing arrays or options of the model that what keeps a copy of it must see."""
        self.model_version += 1

    def refresh(self) -> None:
        """Bring everything that follows from positions up to date, if stale. This is no step."""
        if not self._stale:
            return
        model, data = self.model, self.data
        with self.sleepers.woken_if_due():
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            mujoco.mj_camlight(model, data)
            if model.nflex:
                mujoco.mj_flex(model, data)
            if model.ntendon:
                mujoco.mj_tendon(model, data)
        self._stale = False

    def measured_velocity(self, handle: int) -> tuple[list[float], list[float], list[float]]:
        """(linear m/s, Euler-angle rates rad/s, angular velocity rad/s) in the world frame, see `velocities.py`."""
        return self._velocities.measure(self.scene.get(handle))

    def replace_model(self, scene: Scene, model: mujoco.MjModel, data: mujoco.MjData, twins: Twins) -> None:
        """Go on with an edited scene whose state was carried over (see `scene/editing.py`)."""
        self.scene, self.model, self.data = scene, model, data
        self.sleepers.keep_possible(model)
        self.joints.rebind()
        self.model_edited()
        self.changed()
        self.refresh()
        self._velocities.carry(twins)
        call(self.on_model_changed)

    def _first_state(self, scene: Scene, model: mujoco.MjModel) -> mujoco.MjData:
        """The state that a scene begins in. Raises CommandError when it cannot be simulated."""
        self._substeps(scene.annotations.time_step or DEFAULT_TIME_STEP, model.opt.timestep)
        self.sleepers.keep_possible(model)
        try:
            data = mujoco.MjData(model)
            with physics_warnings.once_a_kind():
                mujoco.mj_forward(model, data)
        except (mujoco.FatalError, MemoryError) as error:
            raise CommandError(f"'{scene.name}' cannot be simulated: {one_line(error)}") from error
        return data

    def _substeps(self, time_step: float, timestep: float) -> int:
        """Physics steps in a simulation step; raises LimitReached when they are too many."""
        count = max(1, round(min(time_step / timestep, 1e15)))
        self.limits.check(
            "substeps",
            count,
            f"a simulation step of {time_step:g} s with physics steps of {timestep:g} s has {count}; choose a shorter "
            "simulation step, or a scene with a longer timestep of <option>",
        )
        return count

    def _adopt_empty(self) -> None:
        scene, model = empty_scene()
        self._adopt(scene, model, self._first_state(scene, model))

    def _adopt(self, scene: Scene, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        self.scene, self.model, self.data = scene, model, data
        self.scene_id += 1
        self.dynamics_enabled = True
        self.scene_is_of_client = False
        self._wanted_timestep = float(model.opt.timestep)
        self._stale = True
        self.joints = Joints(self)
        self.pass_count = 0
        self.time_step = scene.annotations.time_step or DEFAULT_TIME_STEP
        self.refresh()
        self._velocities.restart()
        self.model_edited()
        self.changed()

    def _find_file(self, text: str, is_model: bool) -> Path:
        return find_for_client(text, self.workspace, self.scene.path, self.more_folders, model=is_model)

    def _require_stopped(self, what: str) -> None:
        if self.state != SimulationState.STOPPED:
            raise CommandError(f"{what} only while the simulation is stopped; stop it first")
