"""simx-run replaces the legacy binding wherever a script imports it from, and nothing else."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from types import ModuleType

import pytest
from launching import LEGACY_BINDING, LEGACY_CONSTANTS, carry_binding, output_of

from simx_client.checking.reading.bindings import is_legacy_binding
from simx_client.launch.after_import import AfterImport

pytestmark = pytest.mark.slow

ASK_WHOSE = "print(vrep.simxGetJointPosition.__module__.split('.')[0])"


@pytest.mark.parametrize(
    "line", ["import vrep", "import sim as vrep", "import sim as vrep_sim; vrep = vrep_sim"]
)
def test_without_any_file_the_binding_is_ours(tmp_path: Path, line: str) -> None:
    assert output_of(tmp_path, f"{line}\n{ASK_WHOSE}") == "simx_client"


@pytest.mark.parametrize("names", [("vrep", "vrepConst"), ("sim", "simConst")])
def test_a_carried_binding_beside_the_script_is_replaced(tmp_path: Path, names: tuple[str, str]) -> None:
    carry_binding(tmp_path, names)
    before = (tmp_path / f"{names[0]}.py").read_bytes()
    assert output_of(tmp_path, f"import {names[0]} as vrep\n{ASK_WHOSE}") == "simx_client"
    assert (tmp_path / f"{names[0]}.py").read_bytes() == before


@pytest.mark.parametrize(
    "line",
    [
        "from simulation import vrep",
        "import simulation.vrep as vrep",
        "import simulation.vrep; vrep = simulation.vrep",
        "from simulation.vrep import simxGetJointPosition; import simulation.vrep as vrep",
        "from simulation.robot import vrep",
        "import importlib; vrep = importlib.import_module('simulation.vrep')",
    ],
)
def test_a_binding_carried_in_a_package_is_replaced(tmp_path: Path, line: str) -> None:
    carry_binding(tmp_path / "simulation")
    (tmp_path / "simulation" / "__init__.py").write_text("")
    (tmp_path / "simulation" / "robot.py").write_text("from . import vrep\nfrom .vrepConst import *\n")
    assert output_of(tmp_path, f"{line}\n{ASK_WHOSE}") == "simx_client"


def test_a_replaced_binding_has_the_names_of_c(tmp_path: Path) -> None:
    carry_binding(tmp_path)
    print_name = "print(vrep.c_GetJointPosition.__name__, hasattr(vrep, 'c_nothing'))"
    assert output_of(tmp_path, f"import vrep\n{print_name}") == "c_GetJointPosition False"


def test_a_binding_under_another_name_is_replaced(tmp_path: Path) -> None:
    carry_binding(tmp_path)
    (tmp_path / "vrep.py").rename(tmp_path / "vrep_api.py")
    assert output_of(tmp_path, f"import vrep_api as vrep\n{ASK_WHOSE}") == "simx_client"


def test_a_folder_called_vrep_keeps_its_modules_and_loses_its_binding(tmp_path: Path) -> None:
    carry_binding(tmp_path / "vrep")
    (tmp_path / "vrep" / "simulator.py").write_text("from .vrep import simxStart\nname = 'their simulator'\n")
    text = """
        from vrep.simulator import name
        from vrep import vrep as inner
        import vrep
        print(name, vrep.simxStart is inner.simxStart)
    """
    assert output_of(tmp_path, text) == "their simulator True"


def test_a_package_called_vrep_stays_theirs(tmp_path: Path) -> None:
    carry_binding(tmp_path / "vrep")
    (tmp_path / "vrep" / "__init__.py").write_text("from .vrep import *\nname = 'their package'\n")
    text = "import vrep\nprint(vrep.name, vrep.simxStart.__module__.split('.')[0])"
    assert output_of(tmp_path, text) == "their package simx_client"


def test_a_users_own_sim_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "sim.py").write_text(
        "print('\"remoteApi.dll\" is not needed here')\ndef step(): return 'mine'\n"
    )
    assert output_of(tmp_path, "import sim\nprint(sim.step())").endswith("mine")


def test_a_users_own_wrapper_called_vrep_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "vrep.py").write_text("import sim\ndef simxStart(port): return sim.simx_opmode_blocking\n")
    assert output_of(tmp_path, "import vrep\nprint(vrep.simxStart(1))") == "65536"


def test_a_missing_module_of_another_name_is_still_missing(tmp_path: Path) -> None:
    text = """
        try:
            import vrep_tools
        except ModuleNotFoundError as error:
            print(error)
    """
    assert output_of(tmp_path, text) == "No module named 'vrep_tools'"


def test_constants_modules_hold_the_constants_only(tmp_path: Path) -> None:
    carry_binding(tmp_path)
    text = """
        import vrepConst, simConst
        for module in (vrepConst, simConst):
            public = {name: value for name, value in vars(module).items() if not name.startswith('__')}
            assert all(type(value) is int for value in public.values()), public
            assert len(public) == 626, len(public)
        print(vrepConst.simx_opmode_blocking, simConst.sim_object_joint_type)
    """
    assert output_of(tmp_path, text) == "65536 1"


def test_wrappers_that_walk_the_module_find_plain_functions(tmp_path: Path) -> None:
    text = """
        import inspect, types
        import vrep
        found = {}
        for name in dir(vrep):
            function = getattr(vrep, name)
            if isinstance(function, types.FunctionType):
                parameters = inspect.getfullargspec(function).args
                if parameters and parameters[0] == 'clientID':
                    found[name] = parameters
        assert found['simxGetObjectHandle'] == ['clientID', 'objectName', 'operationMode'], found
        assert len(found) > 100 and 'simxStart' not in found
        assert vrep.simx_opmode_oneshot_wait == vrep.simx_opmode_blocking
        print(vrep.__name__, not hasattr(vrep, 'protocol'))
    """
    assert output_of(tmp_path, text) == "vrep True"


def test_names_can_be_imported_one_by_one(tmp_path: Path) -> None:
    assert output_of(tmp_path, "from vrep import simxStart, simx_return_ok\nprint(simx_return_ok)") == "0"


def test_verbose_says_which_file_was_replaced(tmp_path: Path) -> None:
    carry_binding(tmp_path)
    from launching import simx_run

    finished = simx_run(tmp_path, "import vrep", flags=("-v",))
    assert f"simx_client replaces {tmp_path / 'vrep.py'}" in finished.stderr


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        (LEGACY_BINDING, True),
        (LEGACY_CONSTANTS, True),
        (LEGACY_BINDING.replace("\n", "\r\n"), True),
        ("def simxStart(a):\n    return ct.windll.LoadLibrary('remoteApi.dll')\n", True),
        ("print 'old', `x`\nsimx_opmode_blocking = 1\n", True),
        ("def simxStart(address):\n    return 0\n", False),
        ("print('could not load remoteApi.dll')\n", False),
        ("import vrep\nmode = vrep.simx_opmode_blocking\n", False),
        ("class A:\n    simx_opmode_blocking = 1\n", False),
        ("from simx_client import *\n", False),
    ],
)
def test_a_binding_is_known_by_what_it_defines(source: str, expected: bool) -> None:
    assert is_legacy_binding(source.encode("latin-1")) is expected


def test_a_patch_that_does_not_fit_lets_the_module_be_imported(caplog: pytest.LogCaptureFixture) -> None:
    def patch(module: ModuleType) -> None:
        raise TypeError("cannot set an attribute of an immutable type")

    sys.modules.pop("colorsys", None)
    finder = AfterImport({"colorsys": patch})
    finder.install()
    try:
        assert importlib.import_module("colorsys").rgb_to_hsv(0, 0, 0) == (0.0, 0.0, 0)
    finally:
        sys.meta_path.remove(finder)
    assert "colorsys stays as it is" in caplog.text
