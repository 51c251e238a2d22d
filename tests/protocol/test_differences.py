"""The numbered differences from the original: each names a test that is there; README and docs say the same."""

from __future__ import annotations

import ast
import functools
import inspect
import re
from pathlib import Path

import pytest
from statements import parsed, statements

from simx_client.protocol.commands import BY_NAME
from simx_client.protocol.differences import DIFFERENCES, Difference, for_readme
from simx_server.app.cli import main
from simx_server.handlers import HANDLERS

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "coverage.md"


@pytest.mark.parametrize("difference", DIFFERENCES, ids=lambda each: each.title)
def test_the_test_that_a_difference_names_is_there(difference: Difference) -> None:
    file, _, name = difference.test.partition("::")
    assert name in _functions(ROOT / file)


@functools.cache
def _functions(file: Path) -> set[str]:
    return {node.name for node in statements(parsed(file)) if isinstance(node, ast.FunctionDef)}


@pytest.mark.parametrize("difference", DIFFERENCES, ids=lambda each: each.title)
def test_a_difference_names_existing_commands(difference: Difference) -> None:
    assert set(difference.commands.split()) <= set(BY_NAME)


def test_a_handler_that_says_it_differs_is_in_the_list() -> None:
    listed = {BY_NAME[name].name for each in DIFFERENCES for name in each.commands.split()}
    saying = {
        name for name, handler in HANDLERS.items() if "Differs:" in (inspect.getdoc(handler.function) or "")
    }
    assert saying - listed == set(), "put them into simx_client/protocol/differences.py, at the end"


def test_the_coverage_page_is_fresh(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--commands", "--markdown"]) == 0
    made = capsys.readouterr().out
    assert PAGE.read_text(encoding="utf-8") == made, (
        "run: simx-server --commands --markdown > docs/coverage.md"
    )


def test_the_coverage_page_has_all_133_names() -> None:
    page = PAGE.read_text(encoding="utf-8")
    lists = page.partition("\n## ")[0]
    assert set(re.findall(r"`(simx\w+)`", lists)) >= set(BY_NAME)


def test_the_readme_has_the_most_visible_differences_word_by_word() -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    section = readme.partition("## Differences from V-REP\n")[2].partition("\n## ")[0]
    assert for_readme() in section
    assert "docs/coverage.md" in section
