"""docs/grading.md: its tables have every function and form of checks, and its task is one."""

from __future__ import annotations

import re
from pathlib import Path

from simx_server.grading.checks.expression import FUNCTIONS
from simx_server.grading.checks.timing import FORMS, parse_timed
from simx_server.grading.task.task import read_task

ROOT = Path(__file__).parents[3]
PAGE = (ROOT / "docs" / "grading.md").read_text(encoding="utf-8")


def test_the_table_has_every_function() -> None:
    table = PAGE.partition("| function | value |")[2].partition("\n\n")[0]
    assert set(re.findall(r"`(\w+)\(", table)) == set(FUNCTIONS)
    for form in re.findall(r"`(\w+\(.*?\))`", table):
        assert form in {each.form for each in FUNCTIONS.values()}


def test_each_form_of_a_check_can_be_read() -> None:
    for form, _ in FORMS:
        assert parse_timed(form.replace("EXPRESSION", "time > 1")).text
    table = PAGE.partition("| form | true |")[2].partition("\n\n")[0]
    forms = re.findall(r"`([^`]*E[^`]*)`", table)
    assert len(forms) == len(FORMS)
    for form in forms:
        assert parse_timed(form.replace("E", "time > 1")).text


def test_the_task_of_the_page_can_be_read(tmp_path: Path) -> None:
    (text,) = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)
    (tmp_path / "task.toml").write_text(text)
    task = read_task(tmp_path / "task.toml")
    assert (task.points, task.seeds, task.setting.rules.hides) == (3.0, 3, ("observer",))


def test_each_exercise_has_its_points_and_scene_on_its_pages() -> None:
    shown = (ROOT / "examples" / "exercises" / "README.md").read_text(encoding="utf-8")
    found = re.findall(r"^\| \[`(\w+)`\].*\| (\d+) \|$", shown, re.MULTILINE)
    assert len(found) == 5
    for name, points in found:
        folder = ROOT / "examples" / "exercises" / name
        task = read_task(folder / "task.toml")
        page = (folder / "README.md").read_text(encoding="utf-8")
        assert task.points == int(points)
        assert page.startswith(f"# {task.title}\n")
        assert f"Scene: `{Path(task.setting.scene).stem}`" in page
