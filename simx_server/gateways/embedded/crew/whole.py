"""Steps of one world by compiled code alone, and what Python's objects of it take over from them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from simx_client.transport.direct import Refusal
from simx_server.joints.guards.watch import DIVERGED, StepFailed
from simx_server.joints.measured import Positions
from simx_server.joints.native.loading import crew_form

from .calls import Caller, Calls
from .errors import error_of
from .operations import Reads, Write, Writes, single

if TYPE_CHECKING:
    from simx_server.joints.native._crew import Course

    from .lent import Lent


class _Start(NamedTuple):
    """The start of an episode to which a world can go back by compiled code alone."""

    writes: Sequence[Write]
    settings: Sequence[tuple[int, dict[str, Any]]]
    """Those that writes of the plan change, by joint, as they are at the start."""


_WRITTEN = "target_position", "target_velocity", "max_force", "backwards", "held"
"""Settings of joints that `operations.py` notes."""


class Whole:
    """Steps of a world that compiled code makes: writes, physics and reads."""

    def __init__(self, caller: Caller, lent: Lent, calls: Calls) -> None:
        self._caller, self._link, self._calls = caller, lent.link, calls
        self._turns, self._alone, self._service = lent.turns, lent.alone, lent.service
        self._world, self._simulation = lent.service.world, lent.service.simulation
        self._joints = lent.service.simulation.joints
        self.course: Course | None = None
        """Compiled steps of this world; the world is lent while it is set."""

        self._writes: Sequence[Write] = ()
        self._start: _Start | None = None
        self._steps_before = 0
        self._refusals: list[Refusal] = []
        """The trigger whose step could not be made while the world was lent."""

    @property
    def lent_course(self) -> Course:
        """Return the compiled steps of this world, which is lent."""
        assert self.course is not None
        return self.course

    def lend(self, take_back: Callable[[], object]) -> bool:
        """Let compiled code make the steps from now on, if nothing else has to. Within no turn.

        Args:
            take_back: called in the next turn of the world; has to call `settle`.
        """
        self._turns.begin()
        try:
            course = self._find_course()
            if course is not None:
                self.course = course
                self._link.lend(take_back)
            return course is not None
        finally:
            self._turns.end()

    def _find_course(self) -> Course | None:
        world, simulation, joints = self._world, self._simulation, self._joints
        compiled = crew_form().module
        if compiled is None or not (
            self._link.is_direct
            and self._alone.is_alone
            and world.is_only_physics
            and simulation.is_plain
            and not world.surfaces.are_to_move
            and self._alone.is_unwatched
            and world.physics.may_be_apart
        ):
            return None
        simulation.refresh()
        block = world.velocities.copies.block
        step = joints.controllers.stepper.compiled
        if block is None or step is None:
            return None
        find_write, find_read = Writes(world), Reads(world)
        writes = [find_write.of(*call, is_start=False) for call in self._calls.writes]
        reads = [find_read.of(*call) for call in self._calls.reads]
        if None in writes or None in reads:
            return None
        starts: list[Write | None] = [None]
        is_start = simulation.is_before_first_step and self._calls.starts is not None
        if is_start:
            starts = [find_write.of(*call, is_start=True) for call in self._calls.starts or ()]
        elif simulation.is_rearranged:
            return None
        may_restart = None not in starts
        if simulation.is_rearranged and not may_restart:
            return None  # the stage of surfaces has to see what was moved
        self._writes = [each for each in writes if each is not None]
        first = [each for each in starts if each is not None]
        stepper = joints.controllers.stepper
        course = compiled.Course(
            step,
            simulation.substeps,
            stepper.own_flags,
            stepper.may_skip_means(average_force=joints.controllers.averages_force),
            simulation.time_step,
            [each.operation for each in self._writes],
            [each.operation for each in first],
            reads,
            find_read.frames,
            block,
        )
        newest = joints.measured.newest
        course.begin(
            None if newest is None else np.concatenate(newest),
            world.velocities.newest,
            simulation.is_rearranged,
            world.physics.has_overlaps,
        )
        self._steps_before, self._start = simulation.step_count, None
        if may_restart:
            course.capture()
            calls = (*self._calls.writes, *(self._calls.starts or ()))
            self._start = _Start(first, [self._settings(arguments[0]) for _, arguments in calls])
        return course

    def _settings(self, handle: int) -> tuple[int, dict[str, Any]]:
        state = self._joints.state(handle)
        return handle, {name: getattr(state, name) for name in _WRITTEN}

    def take_over(self) -> list[Refusal]:
        """Have Python make the steps again; return the trigger whose step could not be made. Within no turn."""
        self._turns.begin()
        self._turns.end()
        refusals, self._refusals = self._refusals, []
        return refusals

    def settle(self) -> None:
        """Bring Python's objects up to date with what compiled code has done. Within a turn."""
        course, self.course = self.course, None
        assert course is not None
        self._link.returned()
        joints, count = self._joints, int(self._simulation.model.nq)
        before, after, poses_before, poses_after, starts, values = course.memory()
        if course.restarts and self._start is not None:
            for handle, settings in self._start.settings:
                joints.note_written(handle, **settings)
            _note(self._start.writes, starts)
        if course.was_written:
            _note(self._writes, values)
        joints.measured.adopt(_positions(before, count), _positions(after, count))
        self._world.velocities.adopt(np.frombuffer(poses_before), np.frombuffer(poses_after))
        self._simulation.adopt_steps(
            course.steps + (0 if course.restarts else self._steps_before),
            course.all_steps + course.restarts,
            was_restarted=course.restarts > 0,
        )
        self._world.physics.go_on(is_rearranged=course.is_rearranged, has_overlaps=course.has_overlaps)
        self._world.vision.adopt_run(is_new=course.restarts > 0, has_steps=course.steps > 0)
        if course.all_steps:
            self._service.rounds.count_steps(course.all_steps, course.seconds)
        self._refusals = self._end_step(course) if course.is_open else []

    def _end_step(self, course: Course) -> list[Refusal]:
        """End a simulation step that compiled code has left: it has failed, or takes long."""

        def finish() -> None:
            self._world.physics.finish(lambda: self._go_on(course), course.warnings)

        answer = self._alone.finish(self._caller.trigger, lambda: self._world.finish_step(finish))
        return self._caller.trigger_refused(answer)

    def _go_on(self, course: Course) -> bool:
        compiled = crew_form().module
        assert compiled is not None
        if course.outcome in (compiled.NO_ROOM, compiled.FAILED, compiled.EXCEPTION):
            raise error_of(course, self._simulation.data)
        if not course.is_finite:
            raise StepFailed(DIVERGED)
        return self._joints.controllers.stepper.go_on(
            course.made, self._simulation.substeps, course.last_flags
        )


def _note(writes: Sequence[Write], values: bytes) -> None:
    for write, number in zip(writes, np.frombuffer(values).tolist(), strict=True):
        write.note(single(number))


def _positions(numbers: bytes | None, joints: int) -> Positions | None:
    """Return positions of joints and of tendons."""
    if numbers is None:
        return None
    both = np.frombuffer(numbers)
    return both[:joints], both[joints:]
