"""The stand-ins: files that can lie under the legacy names in any folder or package."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from launching import LEGACY_BINDING, ROOT, output_of, python, write_script

from simx_client.cli.shims import FILES, write_shims

pytestmark = pytest.mark.slow

WALK = """
    import inspect, types
    import {module} as vrep
    names = [name for name in dir(vrep) if isinstance(getattr(vrep, name), types.FunctionType)]
    first = [inspect.getfullargspec(getattr(vrep, name)).args[:1] for name in names]
    print(first.count(['clientID']) > 100, vrep.simx_opmode_blocking, vrep.simxStart.__name__)
"""


def test_command_writes_the_files_and_says_so(tmp_path: Path) -> None:
    finished = python(tmp_path, "-m", "simx_client", "shims", "here/below")
    assert finished.returncode == 2
    assert "here/below is no folder" in finished.stderr
    finished = python(tmp_path, "-m", "simx_client", "shims", ".")
    assert finished.returncode == 0, finished.stderr
    assert finished.stdout.split() == list(FILES)
    assert {path.name for path in tmp_path.iterdir()} == set(FILES)


@pytest.mark.parametrize("module", ["vrep", "sim"])
def test_stand_in_beside_a_script_works_without_a_launcher(tmp_path: Path, module: str) -> None:
    write_shims(tmp_path)
    write_script(tmp_path, WALK.format(module=module))
    finished = python(tmp_path, "script.py")
    assert finished.stdout == "True 65536 simxStart\n", finished.stderr


def test_stand_in_works_in_a_package(tmp_path: Path) -> None:
    (tmp_path / "simulation").mkdir()
    (tmp_path / "simulation" / "__init__.py").write_text("from . import vrep\nfrom .vrepConst import *\n")
    write_shims(tmp_path / "simulation")
    write_script(
        tmp_path,
        "import simulation\n" + "print(simulation.vrep.simxFinish.__name__, simulation.simx_return_ok)",
    )
    assert python(tmp_path, "script.py").stdout == "simxFinish 0\n"


def test_constants_stand_ins_hold_every_constant(tmp_path: Path) -> None:
    write_shims(tmp_path)
    write_script(
        tmp_path,
        """
        import vrepConst, simConst
        for module in (vrepConst, simConst):
            public = {name: value for name, value in vars(module).items() if not name.startswith('_')}
            assert len(public) == 626 and all(type(value) is int for value in public.values())
        """,
    )
    finished = python(tmp_path, "script.py")
    assert finished.returncode == 0, finished.stderr


def test_stand_ins_work_under_simx_run_too(tmp_path: Path) -> None:
    write_shims(tmp_path)
    assert output_of(tmp_path, WALK.format(module="vrep")) == "True 65536 simxStart"


def test_type_checkers_see_the_functions(tmp_path: Path) -> None:
    pytest.importorskip("pyright")
    write_shims(tmp_path)
    write_script(
        tmp_path,
        """
        import vrep
        number: int = vrep.simxStart("127.0.0.1", 19997, True, True, 5000, 5)
        mode: int = vrep.simx_opmode_blocking
        vrep.simxNoSuchFunction()
        """,
    )
    (tmp_path / "pyrightconfig.json").write_text(f'{{"extraPaths": ["{ROOT.as_posix()}"]}}')
    command = [sys.executable, "-m", "pyright", "--pythonpath", sys.executable, "script.py"]
    finished = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False)
    errors = [line for line in finished.stdout.splitlines() if " error: " in line]
    assert len(errors) == 1, finished.stdout
    assert "simxNoSuchFunction" in errors[0]


def test_another_file_of_that_name_is_kept(tmp_path: Path) -> None:
    (tmp_path / "sim.py").write_text(LEGACY_BINDING)
    finished = python(tmp_path, "-m", "simx_client", "shims", ".")
    assert finished.returncode == 1
    assert "sim.py would be replaced" in finished.stderr
    assert "--force" in finished.stderr
    assert (tmp_path / "sim.py").read_text() == LEGACY_BINDING
    assert not (tmp_path / "vrep.py").exists(), "nothing is written when one file is in the way"


def test_force_replaces_and_a_second_time_needs_none(tmp_path: Path) -> None:
    (tmp_path / "sim.py").write_text(LEGACY_BINDING)
    write_shims(tmp_path, force=True)
    assert "simx_client" in (tmp_path / "sim.py").read_text()
    assert write_shims(tmp_path) == [tmp_path / name for name in FILES]
