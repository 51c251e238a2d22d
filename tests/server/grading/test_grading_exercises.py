"""The exercises that ship: each solution gets all points, each starter does not."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from simx_server.grading.grading import grade
from simx_server.grading.task.task import read_task

pytestmark = [pytest.mark.slow, pytest.mark.system, pytest.mark.timeout(400)]

if sys.platform != "linux":
    pytest.skip("programs are confined on Linux only", allow_module_level=True)

EXERCISES = Path(__file__).parents[3] / "examples" / "exercises"
NAMES = sorted(each.parent.name for each in EXERCISES.glob("*/task.toml"))


def test_five_exercises_ship() -> None:
    assert NAMES == ["camera_calibration", "line_follower", "obstacle_course", "pick_and_place", "reach"]


@pytest.mark.parametrize("name", NAMES)
def test_a_solution_gets_all_points(name: str) -> None:
    found = grade(EXERCISES / name / "task.toml", EXERCISES / name / "solution.py", seeds=1)
    (result,) = found.results
    assert result.attempt is not None
    assert found.is_full, (result.judgement, result.attempt.output, result.attempt.ended)
    assert found.points == found.task.points
    assert not result.attempt.ended


@pytest.mark.parametrize("name", NAMES)
def test_a_starter_runs_and_gets_less(name: str) -> None:
    found = grade(EXERCISES / name / "task.toml", EXERCISES / name / "starter.py", seeds=1)
    (result,) = found.results
    assert result.attempt is not None
    assert found.points < found.task.points
    assert not result.attempt.ended, result.attempt.output
    assert result.judgement.seconds > 0


@pytest.mark.parametrize("name", NAMES)
def test_a_task_reads(name: str) -> None:
    assert read_task(EXERCISES / name / "task.toml").points >= 4
