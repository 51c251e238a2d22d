"""README and CONTRIBUTING promise only what is there: flags, variables, make targets, files, a program's output."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from launching import simx_run

from simx_client.checking.command import make_parser as make_check_parser
from simx_client.connection.pace import VARIABLE as PACE
from simx_client.launch.run import make_parser as make_run_parser
from simx_client.transport.redirect import VARIABLE as REDIRECT
from simx_server.app.cli import make_parser as make_server_parser
from simx_server.settings.settings import SETTINGS
from simx_server.sim_api.listing.coverage import Support, script_functions

pytestmark = [pytest.mark.slow, pytest.mark.gl]

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def readme() -> str:
    return (ROOT / "README.md").read_text(encoding="utf-8")


def test_every_flag_in_the_readme_exists(readme: str) -> None:
    flags = set(re.findall(r"(?<![\w-])--[a-z][a-z-]+", readme))
    parsers = make_server_parser(), make_run_parser(), make_check_parser()
    known = "".join(parser.format_help() for parser in parsers)
    assert {flag for flag in flags if flag not in known} == set()


def test_every_variable_in_the_readme_exists(readme: str) -> None:
    named = set(re.findall(r"SIMX_[A-Z_]+", readme))
    assert named <= {setting.variable for setting in SETTINGS.values()} | {REDIRECT, PACE}


def test_every_make_target_in_the_readme_exists(readme: str) -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for target in re.findall(r"\bmake ([a-z]+)", readme):
        if f"`make {target}`" in readme or f"    make {target}" in readme:
            assert re.search(rf"^{target}:", makefile, re.MULTILINE), target


def test_the_layout_of_the_code_names_every_folder() -> None:
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    layout = text.partition("## Layout of the code")[2].partition("\n## ")[0]
    for package in ("simx_client", "simx_server"):
        table = layout.partition(f"| folder of `{package}/` |")[2].partition("\n\n")[0]
        named = {
            name
            for row in table.splitlines()
            for name in re.findall(r"`(\w+)/`", row.split("|")[1] if "|" in row else "")
        }
        folders = {path.parent.name for path in (ROOT / package).glob("*/__init__.py")}
        assert named == folders, package
    for name in re.findall(r"`(\w+/)`", layout.rpartition("|")[2]):
        assert (
            (ROOT / name).is_dir() or (ROOT / "tests" / name).is_dir() or (ROOT / "scenes" / name).is_dir()
        ), name


def test_the_program_of_the_readme_prints_what_it_shows(readme: str, tmp_path: Path) -> None:
    program = re.search(r"^```python hello.py\n(.*?)^```$", readme, re.MULTILINE | re.DOTALL)
    shown = re.search(r"^```text simx-run (.*?) hello.py\n(.*?)^```$", readme, re.MULTILINE | re.DOTALL)
    assert program
    assert shown
    finished = simx_run(tmp_path, program[1], flags=tuple(shown[1].split()))
    assert (finished.returncode, finished.stdout) == (0, shown[2]), finished.stderr


def test_the_readme_counts_the_functions_of_scripts(readme: str) -> None:
    full = sum(function.support is Support.FULL for function in script_functions())
    (said,) = re.findall(r"more than (\d+)\s+functions", readme)
    assert int(said) < full < int(said) + 100


def test_the_readme_has_at_most_1200_words(readme: str) -> None:
    assert len(readme.split()) <= 1200
