"""simx-run with programs of PyRep: ``--pyrep`` runs them, and without it an error leads to it."""

from __future__ import annotations

from pathlib import Path

import pytest
from launching import simx_run

from simx_client.launch.hints import hint

pytestmark = pytest.mark.slow

PACKAGE = {
    "__init__.py": "from .backend import sim\n",
    "backend/__init__.py": "",
    "backend/sim.py": "from ._sim_cffi import ffi, lib\n",
}
"""The imports of PyRep."""

PROGRAM = """\
import pyrep
print(pyrep.sim.lib.simExtCanInitSimThread())
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, text in PACKAGE.items():
        file = tmp_path / "pyrep" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
    return tmp_path


def test_a_program_of_pyrep_runs_with_the_flag_and_is_led_to_it_without(folder: Path) -> None:
    finished = simx_run(folder, PROGRAM, flags=("--pyrep",))
    assert (finished.returncode, finished.stdout) == (0, "0\n"), finished.stderr
    finished = simx_run(folder, PROGRAM)
    assert finished.returncode == 1
    assert finished.stderr.splitlines()[-2:] == [
        "ModuleNotFoundError: No module named 'pyrep.backend._sim_cffi'",
        "simx-run: this is a program of PyRep: run it with simx-run --pyrep SCRIPT, and simx stands for CoppeliaSim "
        "(docs/pyrep.md)",
    ]


@pytest.mark.parametrize(
    "text",
    [
        "libcoppeliaSim.so.1: cannot open shared object file: No such file or directory",
        "/x/pyrep/backend/_sim_cffi.abi3.so: undefined symbol: simGetObjectMatrix",
        "/x/_sim_cffi.cpython-311-x86_64-linux-gnu.so: undefined symbol: simGetObjectMatrix",
    ],
)
def test_a_compiled_pyrep_without_the_simulator_leads_to_the_flag(text: str) -> None:
    assert "run it with simx-run --pyrep SCRIPT" in (hint(ImportError(text)) or "")


def test_a_simulator_that_is_not_named_leads_to_the_flag() -> None:
    error = RuntimeError("COPPELIASIM_ROOT not defined. See installation instructions.")
    assert "run it with simx-run --pyrep SCRIPT" in (hint(error) or "")


@pytest.mark.parametrize("name", ["pyrep", "rlbench"])
def test_a_package_that_is_missing_is_installed_without_the_simulator(name: str) -> None:
    text = hint(ModuleNotFoundError(f"No module named '{name}'"))
    assert text is not None
    assert "COPPELIASIM_ROOT=$(simx-run --pyrep-root) " in text
    assert "run its programs with simx-run --pyrep SCRIPT" in text
    assert hint(ModuleNotFoundError(f"No module named '{name}.other'")) is None
