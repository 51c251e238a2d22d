"""A call's cost is bounded before it starts: each function of each API, with the largest arguments that it accepts."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from fuzz.costs import calls as call_costs
from fuzz.costs.calls import (
    EXEMPT,
    Call,
    Target,
    functions,
    problems_of,
    problems_of_commands,
    refused,
    samples,
)

from simx_server.errors import CommandError
from simx_server.scene.formats.vrep.conversion.geometry.colliding.decomposition import answer_of
from simx_server.sim_api.vision.vision import _as_table

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("older_objects_set_aside")]


@pytest.fixture
def target(tmp_path: Path) -> Iterator[Target]:
    made = Target(tmp_path)
    yield made
    made.close()


def test_arguments_that_fit_together_cost_no_more_than_the_budget(target: Target) -> None:
    found: list[str] = []
    for name, values in samples(target.handles):
        problem, is_accepted = target.check(Call(name, values, 1.0))
        assert is_accepted, name
        found += [str(problem)] if problem else []
    for name, values in refused(target.handles):
        problem, is_accepted = target.check(Call(name, values, 1.0))
        assert not is_accepted, name
        found += [str(problem)] if problem else []
    assert not found


def test_functions_of_scripts_cost_no_more_than_the_budget(target: Target, tmp_path: Path) -> None:
    assert not problems_of(target, functions(), tmp_path)


def test_functions_of_the_table_cost_no_more_than_the_budget(target: Target) -> None:
    assert not problems_of_commands(target)


def test_others_are_served_while_another_process_works() -> None:
    """Its work ends with the server."""
    looks: list[bool] = [False, True]
    process = subprocess.Popen(
        [sys.executable, "-c", "import signal; signal.pause()"], stdout=subprocess.PIPE
    )
    with pytest.raises(subprocess.TimeoutExpired):
        answer_of(process, looks.pop)
    assert not looks
    assert process.returncode < 0


def test_an_image_that_is_too_large_for_a_table_is_refused() -> None:
    with pytest.raises(CommandError, match="read a region, or a string of bytes"):
        _as_table(np.zeros((1000, 1000, 3), np.float32))
    assert _as_table(np.array([[0, 1]], np.float32)) == [0.0, 1.0]


def test_exempt_functions_exist() -> None:
    assert set(EXEMPT) <= set(functions())


def test_what_costs_too_much_is_found(
    target: Target, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(call_costs, "BUDGET", 1e-9)
    monkeypatch.setattr(call_costs, "FLOOR", 0.0)
    assert problems_of(target, ["sim.getConfigDistance"], tmp_path)
