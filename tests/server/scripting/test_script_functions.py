"""The list of what scripts can call is made from the code, is fresh, and whatever it calls full is called by a test."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from simx_server.app import cli
from simx_server.sim_api import NAMESPACES
from simx_server.sim_api.listing.coverage import Support, script_functions
from simx_server.sim_api.namespaces import signatures

ROOT = Path(__file__).parents[3]
PAGE = ROOT / "docs" / "script-functions.md"
AT_LEAST = 200


def called_in_tests() -> set[str]:
    """Every function that a script in a test, in a shipped scene or model calls, by its new name."""
    files = [*(ROOT / "tests").rglob("*.py"), *ROOT.glob("tests/**/*.lua"), *ROOT.glob("scenes/**/*.lua")]
    text = "\n".join(path.read_text() for path in files)
    named = set(re.findall(r"\b(sim\w*\.\w+)\s*\(", text))
    flat = {f"sim.{name[0].lower()}{name[1:]}" for name in re.findall(r"\bsim([A-Z]\w*)\s*\(", text)}
    return named | flat


def test_there_are_the_functions_that_embedded_scripts_use_most() -> None:
    lines = script_functions()
    assert len({line.name for line in lines}) == len(lines)
    assert sum(line.support is Support.FULL for line in lines) >= AT_LEAST
    assert {line.name for line in lines if line.name.startswith("sim.")} == {
        f"sim.{n}" for n in signatures("sim")
    }


def test_no_part_of_a_namespace_overrides_another_one() -> None:
    for namespace in NAMESPACES.values():
        definers: dict[str, type] = {}
        for part in namespace.__mro__:
            own = {
                name for name, value in vars(part).items() if callable(value) and not name.startswith("__")
            }
            for name in own:
                first = definers.setdefault(name, part)
                assert issubclass(first, part), f"{first.__name__} hides {name} of {part.__name__}"


def test_what_is_not_fully_there_says_what_is_different() -> None:
    assert not [
        line.name for line in script_functions() if line.support is not Support.FULL and not line.differs
    ]


def test_every_function_that_is_fully_there_is_called_by_a_script_in_a_test() -> None:
    called = called_in_tests()
    assert not sorted(
        line.name for line in script_functions() if line.support is Support.FULL and line.name not in called
    )


def test_the_page_of_script_functions_is_fresh(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["--script-functions", "--markdown"]) == 0
    assert capsys.readouterr().out == PAGE.read_text(), (
        "run: simx-server --script-functions --markdown > docs/script-functions.md"
    )


def test_script_functions_as_json_are_for_programs(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["--script-functions", "--json"]) == 0
    found = {record["name"]: record for record in json.loads(capsys.readouterr().out)}
    assert found["sim.getObjectPosition"]["support"] == "full"
