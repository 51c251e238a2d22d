"""The flags of the editor: what they mean, and where a class has no editor."""

from __future__ import annotations

import logging
from pathlib import Path

import pytest

from simx_server.classroom import command
from simx_server.classroom.editor import flags
from simx_server.classroom.editor.plan import LIMITS, MOST_TEXT, EditorPlan


def plan(folder: Path, *words: object) -> EditorPlan | None:
    options = command.make_parser().parse_args([*map(str, words), "--view-port", "0"])
    return flags.make_plan(options, 3, "127.0.0.1", folder / "programs", folder)


@pytest.fixture(autouse=True)
def confined(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(flags, "lacking", lambda: "")
    monkeypatch.setattr(flags, "missing", lambda: None)


def test_a_class_has_an_editor_and_a_view_for_each_seat(tmp_path: Path) -> None:
    found = plan(tmp_path)
    assert found is not None
    assert (found.name, found.start, found.limits, found.views) == ("program.py", "", LIMITS, 3)
    assert len(set(found.view_ports)) == 3
    assert plan(tmp_path, "--no-editor") is None


def test_without_walls_there_is_no_editor_and_the_log_says_why(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(flags, "lacking", lambda: "this kernel or container has no landlock")
    with caplog.at_level(logging.WARNING):
        assert plan(tmp_path) is None
    assert "nothing would confine the programs: this kernel or container has no landlock" in caplog.text
    with pytest.raises(flags.NoEditor, match="no landlock"):
        plan(tmp_path, "--editor")
    assert plan(tmp_path, "--no-editor") is None


def test_without_the_extra_viewer_there_are_images_only(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(flags, "missing", lambda: "--view needs viser; install with: pip")
    found = plan(tmp_path)
    assert found is not None
    assert (found.views, found.view_ports) == (0, ())
    with pytest.raises(flags.NoEditor, match="--views needs viser"):
        plan(tmp_path, "--views", 2)


def test_program_and_limits_come_from_flags(tmp_path: Path) -> None:
    file = tmp_path / "square.py"
    file.write_text("print('ü')\n", encoding="utf-8")
    found = plan(
        tmp_path,
        "--program",
        file,
        "--program-limit",
        "wall=5",
        "--program-limit",
        "memory=3000",
        "--views",
        1,
    )
    assert found is not None
    assert (found.name, found.start, found.views) == ("square.py", "print('ü')\n", 1)
    assert (found.limits.wall, found.limits.memory, found.limits.disk) == (5, 3000, LIMITS.disk)


@pytest.mark.parametrize(
    "words",
    [
        ("--program", "no_such_file.py"),
        ("--program", "program.txt"),
        ("--program", "latin.py"),
        ("--program", "large.py"),
        ("--program", "with blank.py"),
        ("--program-limit", "wall"),
        ("--program-limit", "wall=0"),
        ("--program-limit", "wall=9999999999"),
        ("--program-limit", "threads=5"),
        ("--program-limit", "disk=x"),
        ("--views", "-1"),
    ],
)
def test_values_that_cannot_be_used_are_refused(
    tmp_path: Path,
    words: tuple[str, str],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("program.txt").touch()
    Path("with blank.py").touch()
    Path("latin.py").write_bytes(b"\xff")
    Path("large.py").write_bytes(b"#" * (MOST_TEXT + 1))
    with pytest.raises(SystemExit):
        command.make_parser().parse_args(list(words))
    assert "valid: " in capsys.readouterr().err
