"""Steps of one world in which Python has a part: it writes, makes what is beside the physics, and reads."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from simx_client.errors import ConnectionFailed
from simx_client.protocol.commands import ANSWERED, TRIGGER, Command
from simx_client.protocol.messages import STATUS_OK, Reply, of_fields
from simx_client.transport.direct import Refusal
from simx_server.joints.native.loading import crew_form
from simx_server.joints.stepping.apart import Apart, Made

from .calls import Caller, Calls, filled
from .errors import error_of
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


class Shared:
    """Steps of a world whose physics the crew makes, and all else Python."""

    def __init__(self, place: int, caller: Caller, lent: Lent, calls: Calls) -> None:
        self._place, self._caller, self._link, self._calls = place, caller, lent.link, calls
        self._turns, self._alone = lent.turns, lent.alone
        self._world, self._simulation = lent.service.world, lent.service.simulation
        self._controllers = lent.service.simulation.joints.controllers
        compiled = crew_form().module
        self._of_steps = (
            (compiled.RATE, compiled.VELOCITY, compiled.ANGULAR_VELOCITY) if compiled is not None else ()
        )
        """Reads that compiled code can only make if it makes all of the steps."""

        self._apart: Course | None = None
        self._apart_of: tuple[object, int] = None, -1
        """The physics steps of that course, and the version of the model."""

        self._writes_apart: Sequence[Write] = ()
        self._are_written = self._are_read = False
        """Whether that course can make the writes and the reads of the plan."""

    @property
    def seconds(self) -> float:
        """Return how long the physics of the last simulation step took; 0 before the first."""
        return 0.0 if self._apart is None else self._apart.seconds

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
                    answer = yield from self._alone.step_apart(self._caller.trigger)
                else:  # the run has ended
                    answer = self._caller.answer(self._caller.trigger, [])
                refusals += self._caller.trigger_refused(answer)
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
        step = self._controllers.stepper.compiled
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
        return (
            Made(course.made, course.warnings)
            if course.outcome == compiled.WELL
            else error_of(course, self._simulation.data)
        )

    def _write(self, values: Rows) -> list[Refusal]:
        course = self._present()
        if course is not None and self._are_written and course.write(values):
            for write, number in zip(self._writes_apart, values.tolist(), strict=False):
                write.note(single(number))
            return []
        refusals: list[Refusal] = []
        for command, arguments in filled(self._calls.writes, values.tolist()):
            refusals += self._caller.refused(
                command, arguments, self._caller.answer(self._caller.direct(command), arguments)
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
            call = self._caller.direct(command)
            answer = self._caller.answer(call, arguments)
            refused = self._caller.refused(command, arguments, answer)
            numbers = None if refused else numbers_of(call.received(answer[1]))
            if refused or numbers is None:
                refusals += refused
            else:
                found += numbers
        if not refusals:
            results[: len(found)] = found
        return refusals

    def read(self, results: Rows) -> None:
        """Read the state outside of a step. Within no turn.

        Raises:
            ConnectionFailed: a read was refused.
        """
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
                call = self._caller.direct(command)
                answer = self._caller.answer(call, arguments)
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


_NONE = np.zeros(0)
