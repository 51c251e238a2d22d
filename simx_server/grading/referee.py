"""Decide the checks of a task from the recording of an attempt, and film it.

The recording is replayed here, where no program takes part: a replay repeats the run bit for bit and fails where it
does not, so points come from what the simulation did, and anybody can give them again.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from simx_server.app.server import attach_outputs, open_world
from simx_server.errors import CommandError, StartError
from simx_server.handlers.numbers import write_numbers
from simx_server.outputs.filming.shot import Shot
from simx_server.recording.log_file import LogReader
from simx_server.recording.opened import Opened
from simx_server.recording.replayed import Divergence
from simx_server.recording.replaying import replay
from simx_server.service.watcher import Watcher
from simx_server.settings.settings import Settings

from .attempt.random_values import draw
from .attempt.rules import Supervision
from .checks.sight import WorldSight
from .checks.timing import Verdict
from .task.task import Task

if TYPE_CHECKING:
    from simx_server.service.service import Service
    from simx_server.world.world import World


class NotGraded(Exception):
    """A recording from which no points can be given; the text gives the reason."""


class FilmFailed(Exception):
    """No film can be made here, which says nothing about the recording; the text gives the reason."""


@dataclass(frozen=True, slots=True)
class Decision:
    """A check of one attempt."""

    is_met: bool
    reason: str


@dataclass(frozen=True, slots=True)
class Judgement:
    """All checks of one attempt, in the order of the task."""

    decisions: tuple[Decision, ...]
    seconds: float
    """Simulated seconds of the run."""


class Referee(Watcher):
    """Looks at the state after each step of the first run."""

    def __init__(self, task: Task, world: World) -> None:
        self._world, self._sight = world, WorldSight(world)
        self._limit = task.setting.rules.seconds
        self._checks = task.checks
        self._verdicts = [Verdict(each.timed) for each in task.checks]
        self._is_done = False
        self.seconds = 0.0

    def run_started(self) -> None:
        if not self._is_done:
            self._sight.look()
            for each in self._checks:  # functions that count start here
                each.timed.expression.evaluate(self._sight)

    def step_finished(self) -> None:
        if self._is_done:
            return
        self._sight.look()
        self.seconds = self._sight.time
        for each in self._verdicts:
            each.update(self._sight)
        self._is_done = self.seconds >= self._limit - self._world.simulation.time_step / 2

    def run_ending(self) -> None:
        self._is_done = True

    def judgement(self) -> Judgement:
        """Return the decisions at the end."""
        return Judgement(tuple(Decision(each.is_met, str(each)) for each in self._verdicts), self.seconds)


def check_names(task: Task) -> None:
    """Open the scene of a task, and find everything that the task names. Raises TaskError, with the line."""
    with ExitStack() as stack:
        try:
            world = open_world(Settings(scene=task.setting.scene), stack)
        except (CommandError, StartError) as problem:
            task.file.fail("", 0, "scene", str(problem))
        for table, number, key, find in _names(task, world):
            try:
                find()
            except (CommandError, ValueError) as problem:
                task.file.fail(table, number, key, str(problem))


def _names(task: Task, world: World) -> Iterator[tuple[str, int, str, Callable[[], object]]]:
    """Yield table, its number, key, and how to find what the key names."""
    rules, resolve = task.setting.rules, world.simulation.scene.resolve
    yield "", 0, "camera", partial(Shot, world, task.camera)
    for key, names in (("moves", rules.moves), ("hides", rules.hides)):
        yield from (("submission", 0, key, partial(resolve, name)) for name in names)
    sight = WorldSight(world, is_strict=True)
    sight.look()
    for number, check in enumerate(task.checks):
        yield "check", number, "check", partial(check.timed.expression.evaluate, sight)
    for name, described in task.setting.random.items():
        yield "randomize", 0, name, partial(_set_random, world, name, described)


def _set_random(world: World, name: str, described: Any) -> None:
    write_numbers(world, *draw(world, name, described, np.random.default_rng(1)))


def judge(task: Task, recording: Path, film: Path | None = None) -> Judgement:
    """Replay a recording and decide the checks.

    Args:
        film: a file to write; None: none.

    Raises:
        NotGraded: the recording cannot be used, or does not replay.
        FilmFailed: the film cannot be made.
    """
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="simx-grade-")))
        try:
            opened = Opened(LogReader(recording), folder)
            settings = opened.settings(Settings())
            world = open_world(settings, stack, lambda world, _: opened.attach(world))
            outputs = Settings(video=film, camera=task.camera, size=(640, 360))
            _check_scene(task, world)
            _film(world, outputs, stack, opened.began)
            referee = Referee(task, world)

            def attach(service: Service) -> None:
                service.watchers.add(Supervision(task.setting.rules, world.simulation), referee)

            replay(opened, world, settings.history, attach=attach)
        except Divergence as problem:
            raise NotGraded(f"the recording does not replay: {problem}") from None
        except (CommandError, StartError) as problem:
            raise NotGraded(str(problem)) from None
        return referee.judgement()


def _check_scene(task: Task, world: World) -> None:
    """Raise NotGraded unless the world of a recording has all that the checks name."""
    sight = WorldSight(world, is_strict=True)
    sight.look()
    for check in task.checks:
        try:
            check.timed.expression.evaluate(sight)
        except CommandError as problem:
            raise NotGraded(f"the recording is of another scene: {problem}") from None


def _film(world: World, outputs: Settings, stack: ExitStack, began: int) -> None:
    """Attach the film. Raises FilmFailed."""
    try:
        attach_outputs(world, outputs, stack, began)
    except (CommandError, StartError) as problem:
        raise FilmFailed(str(problem)) from None
