"""How much of CoppeliaSim's manual is there, function by function, against lists of its names."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest

from simx_server.scripting.modules import own_module
from simx_server.sim_api.listing.coverage import Support, script_functions
from simx_server.sim_api.listing.lacking import offered

LISTS = Path(__file__).parents[2] / "support" / "manual"

MISSING = "missing"


def names(file: str) -> list[str]:
    lines = (LISTS / f"{file}.txt").read_text().splitlines()
    return " ".join(line for line in lines if not line.startswith("#")).split()


def support(space: str) -> dict[str, str]:
    """The degree of support of each function; those that are written in Lua are there in full."""
    found = {f"{space}.{name}": str(Support.FULL) for name in offered().get(space, ())}
    return found | {line.name: str(line.support) for line in script_functions()}


@pytest.mark.parametrize(
    ("file", "full", "full_or_partly"),
    [
        ("sim", 0.92, 1.0),
        ("sim_older", 0.8, 0.9),
        ("simIK", 0.82, 0.95),
        ("simOMPL", 0.9, 0.98),
        ("simUI", 0.68, 0.74),
        ("simVision", 0.95, 1.0),
        ("simROS2", 0.25, 0.5),
    ],
)
def test_as_much_of_the_manual_is_there_as_before(file: str, full: float, full_or_partly: float) -> None:
    assert own_module("sim_functions", "lua")
    space = file.partition("_")[0]
    known, listed = support(space), names(file)
    counts = Counter(known.get(f"{space}.{name}", MISSING) for name in listed)
    assert counts.total() == len(set(listed)) > 40
    of_lists = {level: [n for n in listed if known.get(f"{space}.{n}", MISSING) == level] for level in counts}
    assert counts[Support.FULL] >= full * len(listed), of_lists
    assert counts[Support.FULL] + counts[Support.PARTLY] >= full_or_partly * len(listed), of_lists
