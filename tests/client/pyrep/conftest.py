"""A program with one of each object, for the tests of single functions."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from c_program import CProgram
from processes import ROOT


@pytest.fixture
def program() -> Iterator[CProgram]:
    with CProgram(ROOT / "tests" / "conformance" / "scene.xml") as launched:
        yield launched
