"""The simulation: the only owner of MjModel and MjData, used by the physics thread alone.

A simulation step is V-REP's (50 ms unless set otherwise): a whole number of MuJoCo's physics steps with the joint
controllers between them, then sensing (see `world.World.step`). Simulated time is the number of steps times their
length, so it does not drift.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING

import mujoco

from simx_server.errors import CommandError, one_line
from simx_server.joints import Joints
from simx_server.joints.guards.crowding import FEW
from simx_server.joints.guards.foresight import Foresight
from simx_server.joints.stepping import kinematics
from simx_server.limits import Limits
from simx_server.scene import physics_warnings, properties
from simx_server.scene.editing.model_state import editable_arrays
from simx_server.scene.editing.waiting.compiling import compile_waiting
from simx_server.scene.finding.scene_files import SceneFiles
from simx_server.scene.formats.jacobian import solver_problem
from simx_server.scene.formats.loader import default_scene, empty_scene, load_scene
from simx_server.scene.geometry.overlaps import log_overlaps
from simx_server.scene.objects import Scene
from simx_server.scene.poses.first_turns import set_turns
from simx_server.scene.poses.pose_copies import PresentPoses

from .compiled import Compiled
from .interruptions import Interruptions
from .parts import Parts
from .physics_callbacks import PhysicsCalls
from .saved_state import Snapshot
from .sleepers import Sleepers

if TYPE_CHECKING:
    from simx_server.scene.editing.twins import Twins
    from simx_server.scene.editing.waiting.waiting import Waiting

logger = logging.getLogger(__name__)


DEFAULT_TIME_STEP = 0.05
"""V-REP's default simulation step in seconds."""


class SimulationState(Enum):
    STOPPED = "stopped"
    RUNNING = "running"
    PAUSED = "paused"


class Simulation:
    """Model, data, joints, time, start and stop; the parts are told of its events."""

    model = Compiled[mujoco.MjModel]()
    data = Compiled[mujoco.MjData]()

    def __init__(self, limits: Limits | None = None, files: SceneFiles | None = None) -> None:
        """Make a simulation of the empty scene.

        Args:
            limits: how much clients may make the server hold.
            files: where scenes are searched.
        """
        physics_warnings.listen()
        self.limits = limits or Limits()
        self.files = files or SceneFiles()
        self.interruptions = Interruptions()
        self.physics_calls = PhysicsCalls()
        self.state = SimulationState.STOPPED
        self.version = 0
        """Increases whenever anything visible may have changed."""
        self.model_version = 0
        """Increases when the model was replaced, its arrays were written or an object was renamed.

        Copies of the model are stale then.
        """
        self.step_count = 0
        """Simulation steps of this run; 0 when stopped."""
        self.scene_id = 0
        """A different number for every loaded scene, and for the default one after closing."""
        self.dynamics_enabled = True
        """Boolean parameter 6: if false, simulation steps run without physics. A new scene starts with true."""
        self.is_stopping = False
        """The run is about to end: a script requested it, or it is ending now."""
        self.failure = ""
        """Why the run that is being stopped cannot continue; empty for a stop that was asked for."""
        self.is_ending = False
        """The server has been told to end: from now on scripts get little time."""
        self.scene_is_of_client = False
        """A client sent the scene's file, or a file that it includes."""
        self._is_going_back = False
        self.parts = Parts()
        self._soon: list[Callable[[], object]] = []
        self.foresight = Foresight(self)
        self.sleepers = Sleepers(self)
        self._snapshot: Snapshot | None = None
        self._arrays: tuple[mujoco.MjModel, Sequence[memoryview]] | None = None
        """A model and its `editable_arrays`."""
        self.waiting: Waiting | None = None
        """Edits that the model has not got yet."""
        self._stale = False
        self.is_rearranged = True
        """State or model was written since the last physics."""
        self._wanted_timestep = 0.002
        self._time_step = DEFAULT_TIME_STEP
        self.substeps = 1
        """Number of physics steps per simulation step."""
        scene, model = empty_scene()
        self._adopt(scene, model, self._first_state(scene, model))
        self.poses = PresentPoses(self)

    @property
    def time(self) -> float:
        """Return the simulated seconds of this run; 0 when stopped."""
        return self.step_count * self._time_step

    @property
    def time_step(self) -> float:
        """Return the length of a simulation step in seconds."""
        return self._time_step

    @time_step.setter
    def time_step(self, seconds: float) -> None:
        """Set the length of a simulation step; only while stopped.

        The physics step becomes the nearest whole fraction of it.
        """
        if self.state != SimulationState.STOPPED:
            raise CommandError("the time step can be set only while the simulation is stopped; stop it first")
        if not 0 < seconds <= 10:
            raise CommandError(f"a time step is a number above 0, up to 10 s, not {seconds}")
        self.substeps = self._substeps(seconds, self._wanted_timestep)
        self._time_step = float(seconds)
        timestep = self._time_step / self.substeps
        if abs(timestep - self.model.opt.timestep) > 1e-12:
            logger.info(
                "physics step is %.6g s, a whole fraction of the simulation step of %.6g s",
                timestep,
                self._time_step,
            )
        self.model.opt.timestep = timestep
        self.joints.forget_run()

    def set_physics_step(self, seconds: float) -> None:
        """Set the length of a physics step; only while stopped. A simulation step has a whole number of them.

        Raises:
            CommandError: the simulation is not stopped, or the length is not above 0 and up to a simulation step.
            LimitReached: a simulation step would have too many.
        """
        self._require_stopped("the length of a physics step can be set")
        if not 0 < seconds <= self._time_step:
            raise CommandError(
                f"a physics step is above 0 and up to the simulation step, {self._time_step:g} s, not {seconds}"
            )
        self._substeps(self._time_step, seconds)
        self._wanted_timestep = float(seconds)
        self.time_step = self._time_step

    @property
    def physics_step(self) -> float:
        """Return the length of a physics step that was asked for; the actual one is a whole fraction of `time_step`."""
        return self._wanted_timestep

    @property
    def is_running(self) -> bool:
        """Return whether the simulation is started, paused or not."""
        return self.state != SimulationState.STOPPED

    @property
    def is_before_first_step(self) -> bool:
        """Return whether the simulation is started and nothing has been computed yet."""
        return self.is_running and self.step_count == 0

    def load(self, path: str | Path) -> None:
        """Replace the scene by that of a file, which may reference files in any folder.

        Raises:
            CommandError: not stopped.
            SceneError: the file is bad; the present scene stays.
        """
        self._require_stopped("a scene can be loaded")
        is_of_client = self.files.client_files.made(Path(path))
        self.use(*load_scene(path, self.files.sources), is_of_client=is_of_client)

    def use(
        self, scene: Scene, model: mujoco.MjModel, *, is_of_client: bool = False, is_logged: bool = True
    ) -> None:
        """Replace the scene by one that is built already; `is_of_client`: from a file that a client sent."""
        self._require_stopped("a scene can be loaded")
        self.compile_edits()
        self.limits.check("objects", len(scene.objects), f"'{scene.name}' has {len(scene.objects)}")
        data = self._first_state(scene, model)
        self.parts.tell(lambda part: part.scene_closing())
        self._adopt(scene, model, data)
        if is_logged:
            logger.info("scene '%s' is loaded with %d objects", scene.name, len(scene.objects))
            log_overlaps(scene, model, self.data)
        self.scene_is_of_client = is_of_client
        if (report := scene.import_report) is not None:
            self.parts.tell(lambda part: part.file_imported(report))
        self.parts.tell(lambda part: part.scene_changed())
        self.parts.tell(lambda part: part.scene_loaded())
        properties.apply(self)
        self.parts.tell(lambda part: part.model_changed(None))

    def close(self) -> None:
        """Replace the scene by V-REP's default one.

        Raises:
            CommandError: the simulation is not stopped.
        """
        self._require_stopped("a scene can be closed")
        self.use(*default_scene(self.files.sources))

    def start(self) -> None:
        """Start from stopped (everything is saved), resume from paused.

        Raises:
            CommandError: a part refuses the run: from this very state, one was stopped at its first step (`Physics`).
        """
        if self.state == SimulationState.PAUSED:
            self.state = SimulationState.RUNNING
            self.parts.tell(lambda part: part.run_resumed())
            return
        if self.state == SimulationState.RUNNING:
            return
        self.compile_edits()
        self.foresight.begin_run()
        self.parts.tell_of_run("run_starting")
        self._snapshot = self.snapshot()
        self.joints.forget_run()
        self.step_count = 0
        self.state = SimulationState.RUNNING
        self.refresh()
        self.parts.tell_of_run("run_started")

    def snapshot(self) -> Snapshot:
        """Return everything that a run may change, as it is now."""
        return Snapshot.take(self.scene, self.model, self.data, self.editable_arrays(), self.joints)

    def _restore(self, snapshot: Snapshot) -> bool:
        """Restore a saved state; return whether scene or model are other objects than before."""
        replaced = self.model is not snapshot.model or self.scene is not snapshot.scene
        snapshot.scene.next_handle = (
            self.scene.next_handle
        )  # handles of the run's new objects are not used again
        self.scene, self.model, self.data = snapshot.scene, snapshot.model, snapshot.data
        snapshot.restore(self.editable_arrays(), is_replaced=replaced)
        self.joints.recall(snapshot.joints)
        return replaced

    def go_back(self, snapshot: Snapshot, step_count: int) -> None:
        """Set a run that has just started to the end of a step of an earlier one, whose state was saved.

        Args:
            snapshot: restored in place of the present state; a stop still restores that of the start.
            step_count: steps of the earlier run.
        """
        replaced = self._restore(snapshot)
        self.step_count = step_count
        self.model_edited()
        self.moved()
        self.refresh()
        if replaced:
            self.parts.tell(lambda part: part.model_changed(None))

    def pause(self) -> None:
        """Pause simulated time; do nothing when not running."""
        if self.state == SimulationState.RUNNING:
            self.state = SimulationState.PAUSED
            self.parts.tell(lambda part: part.run_paused())

    def stop(self) -> None:
        """End the run and restore, bit for bit, the state saved at its start."""
        if self.state == SimulationState.STOPPED or self._snapshot is None:
            return
        self.is_stopping = True
        self.parts.tell_of_end(self.compile_edits)
        self.state = SimulationState.STOPPED
        snapshot, self._snapshot = self._snapshot, None
        self.step_count = 0
        replaced = self._restore(snapshot)
        self.model_edited()
        self.changed()
        self.refresh()
        self.is_stopping = False
        self.parts.tell_of_run("run_stopped")
        if replaced:
            self.parts.tell(lambda part: part.model_changed(None))

    def editable_arrays(self) -> Sequence[memoryview]:
        """Return the bytes of every array of the model that a command may write: finding them takes longer than
        copying them.
        """
        if self._arrays is None or self._arrays[0] is not self.model:
            self._arrays = self.model, [value.data.cast("B") for _, value in editable_arrays(self.model)]
        return self._arrays[1]

    def measure_joints(self) -> None:
        """Measure the velocities of joints at the end of the physics of a simulation step."""
        self.joints.measure()

    def count_step(self) -> None:
        """Advance the time after a complete simulation step."""
        self.step_count += 1
        self.parts.tell_of_step()

    @property
    def is_plain(self) -> bool:
        """Return whether nothing but the next simulation steps changes the state: no edit waits, nothing was moved
        other than joints.
        """
        return (
            self.waiting is None
            and self.is_settled
            and not self.is_stopping
            and (not self.is_rearranged or self.model.ngeom <= FEW)
        )

    def adopt_steps(self, step_count: int, versions: int, *, was_restarted: bool) -> None:
        """Take over simulation steps that were made outside, with the kinematics of their end.

        Args:
            step_count: simulation steps of this run now.
            versions: number of steps and restarts that were made.
            was_restarted: the run has ended and started again.
        """
        self.step_count = step_count
        self.version += versions
        self._stale = False
        if was_restarted:
            self.model_edited()

    def fail(self, problem: str) -> None:
        """End a run that cannot continue. Calls that wait for one of its steps fail with the reason.

        The stop resets MuJoCo's data, which an error leaves half computed.
        """
        self.failure = problem
        try:
            self.stop()
        finally:
            self.failure = ""
            self.parts.tell(lambda part: part.script_stopped(problem))

    def soon(self, action: Callable[[], object]) -> None:
        """Start, pause or stop at the request of a script, once no simulation step and no script is in progress."""
        self._soon.append(action)

    def stop_soon(self) -> None:
        """Stop as `soon` does; do nothing when stopped."""
        if self.is_running and not self.is_stopping:
            self.is_stopping = True
            self.soon(self.stop)

    @property
    def is_settled(self) -> bool:
        """Return whether no action of `soon` is pending."""
        return not self._soon

    def give_up(self) -> None:
        """Note that the server ends: long-running work stops. Any thread."""
        self.is_ending = True

    def settle(self) -> list[CommandError]:
        """Run the actions of `soon`; call it while neither a simulation step nor a command is in progress.

        Returns:
            The reasons why some could not be run, which are in the log as well.
        """
        problems: list[CommandError] = []
        while self._soon:
            action = self._soon.pop(0)
            try:
                action()
            except CommandError as problem:
                logger.error("what a script asked for cannot be done: %s", problem)
                problems.append(problem)
        return problems

    def changed(self) -> None:
        """Note that state or model was written: readers see a new version and fresh kinematics."""
        self.sleepers.wake()
        self.is_rearranged = True
        self.moved()

    def moved(self, *, is_updated: bool = False) -> None:
        """Note other positions; `is_updated`: what follows from them is up to date already."""
        self.version += 1
        self._stale = not is_updated

    def model_edited(self) -> None:
        """Note that arrays or options of the model were written, so copies of it are stale."""
        self.model_version += 1

    def refresh(self) -> None:
        """Update everything that follows from positions, if stale. No time passes."""
        if not self._stale:
            return
        if self.sleepers.are_to_wake:
            self.sleepers.wake_with(kinematics.update)
        else:
            kinematics.update(self.model, self.data)
        self._stale = False

    def hold(self, waiting: Waiting) -> None:
        """Continue with a scene whose model is compiled when something reads it."""
        if self.waiting is None:
            self.waiting, self.scene = waiting, waiting.scene
            del self.model, self.data
            self.joints.forget_places()
        self.model_edited()
        self.changed()
        self.parts.tell(lambda part: part.scene_edited())

    @property
    def edition(self) -> object:
        """Return a value that an edit of the scene changes. To read it compiles no edits that wait."""
        return self.model if self.waiting is None else self.waiting.edits

    def compile_edits(self) -> None:
        """Compile the edits that wait, if there are any. A read of `model` or `data` calls this."""
        waiting, self.waiting = self.waiting, None
        if waiting is not None:
            self.scene, self.model, self.data = waiting.before, waiting.model, waiting.data
            with self.interruptions.unasked_edit():
                compile_waiting(self, waiting)

    def replace_model(self, scene: Scene, model: mujoco.MjModel, data: mujoco.MjData, twins: Twins) -> None:
        """Continue with an edited scene whose state was carried over (see `scene/editing/editing.py`)."""
        self._take(scene, model, data)
        self.sleepers.keep_possible(model)
        self.joints.rebind()
        self.model_edited()
        self.changed()
        self.refresh()
        self.parts.tell(lambda part: part.model_changed(twins))

    def replace_scene(self, scene: Scene, twins: Twins) -> None:
        """Continue with a scene that an edit has made in the present model (see `scene/editing/in_place`)."""
        self.scene = scene
        self.model_edited()
        self.changed()
        self.refresh()
        self.parts.tell(lambda part: part.model_changed(twins))

    def _first_state(self, scene: Scene, model: mujoco.MjModel) -> mujoco.MjData:
        """Return the initial state of a scene.

        Raises:
            CommandError: the scene cannot be simulated.
        """
        self._substeps(scene.annotations.time_step or DEFAULT_TIME_STEP, model.opt.timestep)
        self.sleepers.keep_possible(model)
        try:
            data = mujoco.MjData(model)
            scene.start.put_into(model, data)
            set_turns(scene, model, data)
            with physics_warnings.OnceAKind():
                self.foresight.forward(model, data)
        except (mujoco.FatalError, MemoryError) as error:
            raise CommandError(f"'{scene.name}' cannot be simulated: {one_line(error)}") from error
        return data

    def _substeps(self, time_step: float, timestep: float) -> int:
        """Return the number of physics steps in a simulation step.

        Raises:
            LimitReached: there are too many.
        """
        count = max(1, round(min(time_step / timestep, 1e15)))
        self.limits.check(
            "substeps",
            count,
            f"a simulation step of {time_step:g} s with physics steps of {timestep:g} s has {count}; choose a shorter "
            "simulation step, or a scene with a longer timestep of <option>",
        )
        return count

    def _adopt(self, scene: Scene, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        self._solver_problem = ""
        self._take(scene, model, data)
        self.files.scene_opened(scene.path)
        self.scene_id += 1
        self.dynamics_enabled = bool(scene.annotations.scene.get("dynamics", True))
        self.scene_is_of_client = False
        self._wanted_timestep = float(model.opt.timestep)
        self._stale = True
        self.joints = Joints(self)
        self.step_count = 0
        self.time_step = scene.annotations.time_step or DEFAULT_TIME_STEP
        self.refresh()
        self.model_edited()
        self.changed()

    def _take(self, scene: Scene, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Hold them; log what this MuJoCo solves wrongly, once while it lasts."""
        self.waiting = None
        self.scene, self.model, self.data = scene, model, data
        known, self._solver_problem = self._solver_problem, solver_problem(model)
        if self._solver_problem and not known:
            logger.warning("%s", self._solver_problem)

    @contextmanager
    def going_back(self) -> Generator[None]:
        """Mark what happens within the block: a stop, then a start of a run that goes on from an earlier step."""
        self._is_going_back = True
        try:
            yield
        finally:
            self._is_going_back = False

    @property
    def is_going_back(self) -> bool:
        """Return whether a new run goes on from an earlier step: a stop is followed by a start at once."""
        return self._is_going_back

    def _require_stopped(self, what: str) -> None:
        if self.state != SimulationState.STOPPED:
            raise CommandError(f"{what} only while the simulation is stopped; stop it first")
