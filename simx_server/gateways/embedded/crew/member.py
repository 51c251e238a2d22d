"""One world of a crew: how its steps are made at present, and what Python's objects of it take over from a crew."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_client.errors import ConnectionFailed
from simx_client.protocol.commands import ANSWERED, TRIGGER, Command
from simx_client.protocol.kinds import INT
from simx_client.protocol.messages import STATUS_OK, Reply, of_fields
from simx_client.transport.direct import Noted, Refusal
from simx_server.joints.guards.watch import DIVERGED, StepFailed
from simx_server.joints.measured import Positions
from simx_server.joints.native.loading import crew_form
from simx_server.joints.stepping.apart import Apart, Made
from simx_server.joints.stepping.motors import no_room
from simx_server.service.answers.answers import Answer
from simx_server.service.calls.direct import DirectCall

from .operations import Reads, Write, Writes, numbers_of, single

if TYPE_CHECKING:
    from simx_server.joints.native._crew import Course, Operation
    from simx_server.joints.native._physics_step import PhysicsStep

    from .lent import Lent

TIMEOUT = 60.0
"""Time-out in seconds of a step that is made by calls."""

_TRIGGER = ANSWERED[TRIGGER]

Rows = NDArray[np.float64]

Physics = Generator[Apart, Made, list[Refusal]]
"""Makes the steps of one world. The crew makes the physics that comes by yields."""


class Calls(NamedTuple):
    """The calls of one world in a step, and at the start of an episode; see `simx_client.transport.direct.Plan`."""

    starts: Noted | None
    writes: Noted
    reads: Noted
    steps: int


class _Start(NamedTuple):
    """The start of an episode to which a world can go back by compiled code alone."""

    writes: Sequence[Write]
    settings: Sequence[tuple[int, dict[str, Any]]]
    """Those that writes of the plan change, by joint, as they are at the start."""


_WRITTEN = "target_position", "target_velocity", "max_force", "backwards", "held"
"""Settings of joints that `operations.py` notes."""


class Member:
    """A world, with the calls of its plan."""

    def __init__(self, place: int, lent: Lent, calls: Calls) -> None:
        self._place, self._link, self._calls = place, lent.link, calls
        self._turns, self._alone, self._service = lent.turns, lent.alone, lent.service
        self._world, self._simulation = lent.service.world, lent.service.simulation
        self._joints = lent.service.simulation.joints
        self._direct: Callable[[Command], DirectCall] = lambda command: lent.direct(lent.session, command)
        self._trigger = self._direct(_TRIGGER)
        compiled = crew_form().module
        self._of_steps = (
            (compiled.RATE, compiled.VELOCITY, compiled.ANGULAR_VELOCITY) if compiled is not None else ()
        )
        """Reads that compiled code can only make if it makes all of the steps."""

        self.course: Course | None = None
        """Compiled steps of this world; the world is lent while it is set."""

        self._apart: Course | None = None
        self._apart_of: tuple[object, int] = None, -1
        """The physics steps of that course, and the version of the model."""

        self._writes_apart: Sequence[Write] = ()
        self._are_written = self._are_read = False
        """Whether that course can make the writes and the reads of the plan."""

        self._writes: Sequence[Write] = ()
        self._start: _Start | None = None
        self._steps_before = 0
        self.refusals: list[Refusal] = []
        """The trigger whose step could not be made while the world was lent."""

    def reason_against(self) -> str | None:
        """Return why threads cannot make the physics of this world now; None: they can. Within no turn."""
        self._turns.begin()
        try:
            if not self._link.is_direct or not self._alone.is_alone:
                return "other clients, a recording or a history see each step"
            return None if self._world.physics.may_be_apart else "Python has something to do within physics"
        finally:
            self._turns.end()

    @property
    def physics_seconds(self) -> float:
        """Return how long the physics of the last simulation step took; 0 before the first."""
        course = self.course or self._apart
        return 0.0 if course is None else course.seconds

    @property
    def lent_course(self) -> Course:
        """Return the compiled steps of this world, which is lent."""
        assert self.course is not None
        return self.course

    # --- by compiled code alone ------------------------------------------------------------------

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
        refusals, self.refusals = self.refusals, []
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
        self.refusals = self._end_step(course) if course.is_open else []

    def _end_step(self, course: Course) -> list[Refusal]:
        """End a simulation step that compiled code has left: it has failed, or takes long."""

        def finish() -> None:
            self._world.physics.finish(lambda: self._go_on(course), course.warnings)

        answer = self._alone.finish(self._trigger, lambda: self._world.finish_step(finish))
        return self._refused(_TRIGGER, [], answer)

    def _go_on(self, course: Course) -> bool:
        compiled = crew_form().module
        assert compiled is not None
        if course.outcome in (compiled.NO_ROOM, compiled.FAILED, compiled.EXCEPTION):
            raise self._error(course)
        if not course.is_finite:
            raise StepFailed(DIVERGED)
        return self._joints.controllers.stepper.go_on(
            course.made, self._simulation.substeps, course.last_flags
        )

    def _error(self, course: Course) -> BaseException:
        """Return why physics could not be made."""
        compiled = crew_form().module
        assert compiled is not None
        if course.outcome == compiled.NO_ROOM:
            return no_room(self._simulation.data)
        return mujoco.FatalError(course.problem) if course.outcome == compiled.FAILED else course.error

    # --- with Python before and after physics ----------------------------------------------------

    def run(self, values: Rows, results: Rows, steps: int | None = None) -> Physics:
        """Write, make the simulation steps and read. Takes a turn, also between the yields.

        Args:
            values: numbers of the writes.
            results: receives those of the reads.
            steps: number of steps; None: those of the plan. Otherwise nothing is written, since that was done.

        Returns:
            The calls that failed.
        """
        self._turns.begin()
        try:
            if not self._alone.is_alone:
                return self._by_messages(values, results, steps)
            refusals: list[Refusal] = []
            if steps is None:
                refusals += self._write(values)
            for _ in range(self._calls.steps if steps is None else steps):
                if self._alone.is_alone:
                    answer = yield from self._alone.step_apart(self._trigger)
                else:  # the run has ended
                    answer = self._direct_answer(self._trigger, [])
                refusals += self._refused(_TRIGGER, [], answer)
            return refusals + self._read(results)
        finally:
            self._turns.end()

    def course_of(self, apart: Apart) -> Course:
        """Return a course for physics that a thread is to make."""
        course = self._present()
        if course is None or self._apart_of[0] is not apart.step:
            course = self._apart = self._course(apart.step, (), (), ())
            self._apart_of = apart.step, -1
        return course

    def _present(self) -> Course | None:
        """Return a course that writes and reads in the present state; None: there is none."""
        simulation = self._simulation
        step = self._joints.controllers.stepper.compiled
        key = step, simulation.model_version
        if step is None:
            return None
        if self._apart_of != key:
            self._apart_of = key
            find_write, find_read = Writes(self._world), Reads(self._world)
            writes = [find_write.of(*call, is_start=False) for call in self._calls.writes]
            reads = [find_read.of(*call) for call in self._calls.reads]
            self._are_written = None not in writes
            self._are_read = all(each is not None and each[0] not in self._of_steps for each in reads)
            self._writes_apart = [each for each in writes if each is not None] if self._are_written else []
            found = [each for each in reads if each is not None] if self._are_read else []
            self._apart = self._course(step, self._writes_apart, found, find_read.frames)
        return self._apart

    def _course(
        self, step: PhysicsStep, writes: Sequence[Write], reads: Sequence[Operation], frames: Rows | tuple[()]
    ) -> Course:
        compiled, simulation = crew_form().module, self._simulation
        assert compiled is not None
        return compiled.Course(
            step, simulation.substeps, 0, False, simulation.time_step, [each.operation for each in writes], [],
            list(reads), np.array(frames, np.float64), _NONE,
        )  # fmt: skip

    def made(self) -> Made | BaseException:
        """Return what has come of the physics that a thread has made, or its error."""
        compiled, course = crew_form().module, self._apart
        assert compiled is not None
        assert course is not None
        return Made(course.made, course.warnings) if course.outcome == compiled.WELL else self._error(course)

    def _write(self, values: Rows) -> list[Refusal]:
        course = self._present()
        if course is not None and self._are_written and course.write(values):
            for write, number in zip(self._writes_apart, values.tolist(), strict=False):
                write.note(single(number))
            return []
        refusals: list[Refusal] = []
        for command, arguments in filled(self._calls.writes, values.tolist()):
            refusals += self._refused(
                command, arguments, self._direct_answer(self._direct(command), arguments)
            )
        return refusals

    def _read(self, results: Rows) -> list[Refusal]:
        simulation = self._simulation
        course = self._present() if simulation.is_running else None
        if course is not None and self._are_read:
            simulation.refresh()
            course.read(results)
            return []
        refusals: list[Refusal] = []
        found: list[float] = []
        for command, arguments in self._calls.reads:
            call = self._direct(command)
            answer = self._direct_answer(call, arguments)
            refused = self._refused(command, arguments, answer)
            numbers = None if refused else numbers_of(call.received(answer[1]))
            if refused or numbers is None:
                refusals += refused
            else:
                found += numbers
        if not refusals:
            results[: len(found)] = found
        return refusals

    def read_start(self, results: Rows) -> None:
        """Read the state at the start of an episode. Within no turn.

        Raises:
            ConnectionFailed: a read was refused.
        """
        if self.course is not None:
            self.course.read(results)
            return
        self._turns.begin()
        try:
            refused = self._read(results)
        finally:
            self._turns.end()
        if refused:
            raise ConnectionFailed(f"{refused[0].command.name} was refused: {refused[0].reply.values}")

    def widths(self) -> list[int]:
        """Return how many numbers each read has. Within no turn.

        Raises:
            ConnectionFailed: a read has no numbers, or they come later.
        """
        self._turns.begin()
        try:
            widths: list[int] = []
            for command, arguments in self._calls.reads:
                call = self._direct(command)
                answer = self._direct_answer(call, arguments)
                numbers = numbers_of(call.received(answer[1])) if answer[0] == STATUS_OK else None
                if numbers is None:
                    raise ConnectionFailed(f"{command.name} returns no numbers")
                widths.append(len(numbers))
            return widths
        finally:
            self._turns.end()

    def _by_messages(self, values: Rows, results: Rows, steps: int | None) -> list[Refusal]:
        """Do the same by calls that may wait for other clients. Within a turn, which is interrupted."""
        writes = list(filled(self._calls.writes, values.tolist())) if steps is None else []
        trigger: tuple[Command, list[Any]] = (_TRIGGER, [])
        count = self._calls.steps if steps is None else steps
        calls = [*writes, *[trigger] * count, *self._calls.reads]
        self._turns.end()
        try:
            replies = self._link.execute_together(calls, TIMEOUT) or []
        finally:
            self._turns.begin()
        missing = calls[len(replies) :]
        if missing:
            late = of_fields(Reply, (0, -1, 0, [f"no answer within {TIMEOUT:g} s"]))
            return [Refusal(self._place, *missing[0], late)]
        refusals = [
            Refusal(self._place, command, arguments, reply)
            for (command, arguments), reply in zip(calls, replies, strict=True)
            if reply.status
        ]
        if not refusals:
            read = replies[len(calls) - len(self._calls.reads) :]
            found = [number for reply in read for number in numbers_of(reply.values) or ()]
            results[: len(found)] = found
        return refusals

    def _direct_answer(self, call: DirectCall, arguments: list[Any]) -> Answer:
        answer = call.execute(arguments)
        if answer.__class__ is not tuple:
            raise ConnectionFailed("a call of a crew has to be answered at once")
        return cast("Answer", answer)

    def _refused(self, command: Command, arguments: list[Any], answer: Answer) -> list[Refusal]:
        status, values = answer
        if status == STATUS_OK:
            return []
        return [Refusal(self._place, command, arguments, of_fields(Reply, (0, status, 0, values)))]


def _note(writes: Sequence[Write], values: bytes) -> None:
    for write, number in zip(writes, np.frombuffer(values).tolist(), strict=True):
        write.note(single(number))


def filled(calls: Noted, values: Sequence[float]) -> Iterator[tuple[Command, list[Any]]]:
    """Yield calls with these numbers as their last arguments."""
    place = 0
    for command, arguments in calls:
        last = arguments[-1]
        width = _width(last)
        numbers = values[place : place + width]
        place += width
        if isinstance(last, list):
            yield command, [*arguments[:-1], list(numbers)]
        else:
            is_integer = command.arguments[-1].kind is INT
            yield command, [*arguments[:-1], int(numbers[0]) if is_integer else numbers[0]]


def width_of(calls: Noted) -> int:
    """Return how many numbers calls have as their last arguments."""
    return sum(_width(arguments[-1]) for _, arguments in calls)


def _width(argument: Any) -> int:
    return len(cast("list[Any]", argument)) if isinstance(argument, list) else 1


def _positions(numbers: bytes | None, joints: int) -> Positions | None:
    """Return positions of joints and of tendons."""
    if numbers is None:
        return None
    both = np.frombuffer(numbers)
    return both[:joints], both[joints:]


_NONE = np.zeros(0)
