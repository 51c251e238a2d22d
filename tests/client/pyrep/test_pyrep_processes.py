"""Programs in separate processes: under simx-run, with the variable, started by spawn, and against the folder."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from processes import ROOT

from simx_client.pyrep.root import root_folder

PROGRAM = """
import multiprocessing, os, sys, threading
from pyrep.backend import ffi, lib

SCENE = {scene!r}

def drive(steps):
    opener = threading.Thread(target=lib.simExtLaunchUIThread, args=(b"PyRep", 65536, SCENE.encode(), b""))
    opener.start()
    while not lib.simExtCanInitSimThread():
        opener.join(0.01)
    lib.simStartSimulation()
    for _ in range(steps):
        lib.simExtStep(True)
    time = lib.simGetSimulationTime()
    lib.simExtSimThreadDestroy()
    opener.join()
    return round(time / 0.05)

if __name__ == "__main__":
    assert os.path.isdir(os.environ["COPPELIASIM_ROOT"])
    print("steps", drive(3))
    if "spawn" in sys.argv:
        with multiprocessing.get_context("spawn").Pool(1) as pool:
            print("steps", pool.map(drive, [1, 2]))
"""


@pytest.fixture
def program(tmp_path: Path) -> Path:
    """A program with a package that imports the library as PyRep does; its compiled module cannot be loaded."""
    backend = tmp_path / "pyrep" / "backend"
    backend.mkdir(parents=True)
    (backend.parent / "__init__.py").write_text("")
    (backend / "__init__.py").write_text("from ._sim_cffi import ffi, lib\n")
    (backend / "_sim_cffi.py").write_text(
        "raise ImportError('libcoppeliaSim.so.1: cannot open shared object file')\n"
    )
    path = tmp_path / "program.py"
    path.write_text(PROGRAM.format(scene=str(ROOT / "tests" / "conformance" / "scene.xml")))
    return path


def run(*command: str | Path, **variables: str) -> str:
    environment = {
        name: value for name, value in os.environ.items() if name not in ("SIMX_PYREP", "COPPELIASIM_ROOT")
    }
    done = subprocess.run(
        [str(each) for each in command],
        env=environment | variables,
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_simx_run_gives_a_program_the_library(program: Path) -> None:
    assert "steps 3" in run(sys.executable, "-m", "simx_client.launch.run", "--pyrep", program)


def test_the_variable_reaches_processes_that_a_program_spawns(program: Path) -> None:
    output = run(sys.executable, program, "spawn", SIMX_PYREP="1")
    assert "steps 3" in output
    assert "steps [1, 2]" in output


def test_flags_of_the_server_come_behind_server_args(program: Path, tmp_path: Path) -> None:
    record = tmp_path / "run.simx"
    run(
        sys.executable,
        "-m",
        "simx_client.launch.run",
        "--pyrep",
        "--server-args",
        f"--record {record}",
        program,
    )
    assert record.stat().st_size > 0


def test_the_folder_for_installations_satisfies_a_linker(tmp_path: Path) -> None:
    folder = Path(run(sys.executable, "-m", "simx_client.launch.run", "--pyrep-root").strip())
    assert folder == root_folder()
    assert (folder / "system").is_dir()
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("there is no C compiler")
    source = tmp_path / "module.c"
    source.write_text("int simExtStep(int); int step(void) { return simExtStep(1); }\n")
    command = [compiler, "-shared", "-fPIC", str(source), "-o", str(tmp_path / "module.so"), f"-L{folder}"]
    subprocess.run([*command, "-lcoppeliaSim"], check=True)
