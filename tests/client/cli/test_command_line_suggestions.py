"""A misspelt word on a command line: every program names what may have been meant. And ``--version``."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from processes import ROOT

from bench import __main__ as bench
from simx_client import __main__ as simx
from simx_client.checking import command as check
from simx_client.launch import run
from simx_client.protocol.nearest import did_you_mean, file_like, nearest
from simx_client.protocol.version import __version__
from simx_server.app import cli
from simx_server.errors import CommandError
from simx_server.files.library import find_scene
from simx_server.viewer.page import command as view

PROGRAMS = {
    "simx-server": cli.main,
    "simx": simx.main,
    "simx-run": run.main,
    "simx-check": check.main,
    "python -m simx_server.viewer": view.main,
    "python -m bench": bench.main,
}


def refused(name: str, words: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    with pytest.raises(SystemExit) as left:
        PROGRAMS[name](words)
    assert left.value.code == 2
    return capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "words", "meant"),
    [
        ("simx-server", ["--realn", "x"], "--realm"),
        ("simx-server", ["scene.xml", "--realn=x"], "--realm"),
        ("simx-server", ["--temp", "1"], "--temporary-port"),
        ("simx-server", ["-port", "0"], "--port"),
        ("simx-server", ["--log-level", "infoo"], "info"),
        ("simx-server", ["--limit", "object=500"], "objects"),
        ("simx", ["lsit"], "list"),
        ("simx", ["call", "--jsn", "simxGetObjects", "1"], "--json"),
        ("simx", ["image", "--dpth"], "--depth"),
        ("simx", ["completion", "bsh"], "bash"),
        ("simx-run", ["--plian"], "--plain"),
        ("simx-run", ["--server", "scene.xml", "--plian", "script.py"], "--plain"),
        ("simx-check", ["--scnee", "room.xml", "script.py"], "--scene"),
        ("python -m simx_server.viewer", ["--log-levl", "info"], "--log-level"),
        ("python -m simx_server.viewer", ["--log-level", "eror"], "error"),
        ("python -m bench", ["blokcing"], "blocking"),
    ],
)
def test_misspelt_word_suggests_the_nearest(
    name: str, words: list[str], meant: str, capsys: pytest.CaptureFixture[str]
) -> None:
    said = refused(name, words, capsys)
    assert f"did you mean '{meant}'?" in said
    assert said.count("did you mean") == 1


def test_wrong_number_after_a_right_name_suggests_no_name(capsys: pytest.CaptureFixture[str]) -> None:
    assert "did you mean" not in refused("simx-server", ["--limit", "objects=many"], capsys)


def test_misspelt_variable_value_suggests_the_nearest(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("SIMX_LOG_FORMAT", "jsn")
    assert "environment SIMX_LOG_FORMAT: 'jsn' cannot be used; did you mean 'json'?" in refused(
        "simx-server", [], capsys
    )


def test_flags_of_the_script_are_no_misspelt_flags_of_simx_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "script.py").write_text("import json, sys\nprint(json.dumps(sys.argv[1:]))")
    script = str(tmp_path / "script.py")
    done = subprocess.run(
        [sys.executable, "-m", "simx_client.launch.run", script, "--plian", "-verbose"],
        capture_output=True, text=True, cwd=ROOT, check=True,
    )  # fmt: skip
    assert json.loads(done.stdout) == ["--plian", "-verbose"]
    said = refused("simx-run", ["--server-timeout", "soon", script, "--plian"], capsys)
    assert "did you mean" not in said


def test_function_that_is_not_there_suggests_the_nearest(capsys: pytest.CaptureFixture[str]) -> None:
    assert simx.main(["call", "simxGetJointPositon", "1"]) == 2
    assert "did you mean 'simxGetJointPosition'" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["pionner_p3dx", "pionner_p3dx.ttt", "Pioneer"])
def test_scene_that_is_not_there_suggests_a_shipped_one(name: str) -> None:
    with pytest.raises(CommandError, match=r"did you mean 'pioneer_p3dx'\? "):
        find_scene(name)


def test_scene_that_is_not_there_suggests_a_file_beside_it(tmp_path: Path) -> None:
    (tmp_path / "my_robot.xml").touch()
    (tmp_path / "my_robto.txt").touch()
    with pytest.raises(CommandError, match=r"did you mean 'my_robot\.xml'"):
        find_scene(tmp_path / "my_robto.xml")


@pytest.mark.parametrize(("name", "code"), [("simx-run", 2), ("simx-check", 2)])
def test_script_that_is_not_there_suggests_a_file_beside_it(
    name: str, code: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "robotControl.py").touch()
    assert PROGRAMS[name]([str(tmp_path / "robotControll.py")]) == code
    assert "did you mean 'robotControl.py'? name the script" in capsys.readouterr().err


def test_what_is_far_from_everything_gets_no_suggestion() -> None:
    assert nearest("--fullscreen", ["--port", "--speed"]) == []
    assert did_you_mean("x" * 1_000_000, ["x" * 199]) == ""
    assert nearest("LIST", ["list", "lists"]) == ["list"]
    assert file_like("no/such/folder/file.py") == ""
    assert file_like("nul\0/file.py") == ""


@pytest.mark.parametrize("name", PROGRAMS)
def test_version_of_every_program(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        PROGRAMS[name](["--version"])
    assert left.value.code == 0
    program, number = capsys.readouterr().out.split(" (")[0].strip().rsplit(" ", 1)
    assert number == __version__
    assert program in (name, "python -m simx_client")


def test_simx_alone_prints_its_help(capsys: pytest.CaptureFixture[str]) -> None:
    assert simx.main([]) == 2
    alone = capsys.readouterr().out
    assert "  watch  " in alone
    for words in (["--help"], ["help"]):
        with pytest.raises(SystemExit) as left:
            simx.main(words)
        assert left.value.code == 0
        assert capsys.readouterr().out == alone


def test_help_of_a_command_is_asked_for_in_two_ways(capsys: pytest.CaptureFixture[str]) -> None:
    texts: list[str] = []
    for words in (["watch", "--help"], ["help", "watch"]):
        with pytest.raises(SystemExit):
            simx.main(words)
        texts.append(capsys.readouterr().out)
    assert texts[0] == texts[1] != ""
