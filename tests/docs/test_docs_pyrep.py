"""The page of PyRep's C functions is what the stand-in and its tests say now; every function has a test."""

from __future__ import annotations

import re
import subprocess
import sys
from importlib.util import module_from_spec, spec_from_file_location
from types import ModuleType

import pytest
from processes import ROOT

from simx_client.launch import run
from simx_client.launch.pyrep import SWITCH
from simx_client.pyrep.library import Library, function_names
from simx_client.pyrep.worlds import ARGUMENTS
from simx_server.app.cli import make_parser

PAGE = (ROOT / "docs" / "pyrep-functions.md").read_text(encoding="utf-8")
GUIDE = (ROOT / "docs" / "pyrep.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def generator() -> ModuleType:
    spec = spec_from_file_location("pyrep_reference", ROOT / "docs" / "pyrep_reference.py")
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_page_is_fresh() -> None:
    done = subprocess.run(
        [sys.executable, "docs/pyrep_reference.py"], cwd=ROOT, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout == PAGE, "make generate writes the page"


def test_every_function_has_a_test(generator: ModuleType) -> None:
    assert not list(generator.untested())


def test_a_row_names_the_function_below_and_a_test_that_is_there() -> None:
    rows = re.findall(r"^\|`(\w+)`\|(.*)\|(.*)\|$", PAGE, re.MULTILINE)
    assert {name for name, _, _ in rows} == function_names()
    served = {name: by for name, by, _ in rows}
    assert served["simRMLPos"] == "`sim.rmlPos`"
    assert served["simGetShapeViz"] == "`sim.getShapeViz`"
    assert served["simSetStringParameter"] == "`sim.setStringParameter`"
    assert {name for name, by in served.items() if by == "this process"} == {
        *(name for name in vars(Library) if name.startswith("sim") and name != "simSetStringParameter"),
        *(name for name in served if "Stack" in name),
    }
    for name, _, test in rows:
        file, _, function = test.strip("`").partition("::")
        text = (ROOT / "tests" / "client" / "pyrep" / f"{file}.py").read_text(encoding="utf-8")
        assert f"\ndef {function}(" in text, name


def test_flags_and_variables_of_the_guide_exist() -> None:
    known = f"{make_parser().format_help()} {run.make_parser().format_help()}"
    flags = set(re.findall(r"(?<![\w-])--[a-z][a-z-]*", known))
    assert set(re.findall(r"(?<![\w-])--[a-z][a-z-]*", GUIDE)) <= flags
    assert set(re.findall(r"SIMX_\w+", GUIDE)) == {SWITCH, ARGUMENTS}
    for name in re.findall(r"tests/pyrep/\w+\.py", GUIDE):
        assert (ROOT / name).is_file()
