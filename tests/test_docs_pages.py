"""The pages of docs/ say what is so: their files, programs and outputs are tried, their links lead somewhere."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from processes import ROOT

from simx_client.checking import command as check
from simx_server import cli

DOCS = ROOT / "docs"
BLOCK = re.compile(r"^```(\w+)(?: ([^\n]+))?\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def page(name: str) -> str:
    return (DOCS / name).read_text(encoding="utf-8")


def blocks(name: str) -> list[tuple[str, str, str]]:
    """Language, the rest of the opening line, text."""
    return BLOCK.findall(page(name))


# --- porting -------------------------------------------------------------------------------------


@pytest.fixture
def ported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, str]:
    """The page's files lie in the present folder; what it shows as printed, per command line."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MUJOCO_GL", "disable")
    printed: dict[str, str] = {}
    for language, title, text in blocks("porting.md"):
        if language == "text":
            printed[title] = text
        else:
            Path(title).write_text(text, encoding="utf-8")
    return printed


def test_porting_page_prints_what_the_programs_print(
    ported: dict[str, str], capsys: pytest.CaptureFixture[str]
) -> None:
    mains = {"simx-check": check.main, "simx-server": cli.main}
    tried = 0
    for line, shown in ported.items():
        program, *arguments = shlex.split(line)
        if program in mains:
            assert mains[program](arguments) == 0
            assert shown in capsys.readouterr().out, line
            tried += 1
    assert tried == 3


def test_porting_page_program_runs_unchanged_on_its_scene(ported: dict[str, str]) -> None:
    (line,) = [line for line in ported if line.startswith("simx-run ")]
    done = subprocess.run(
        [sys.executable, "-m", "simx_client", "run", *shlex.split(line)[1:]],
        capture_output=True, text=True, timeout=60, env=os.environ | {"PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert (done.returncode, done.stdout) == (0, ported[line]), done.stderr


def test_porting_page_what_is_missing_is_a_problem(
    ported: dict[str, str], capsys: pytest.CaptureFixture[str]
) -> None:
    scene = Path("car.xml").read_text(encoding="utf-8")
    Path("car.xml").write_text(scene.replace('"leftMotor"', '"motorLeft"'), encoding="utf-8")
    assert check.main(["drive.py", "--scene", "car.xml"]) == 1
    assert "problem: no object 'leftMotor' in car" in capsys.readouterr().out
