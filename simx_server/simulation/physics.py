"""The physics of a simulation step: MuJoCo's steps with the joint controllers, and runs that cannot go on."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence

import mujoco

from simx_server.errors import CommandError, one_line
from simx_server.joints.guards.crowding import FEW, is_crowded
from simx_server.joints.guards.watch import StepFailed, TooSlow
from simx_server.joints.stepping.apart import Stepping
from simx_server.joints.stepping.stepper import LIMIT_SEPARATION, UPDATE
from simx_server.scene import physics_warnings

from .part import Part
from .simulation import Simulation

logger = logging.getLogger(__name__)


class Physics(Part):
    """Makes the physics steps of a simulation. It is the first of its parts: a run that it refuses does not start."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self.has_overlaps = False
        """Shapes overlapped deeply in the last physics step."""
        self._warnings = physics_warnings.OnceAKind()
        self._too_slow: tuple[int, int, str] | None = None
        """The version of state and model with which a run could not make its first step, and the reason."""

    def run_starting(self) -> None:
        """Refuse a start that would be stopped at its first step. Raises CommandError."""
        sim = self._sim
        if self._too_slow is not None and sim.dynamics_enabled:
            version, model_version, text = self._too_slow
            if (version, model_version) == (sim.version, sim.model_version):
                raise CommandError(f"the simulation is not started, because nothing has changed since {text}")

    def run(self) -> None:
        """Make the physics steps of one simulation step. When physics cannot continue, the run is stopped."""
        try:
            self._make_steps()
        except (StepFailed, mujoco.FatalError) as error:
            self._give_up(error)

    @property
    def may_be_apart(self) -> bool:
        """Return whether nothing within the physics of the next simulation step needs Python."""
        sim = self._sim
        return (
            sim.dynamics_enabled
            and sim.joints.controllers.may_be_apart
            and not sim.sleepers.must_stay_awake
            and not sim.foresight.is_needed(sim.model)
        )

    def run_apart(self) -> Stepping:
        """Make the physics steps as `run`; those that need no Python are yielded to the caller."""
        if not self.may_be_apart:
            self.run()
            return
        sim = self._sim
        try:
            flags = self._begin()
            if sim.sleepers.are_to_wake:
                sim.refresh()
            self.has_overlaps = yield from sim.joints.controllers.step_apart(
                sim.substeps, flags | UPDATE, self._warnings.log
            )
            self._end(is_updated=not sim.sleepers.are_to_wake)
        except (StepFailed, mujoco.FatalError) as error:
            self._give_up(error)

    def finish(self, go_on: Callable[[], bool], warnings: Sequence[str]) -> None:
        """Make the rest of physics that was started outside. When it cannot continue, the run is stopped.

        Args:
            go_on: makes the missing physics steps, and returns whether shapes overlap deeply.
            warnings: texts of MuJoCo's, so far.
        """
        try:
            self._warnings.log(warnings)
            with self._warnings:
                self.has_overlaps = go_on()
            self._end(is_updated=True)
        except (StepFailed, mujoco.FatalError) as error:
            self._give_up(error)

    def go_on(self, *, is_rearranged: bool, has_overlaps: bool) -> None:
        """Continue from the physics of an earlier step.

        Args:
            is_rearranged: state or model were written after it.
            has_overlaps: shapes overlapped deeply in it.
        """
        self._sim.is_rearranged, self.has_overlaps = is_rearranged, has_overlaps

    def _make_steps(self) -> None:
        """Make the physics steps, and update the kinematics.

        Raises:
            StepFailed: physics diverges or takes too long.
            mujoco.FatalError: MuJoCo failed.
        """
        sim = self._sim
        if not sim.dynamics_enabled:
            sim.moved()
            sim.refresh()
            return
        flags = self._begin()
        sleepers = sim.sleepers
        with self._warnings:
            if sleepers.are_to_wake:
                sim.refresh()
            if sleepers.must_stay_awake:
                with sleepers.kept_awake():
                    self._step_joints(flags)
                is_updated = False
            else:
                self._step_joints(flags | UPDATE)
                is_updated = not sleepers.are_to_wake  # clients are served within a long step
        self._end(is_updated)

    def _begin(self) -> int:
        """Return the corrections that the physics steps need.

        Raises:
            StepFailed: too many shapes overlap.
        """
        sim = self._sim
        flags = LIMIT_SEPARATION if sim.is_rearranged or self.has_overlaps else 0
        if sim.is_rearranged:  # positions were set; physics alone keeps shapes apart
            sim.is_rearranged = False
            if sim.model.ngeom > FEW:
                self._check_room()
        return flags

    def _end(self, is_updated: bool) -> None:
        """Note that time has passed; `is_updated`: the kinematics are those of its end."""
        self._sim.moved(is_updated=is_updated)
        self._sim.refresh()

    def _step_joints(self, flags: int) -> None:
        sim = self._sim
        foresight = sim.foresight
        if not foresight.is_needed(sim.model):
            self.has_overlaps = sim.joints.controllers.step(sim.substeps, flags)
            return
        try:
            self.has_overlaps = sim.joints.controllers.step(sim.substeps, flags, foresight.look)
        finally:
            foresight.restore()

    def _check_room(self) -> None:
        """Refuse a state in which one physics step might take very long.

        Raises:
            StepFailed: too many shapes overlap.
        """
        sim = self._sim
        sim.refresh()
        if is_crowded(sim.model, sim.data, sim.limits.near_pairs):
            reached = sim.limits.reached("near_pairs", "move shapes apart, or remove some")
            raise TooSlow(f"too many shapes are in the same place; {reached}")

    def _give_up(self, error: Exception) -> None:
        """End a run whose physics cannot continue; the log says why."""
        sim = self._sim
        text = str(error) if isinstance(error, StepFailed) else f"MuJoCo cannot go on: {one_line(error)}"
        what, _, advice = text.partition("; ")
        problem = f"{what} at {sim.time:.3f} s; the simulation is stopped"
        logger.error("%s", problem)
        is_first = sim.is_before_first_step
        sim.fail(f"{problem}; {advice}" if advice else problem)
        if is_first and isinstance(error, TooSlow):
            self._too_slow = sim.version, sim.model_version, text
