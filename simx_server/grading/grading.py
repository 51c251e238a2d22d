"""Grade a program on a task: an attempt and a judgement for each seed."""

from __future__ import annotations

import logging
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from simx_server.confined.program import NotConfined

from .attempt.attempt import Attempt, StageFailed, run_attempt
from .referee import Decision, FilmFailed, Judgement, NotGraded, check_names, judge
from .task.reading import TaskError
from .task.task import Task, read_task

logger = logging.getLogger(__name__)

MOST_PROGRAM = 1 << 20
"""Bytes of a program."""


class GradingFailed(Exception):
    """No points can be given, and the program is not the reason; the text gives the reason."""


@dataclass(frozen=True, slots=True)
class Result:
    """One attempt and what it is worth."""

    seed: int | None
    attempt: Attempt | None
    """Both are None where a recording was graded."""

    judgement: Judgement
    film: Path | None = None

    @property
    def name(self) -> str:
        """Return the words for it in reports."""
        return "recording" if self.seed is None else f"seed {self.seed}"


@dataclass(frozen=True, slots=True)
class Grade:
    """The result of a program."""

    task: Task
    program: str
    results: tuple[Result, ...]

    def points_of(self, number: int) -> float:
        """Return the points of a check, by its place in the task: its share of attempts that have met it."""
        met = [each.judgement.decisions[number].is_met for each in self.results]
        return self.task.checks[number].points * sum(met) / len(met)

    def has_met(self, number: int) -> bool:
        """Return whether every attempt has met a check, by its place in the task."""
        return all(each.judgement.decisions[number].is_met for each in self.results)

    @property
    def points(self) -> float:
        """Return the sum of the points."""
        return sum(map(self.points_of, range(len(self.task.checks))))

    @property
    def is_full(self) -> bool:
        """Return whether every attempt has met every check."""
        return all(map(self.has_met, range(len(self.task.checks))))


def grade(
    task: Task | Path | str,
    program: Path | str,
    *,
    seeds: int | None = None,
    folder: Path | None = None,
    films: bool = False,
    told: Callable[[Result], object] = lambda _result: None,
) -> Grade:
    """Run a program on a task, once for each seed, and give points.

    Args:
        task: the task, or its file.
        program: the program's file.
        seeds: number of attempts, with the seeds from 1 on; None: the task's.
        folder: where recordings, films and outputs are kept; None: they are not.
        films: film each attempt; needs a folder and the extra ``video``.
        told: called with each result.

    Raises:
        TaskError: the task cannot be used.
        GradingFailed: nothing can be graded here.
        ValueError: the number of attempts is below 1.
    """
    found = task if isinstance(task, Task) else read_task(Path(task))
    file = Path(program)
    _check_program(file, found)
    if seeds is not None and seeds < 1:
        raise ValueError(f"seeds is a number of attempts from 1 on, not {seeds}")
    check_names(found)
    results: list[Result] = []
    with tempfile.TemporaryDirectory(prefix="simx-grade-") as private:
        kept = Path(private) if folder is None else folder
        kept.mkdir(parents=True, exist_ok=True)
        for seed in range(1, (seeds or found.seeds) + 1):
            place = Path(private) / f"attempt-{seed}"
            place.mkdir(mode=0o700)
            result = _attempt(found, file, seed, kept, place, films=films and folder is not None)
            results.append(result)
            told(result)
    return Grade(found, file.name, tuple(results))


def grade_recording(
    task: Task | Path | str, recording: Path, *, folder: Path | None = None, films: bool = False
) -> Grade:
    """Give points for a recording of an attempt, without the program; see `grade`."""
    found = task if isinstance(task, Task) else read_task(Path(task))
    check_names(found)
    film = _film(folder, recording.stem) if films and folder is not None else None
    try:
        judgement = judge(found, recording, film)
    except NotGraded as problem:
        raise GradingFailed(f"{recording}: {problem}") from None
    except FilmFailed as problem:
        raise GradingFailed(str(problem)) from None
    return Grade(found, recording.name, (Result(None, None, judgement, film),))


def _attempt(task: Task, file: Path, seed: int, kept: Path, private: Path, *, films: bool) -> Result:
    recording = kept / f"seed-{seed}.simxlog"
    recording.unlink(missing_ok=True)
    try:
        attempt = run_attempt(task.setting, file, seed, recording, private)
    except (StageFailed, NotConfined) as problem:
        raise GradingFailed(str(problem)) from None
    write_new(kept / f"seed-{seed}.txt", attempt.output)
    film = _film(kept, f"seed-{seed}") if films else None
    try:
        judgement = judge(task, recording, film)
    except NotGraded as problem:
        logger.warning("seed %d: %s", seed, problem)
        judgement = Judgement(tuple(Decision(False, str(problem)) for _ in task.checks), 0.0)
    except FilmFailed as problem:
        raise GradingFailed(str(problem)) from None
    return Result(seed, attempt, judgement, film)


def write_new(path: Path, text: str) -> None:
    """Write a file in place of one that is there: a link in a student's folder would lead anywhere."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.unlink(missing_ok=True)
    path.write_text(text, encoding="utf-8")


def _film(folder: Path | None, name: str) -> Path | None:
    if folder is None:
        return None
    film = folder / f"{name}.mp4"
    film.unlink(missing_ok=True)
    return film


def _check_program(file: Path, task: Task) -> None:
    """Raise GradingFailed for a file that cannot be a program of a task."""
    if file.is_symlink():  # such as one to a solution
        raise GradingFailed(f"{file} is a link; give the program itself")
    try:
        size = file.stat().st_size
    except OSError as problem:
        raise GradingFailed(f"{file} cannot be read: {problem.strerror}") from None
    if not file.is_file() or file.suffix != ".py" or size > MOST_PROGRAM:
        raise GradingFailed(
            f"{file} is not a program; valid is a Python file of at most {MOST_PROGRAM} bytes"
        )
    if file.name in (each.name for each in task.setting.files):
        raise GradingFailed(f"{file} has the name of a file of the task; give it another name")


__all__ = ["Grade", "GradingFailed", "TaskError", "grade", "grade_recording"]
