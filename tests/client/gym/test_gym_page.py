"""docs/gym.md: its programs run, and its tables have every quantity and environment."""

from __future__ import annotations

import re
import warnings
from pathlib import Path

import pytest

from simx_client.gym import TASKS
from simx_client.gym.quantities.readable import READABLE
from simx_client.gym.quantities.writable import WRITABLE

pytestmark = [pytest.mark.slow, pytest.mark.system, pytest.mark.gl]

PAGE = (Path(__file__).parents[3] / "docs" / "gym.md").read_text(encoding="utf-8")
PROGRAMS = re.findall(r"^```python\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize(
    "program", PROGRAMS, ids=lambda text: re.findall(r"simx/\w+|SimxEnv|Randomize", text)[0]
)
def test_programs_run(program: str) -> None:
    with warnings.catch_warnings(action="error"):
        exec(compile(program, "gym.md", "exec"), {})


def test_the_tables_have_every_quantity() -> None:
    observed, _, written = PAGE.partition("| actions and start values of a |")
    for part, table in ((observed, READABLE), (written, WRITABLE)):
        rows = re.findall(r"^\| ([\w ]+) \| `(\w+)` \| (.+) \|$", part, re.MULTILINE)
        assert rows == [(each.kind, each.attribute, each.meaning) for each in table]


def test_the_table_has_every_environment_with_its_steps() -> None:
    rows = re.findall(r"^\| `(simx/\S+)` \|.*\| (\d+) \|$", PAGE, re.MULTILINE)
    assert [(name, int(steps)) for name, steps in rows] == list(TASKS.values())
