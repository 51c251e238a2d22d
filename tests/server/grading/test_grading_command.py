"""``simx grade``: points of a recording, reports of courses' systems, exit codes."""

from __future__ import annotations

import base64
import json
import sys
from pathlib import Path

import pytest

from simx_client.client import Client
from simx_server.grading.attempt.attempt import Attempt
from simx_server.grading.command import MISSED, main, make_parser
from simx_server.grading.grading import GradingFailed, Result, grade, grade_recording
from simx_server.grading.referee import Judgement
from simx_server.grading.reports import as_gradescope, lines_of_attempt, summary
from simx_server.grading.task.task import read_task

TASK = """\
title = "Push the cart"
scene = "cart_pole"
[limits]
simulation = {seconds}
[[check]]
name = "moves"
points = 2
check = 'travelled("cart") > 0.05'
[[check]]
name = "flies"
check = 'z("cart") > 5'
hint = "It cannot."
[[check]]
name = "says so"
check = 'signal("done") == 3 and is_set("done") at end'
"""


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A second of a pushed cart; then a second run, which does not count."""
    path = tmp_path_factory.mktemp("recordings") / "seed-1.simxlog"
    with Client.embedded("cart_pole", record=path) as client:
        for run in range(2):
            with client.stepping() as step:
                client.joint("action").max_force = 10
                client.joint("action").target_velocity = 9
                for _ in range(20):
                    step()
                client.signals.ints["done"] = 3 if run == 0 else 4
                step()
    return path


@pytest.fixture
def task(tmp_path: Path) -> Path:
    path = tmp_path / "task.toml"
    path.write_text(TASK.format(seconds=10))
    return path


def test_points_come_from_the_first_run_of_a_recording(task: Path, recording: Path) -> None:
    found = grade_recording(task, recording)
    met = [each.is_met for each in found.results[0].judgement.decisions]
    assert met == [True, False, True]
    assert (found.points, found.task.points, found.is_full) == (3.0, 4.0, False)


def test_what_comes_after_the_time_limit_does_not_count(task: Path, recording: Path) -> None:
    task.write_text(TASK.format(seconds=0.1))
    judgement = grade_recording(task, recording).results[0].judgement
    assert judgement.seconds == pytest.approx(0.1)
    assert not judgement.decisions[2].is_met  # the signal is set later


def test_a_check_without_points_is_reported_as_missed(task: Path, recording: Path) -> None:
    task.write_text(TASK.format(seconds=10).replace('name = "flies"', 'name = "flies"\npoints = 0'))
    found = grade_recording(task, recording)
    assert [each["status"] for each in as_gradescope(found)["tests"]] == ["passed", "failed", "passed"]
    assert any("It cannot." in line for line in summary(found))


def test_output_of_a_program_controls_no_terminal_and_no_workflow(recording: Path) -> None:
    output = "\x1b[2Jgone\n::set-output name=result::all points\n"
    attempt = Attempt(recording, output, "it ended with exit code 1", "", {}, 1.0)
    result = Result(1, attempt, Judgement((), 0.0))
    shown = list(lines_of_attempt((), result))
    assert shown[-2:] == ["    | \\x1b[2Jgone", "    | ::set-output name=result::all points"]


def test_a_film_that_cannot_be_made_is_not_a_missed_check(
    task: Path, recording: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "av", None)  # the extra is not installed
    with pytest.raises(GradingFailed, match="video"):
        grade_recording(task, recording, folder=tmp_path, films=True)


def test_less_than_one_attempt_is_refused(task: Path) -> None:
    (task.parent / "program.py").write_text("")
    with pytest.raises(ValueError, match="from 1 on, not 0"):
        grade(task, task.parent / "program.py", seeds=0)


def test_a_recording_is_filmed(task: Path, recording: Path, tmp_path: Path) -> None:
    pytest.importorskip("av")
    found = grade_recording(task, recording, folder=tmp_path, films=True)
    film = found.results[0].film
    assert film is not None
    assert film.stat().st_size > 1000


def test_the_command_prints_points_and_writes_reports(
    task: Path,
    recording: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    variables, scope = tmp_path / "output", tmp_path / "scope" / "results.json"
    monkeypatch.setenv("GITHUB_OUTPUT", str(variables))
    given = [str(task), "--recording", str(recording), "--output", str(tmp_path / "kept"), "--github"]
    assert main([*given, "--gradescope", str(scope)]) == MISSED
    said = capsys.readouterr().out
    assert "2.00 of 2  moves" in said
    assert "It cannot." in said
    assert "3.00 of 4  Push the cart" in said
    record = json.loads((tmp_path / "kept" / "results.json").read_text())
    assert (record["points"], record["attempts"][0]["checks"][0]["met"]) == (3.0, True)
    read = json.loads(scope.read_text())
    assert read["score"] == 3.0
    assert [each["status"] for each in read["tests"]] == ["passed", "failed", "passed"]
    assert sum(each["max_score"] for each in read["tests"]) == 4.0
    name, _, value = variables.read_text().strip().partition("=")
    result = json.loads(base64.b64decode(value))
    assert (name, result["status"], result["max_score"]) == ("result", "fail", 4.0)
    assert sum(each["score"] for each in result["tests"]) == 3.0


def test_json_is_one_line_and_all_points_are_exit_code_0(
    task: Path, recording: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    task.write_text(TASK.format(seconds=10).replace("> 5", "< 5"))
    assert main([str(task), "--recording", str(recording), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["points"] == 4.0


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ([], "name a PROGRAM"),
        (["a.py", "--recording", "b"], "name a PROGRAM, or a recording"),
        (["a.py", "--film"], "--output DIR"),
        (["a.py", "--seeds", "0"], "valid: 1 to 100"),
        (["--recording", "b", "--seeds", "2"], "leave out --seeds"),
        (["a.py", "--github"], "GITHUB_OUTPUT"),
    ],
)
def test_wrong_usage_is_told(
    task: Path,
    arguments: list[str],
    said: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.delenv("GITHUB_OUTPUT", raising=False)
    with pytest.raises(SystemExit) as left:
        main([str(task), *arguments])
    assert left.value.code == 2
    assert said in capsys.readouterr().err


@pytest.mark.parametrize(
    ("program", "said"),
    [
        ("none.py", "cannot be read"),
        ("task.toml", "is not a program"),
        (".", "is not a program"),
        ("helper.py", "has the name of a file of the task"),
    ],
)
def test_a_file_that_is_no_program_is_refused(task: Path, program: str, said: str) -> None:
    (task.parent / "helper.py").write_text("")
    task.write_text(
        TASK.format(seconds=10).replace("[[check]]", '[submission]\nfiles = ["helper.py"]\n[[check]]', 1)
    )
    with pytest.raises(GradingFailed, match=said):
        grade(read_task(task), task.parent / program)


def test_links_of_a_student_lead_nowhere(task: Path, recording: Path, tmp_path: Path) -> None:
    (tmp_path / "solution.py").write_text("")
    (tmp_path / "submission.py").symlink_to(tmp_path / "solution.py")
    with pytest.raises(GradingFailed, match="is a link"):
        grade(task, tmp_path / "submission.py")
    mine = tmp_path / "mine"
    mine.write_text("mine")
    (tmp_path / "kept").mkdir()
    (tmp_path / "kept" / "results.json").symlink_to(mine)
    main([str(task), "--recording", str(recording), "--output", str(tmp_path / "kept")])
    assert mine.read_text() == "mine"
    assert json.loads((tmp_path / "kept" / "results.json").read_text())["points"] == 3.0


def test_a_file_that_is_no_recording_is_exit_code_1(task: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(task), "--recording", str(task)]) == 1
    assert "simx grade: " in capsys.readouterr().err


def test_a_recording_of_another_scene_gives_no_points(task: Path, recording: Path) -> None:
    task.write_text('scene = "two_link_arm"\n[[check]]\ncheck = \'never distance("tip", "target") < 0.01\'\n')
    with pytest.raises(GradingFailed, match="is of another scene: no object named 'tip'"):
        grade_recording(task, recording)


def test_a_damaged_recording_gives_no_points_of_its_lost_part(
    task: Path, recording: Path, tmp_path: Path
) -> None:
    cut = tmp_path / "cut.simxlog"
    cut.write_bytes(recording.read_bytes()[:200])
    with pytest.raises(GradingFailed):
        grade_recording(task, cut)


def test_the_help_names_exit_codes() -> None:
    assert "exit codes: 0 all points" in make_parser().format_help()
