"""V-REP's own files on the command line: what is in them, what the import changed, and how to edit them."""

from __future__ import annotations

import json
import logging
from pathlib import Path

import pytest
from vrep_writer import VrepWriter

from simx_server.app import cli, import_report
from simx_server.app.rehearsal import Rehearsal
from simx_server.sensors.opengl.early_probe import may_have_cameras

pytestmark = pytest.mark.system


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """A table with a mill on it, whose script calls what does not exist."""
    writer = VrepWriter(21)
    table = writer.shape("table", cuboid=(1, 1, 0.1), acknowledgement="table by A. Maker")
    writer.mill("mill", parent=table)
    writer.script("function sysCall_init() simNothing.atAll() end", table)
    writer.settings()
    path = tmp_path / "my lab.ttt"
    path.write_bytes(writer.bytes())
    return path


def test_tree_lists_the_objects(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([str(file), "--tree", "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["scene"] == "my lab"
    assert [each["name"] for each in record["objects"]] == ["table", "mill"]


def test_name_without_ending_is_enough(
    file: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(file.parent)
    assert cli.main(["my lab", "--tree"]) == 0
    assert capsys.readouterr().out.startswith("my lab: 2 objects")


def test_report_is_for_people_and_for_programs(
    file: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(import_report, "rehearse", lambda *_: Rehearsal())  # a process; see test_rehearsal.py
    assert cli.main([str(file), "--import-report"]) == 0
    text = capsys.readouterr().out
    assert text.startswith("my lab.ttt, saved by version 3.5.0: ")
    assert cli.main([str(file), "--import-report", "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["objects"]["shape"] == 1
    assert record["version"] == "3.5.0"


@pytest.mark.parametrize("flag", ["--import-report", "--convert"])
def test_other_formats_have_nothing_to_report_or_convert(
    flag: str, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "plain.xml").write_text("<mujoco/>")
    rest = [] if flag == "--import-report" else [str(tmp_path / "out")]
    assert cli.main([str(tmp_path / "plain.xml"), flag, *rest]) == 1
    assert "is not a V-REP file" in caplog.text


def test_folder_is_written_once_and_opens(
    file: Path, caplog: pytest.LogCaptureFixture, capsys: pytest.CaptureFixture[str]
) -> None:
    out = file.parent / "out"
    assert cli.main([str(file), "--convert", str(out)]) == 0
    assert cli.main([str(out / "my_lab.xml"), "--tree", "--json"]) == 0
    assert [each["name"] for each in json.loads(capsys.readouterr().out)["objects"]] == ["table", "mill"]
    assert cli.main([str(file), "--convert", str(out)]) == 1
    assert "already, which may have been edited" in caplog.text


@pytest.mark.parametrize(
    "flags", [["--speed", "2"], ["--save-mjcf", "x.xml"], ["--start"], ["--record", "r"]]
)
def test_settings_without_a_meaning_beside_convert_are_refused(
    file: Path, flags: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(file.parent)
    with pytest.raises(SystemExit) as left:
        cli.main([str(file), "--convert", "out", *flags])
    assert left.value.code == 2
    assert "valid: one of both" in capsys.readouterr().err


def test_one_mjcf_file_cannot_hold_it_and_the_message_names_the_other_flag(
    file: Path, caplog: pytest.LogCaptureFixture
) -> None:
    assert cli.main([str(file), "--save-mjcf", str(file.with_suffix(".xml"))]) == 1
    assert "--convert FOLDER" in caplog.text
    assert not file.with_suffix(".xml").exists()


def test_cut_file_is_a_failure_with_its_name(file: Path, caplog: pytest.LogCaptureFixture) -> None:
    file.write_bytes(file.read_bytes()[:-40])
    with caplog.at_level(logging.ERROR):
        assert cli.main([str(file), "--tree"]) == 1
    assert "'my lab.ttt' cannot be read" in caplog.text


def test_images_are_expected_of_a_file_that_is_not_decoded_yet(file: Path) -> None:
    assert may_have_cameras(file)
