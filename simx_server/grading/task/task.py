"""A task: its scene, limits, rules, random values and checks."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from simx_client.protocol.commands import BY_NAME
from simx_server.confined.program import ProgramLimits
from simx_server.errors import CommandError
from simx_server.files.library import find_scene
from simx_server.grading.attempt.attempt import Setting
from simx_server.grading.attempt.rules import Rules, allowable
from simx_server.grading.checks.expression import ExpressionError
from simx_server.grading.checks.timing import Timed, parse_timed
from simx_server.settings.rules import SPEED

from .random import read_value
from .reading import Table, TaskError, TaskFile

MOST_SEEDS = 100
MOST_CHECKS = 100


@dataclass(frozen=True, slots=True)
class Check:
    """A check, and the points that it gives."""

    name: str
    points: float
    timed: Timed
    hint: str = ""
    """Told when it is not met."""


@dataclass(frozen=True, slots=True)
class Task:
    """A task as its file describes it."""

    file: TaskFile
    """For messages with lines."""

    title: str
    setting: Setting
    checks: tuple[Check, ...]
    seeds: int = 1
    camera: str | None = None
    """Of the film; None for the overview."""

    @property
    def points(self) -> float:
        """Return the points of all checks."""
        return sum(each.points for each in self.checks)


def read_task(path: Path) -> Task:
    """Read a task. Raises TaskError."""
    file = TaskFile(path)
    table = Table(file, file.values)
    title = table.text("title", path.resolve().parent.name, 200)
    scene = _scene(table, path)
    seeds = table.whole("seeds", 1, 1, MOST_SEEDS)
    camera = table.text("camera", None, 200)
    speed = _speed(table)
    time_step = table.number("time_step", None, 0.001, 1.0, "s")
    limits, rules = _limits(table.table("limits")), table.table("submission")
    files = _files(rules, path)
    random = _random(table.table("randomize"))
    checks = tuple(map(_check, table.tables("check")))
    if not 1 <= len(checks) <= MOST_CHECKS:
        table.fail("check", f"a task has from 1 to {MOST_CHECKS} checks: write [[check]] before each")
    table.end()
    setting = Setting(scene, _rules(rules, limits[0]), limits[1], speed, time_step, random, files)
    return Task(file, title, setting, checks, seeds, camera)


def _scene(table: Table, path: Path) -> str:
    """Return the path of the scene: a file beside the task, or a shipped one."""
    scene = table.text("scene")
    beside = path.resolve().parent / scene
    if beside.is_file():
        return str(beside)
    try:
        return str(find_scene(scene))
    except CommandError as problem:
        table.fail("scene", str(problem))


def _speed(table: Table) -> str:
    """Return the speed as a setting of the server has it."""
    speed = str(table.take("speed", "1"))
    try:
        SPEED.parse(speed)
    except ValueError:
        table.fail("speed", f"valid is {SPEED.valid}, not {speed!r:.80}")
    return speed


def _limits(table: Table) -> tuple[float, ProgramLimits]:
    first = ProgramLimits()
    seconds = table.number("simulation", 60.0, 0.1, 3600.0, "s")
    wall = table.number("wall", max(first.wall, 2 * seconds), 1.0, 86_400.0, "s")
    limits = ProgramLimits(
        wall=wall,
        processor=table.number("processor", wall, 1.0, 86_400.0, "s"),
        memory=table.whole("memory", first.memory, 500, 1_000_000),
        disk=table.whole("disk", first.disk, 1, 100_000),
    )
    table.end()
    return seconds, limits


def _random(table: Table) -> dict[str, Any]:
    """Return what is random as the file has it: the server of an attempt draws it."""
    found = dict(table.items())
    for name, described in found.items():
        try:
            read_value(name, described)
        except ValueError as problem:
            table.fail(name, str(problem))
    return found


def _rules(table: Table, seconds: float) -> Rules:
    rules = Rules(
        # A function that has two names is one function.
        allows=frozenset(BY_NAME[name].name for name in table.texts("allows", allowable())),
        forbids=frozenset(BY_NAME[name].name for name in table.texts("forbids", BY_NAME)),
        moves=table.texts("moves"),
        hides=table.texts("hides"),
        seconds=seconds,
    )
    table.end()
    return rules


def _files(table: Table, path: Path) -> tuple[Path, ...]:
    found: list[Path] = []
    for name in table.texts("files"):
        file = path.resolve().parent / name
        if not file.is_file():
            table.fail("files", f"there is no file {str(file)!r}; name files beside the task")
        found.append(file)
    return tuple(found)


def _check(table: Table) -> Check:
    text = table.text("check")
    try:
        timed = parse_timed(text)
    except ExpressionError as problem:
        table.fail("check", str(problem))
    check = Check(
        name=table.text("name", text, 200),
        points=table.number("points", 1.0, 0.0, 1_000_000.0),
        timed=timed,
        hint=table.text("hint", ""),
    )
    table.end()
    return check


__all__ = ["Check", "Task", "TaskError", "read_task"]
