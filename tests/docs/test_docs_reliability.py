"""The page of promises names tests that there are."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

import pytest
from processes import ROOT

pytestmark = pytest.mark.slow

PAGE = (ROOT / "docs" / "operators" / "reliability.md").read_text(encoding="utf-8")
TESTS = ROOT / "tests"


@cache
def _files() -> list[Path]:
    return list(TESTS.rglob("test_*.py"))


def _file(name: str) -> Path:
    """The page gives names alone: folders of tests may change."""
    found = [path for path in _files() if str(path).endswith(f"/{name}")]
    assert len(found) == 1, f"{name}: {found}"
    return found[0]


def test_every_test_that_the_page_names_is_there() -> None:
    named = re.findall(r"`(?:tests/)?([\w/]+\.py)::(test_\w+)", PAGE)
    assert len(named) > 30
    for file, test in named:
        assert f"def {test}(" in _file(file).read_text(encoding="utf-8"), f"{file}::{test}"
    for file in re.findall(r"`(?:tests/)?(test_[\w/]+\.py)`", PAGE):
        assert _file(file)


def test_every_test_of_a_time_out_has_its_line() -> None:
    text = _file("test_faults_timeouts.py").read_text(encoding="utf-8")
    assert [name for name in re.findall(r"^def (test_\w+)", text, re.MULTILINE) if name not in PAGE] == []
