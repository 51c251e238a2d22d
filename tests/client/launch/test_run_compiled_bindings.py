"""simx-run replaces a carried binding that is compiled, for whatever Python or system, and nothing else."""

from __future__ import annotations

import py_compile
import shutil
import subprocess
import sysconfig
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest
from launching import LEGACY_BINDING, LEGACY_CONSTANTS, carry_binding, output_of

from simx_client.checking.reading.bindings import is_compiled_binding

pytestmark = pytest.mark.slow

ASK_WHOSE = "print(vrep.simxGetJointPosition.__module__.split('.')[0])"
NO_CODE = b"\x7fELF\x02\x01\x01\x00\x00 this is not loadable \x00"
PYTHON_27 = b"\x03\xf3\r\n"
OWN_MODULE = "def step():\n    return 'mine'\n"
OWN_WRAPPER = """
import sim
def simxStart(port):
    if not sim.simxStart: print('remoteApiCommandServer not found, nor remoteApi.so')
    return sim.simxGetObjectHandle and sim.simx_opmode_blocking
"""


def as_byte_code(source: Path) -> None:
    """Leave NAME.pyc where NAME.py was."""
    py_compile.compile(str(source), str(source.with_suffix(".pyc")), doraise=True)
    source.unlink()


def as_byte_code_of_python_2(source: Path) -> None:
    as_byte_code(source)
    compiled = source.with_suffix(".pyc")
    compiled.write_bytes(PYTHON_27 + compiled.read_bytes()[4:])


def as_extension(suffix: str) -> Callable[[Path], None]:
    def convert(source: Path) -> None:
        names = b"\0".join(source.read_bytes().replace(b"\n", b" ").split(b" "))
        source.with_name(source.stem + suffix).write_bytes(NO_CODE + names)
        source.unlink()

    return convert


FORMS = {
    "pyc": as_byte_code,
    "pyc-of-python-2": as_byte_code_of_python_2,
    "so": as_extension(".so"),
    "so-of-this-python": as_extension(sysconfig.get_config_var("EXT_SUFFIX")),
    "so-of-another-python": as_extension(".cpython-36m-x86_64-linux-gnu.so"),
    "pyd": as_extension(".pyd"),
    "pyd-of-another-python": as_extension(".cp36-win_amd64.pyd"),
}


VREP, SIM = ("vrep", "vrepConst"), ("sim", "simConst")


@pytest.mark.parametrize(("form", "names"), [*((form, VREP) for form in FORMS), ("pyc", SIM)])
def test_a_compiled_binding_beside_the_script_or_in_a_package_is_replaced(
    tmp_path: Path, form: str, names: tuple[str, str]
) -> None:
    module, constants = names
    for folder in (tmp_path, tmp_path / "robot"):
        carry_binding(folder, names)
        for name in names:
            FORMS[form](folder / f"{name}.py")
        for library in ("remoteApi.so", "remoteApi.dll", "remoteApi.dylib"):
            (folder / library).write_bytes(NO_CODE)
    (tmp_path / "robot" / "__init__.py").write_text(
        f"from . import {module} as vrep\nfrom .{constants} import simx_opmode_oneshot as mode\n"
    )
    text = f"""
        import {module} as vrep, {constants}, robot
        print(robot.vrep.simxStart is vrep.simxStart, robot.mode == {constants}.simx_opmode_oneshot)
        {ASK_WHOSE}
    """
    assert output_of(tmp_path, text) == "True True\nsimx_client"


@pytest.mark.parametrize("form", ["pyc", "so", "pyd-of-another-python"])
def test_a_compiled_binding_under_another_name_is_replaced(tmp_path: Path, form: str) -> None:
    carry_binding(tmp_path)
    (tmp_path / "vrep.py").rename(tmp_path / "vrep_api.py")
    FORMS[form](tmp_path / "vrep_api.py")
    assert output_of(tmp_path, f"import vrep_api as vrep\n{ASK_WHOSE}") == "simx_client"


def test_a_package_that_is_compiled_keeps_its_modules_and_loses_its_binding(tmp_path: Path) -> None:
    carry_binding(tmp_path / "vrep")
    (tmp_path / "vrep" / "__init__.py").write_text("from .vrep import *\nname = 'their package'\n")
    (tmp_path / "vrep" / "epuck.py").write_text("from .vrep import simxStart\n")
    for file in list((tmp_path / "vrep").glob("*.py")):
        as_byte_code(file)
    (tmp_path / "vrep" / "remoteApi.so").write_bytes(NO_CODE)
    text = "import vrep, vrep.epuck\nprint(vrep.name, vrep.epuck.simxStart.__module__.split('.')[0])"
    assert output_of(tmp_path, text) == "their package simx_client"


def test_a_package_that_is_nothing_but_the_binding_is_replaced(tmp_path: Path) -> None:
    carry_binding(tmp_path / "vrep")
    (tmp_path / "vrep" / "vrep.py").rename(tmp_path / "vrep" / "__init__.py")
    (tmp_path / "vrep" / "epuck.py").write_text("name = 'their robot'\n")
    text = f"import vrep, vrep.epuck\nprint(vrep.epuck.name)\n{ASK_WHOSE}"
    assert output_of(tmp_path, text) == "their robot\nsimx_client"


def test_a_binding_in_an_egg_is_replaced(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "robot.egg", "w") as egg:
        egg.writestr("vrep.py", LEGACY_BINDING.format(constants="vrepConst"))
        egg.writestr("vrepConst.py", LEGACY_CONSTANTS)
    text = f"import sys\nsys.path.insert(0, 'robot.egg')\nimport vrep\n{ASK_WHOSE}"
    assert output_of(tmp_path, text) == "simx_client"


@pytest.mark.parametrize("name", ["sim", "vrep", "my_vrep_robot"])
def test_a_users_own_byte_code_is_left_alone(tmp_path: Path, name: str) -> None:
    (tmp_path / f"{name}.py").write_text(OWN_MODULE)
    as_byte_code(tmp_path / f"{name}.py")
    assert output_of(tmp_path, f"import {name}\nprint({name}.step())") == "mine"


def test_a_users_own_wrapper_as_byte_code_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "vrep.py").write_text(OWN_WRAPPER)
    as_byte_code(tmp_path / "vrep.py")
    assert output_of(tmp_path, "import vrep\nprint(vrep.simxStart(1))") == "65536"


@pytest.mark.skipif(not shutil.which("gcc"), reason="makes an extension module: apt-get install gcc")
@pytest.mark.skipif(
    not Path(sysconfig.get_path("include"), "Python.h").exists(), reason="needs Python.h: python3-dev"
)
def test_a_users_own_extension_called_sim_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "sim.c").write_text(
        "#include <Python.h>\n"
        'static struct PyModuleDef sim = {PyModuleDef_HEAD_INIT, "sim", "my simulation", -1, NULL};\n'
        "PyMODINIT_FUNC PyInit_sim(void) { return PyModule_Create(&sim); }\n"
    )
    include = f"-I{sysconfig.get_path('include')}"
    subprocess.run(["gcc", "-shared", "-fPIC", include, "sim.c", "-o", "sim.so"], cwd=tmp_path, check=True)
    assert output_of(tmp_path, "import sim\nprint(sim.__doc__)") == "my simulation"


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        ("simxStart simxFinish CFUNCTYPE", True),
        ("simxStart remoteApi.so LoadLibrary", True),
        ("simxStart simxFinish extApi_endianConversionInt PyInit_vrep", True),
        ("simx_opmode_oneshot sim_object_shape_type", True),
        (" ".join(f"simxFunction{letter}{digit}" for letter in "ABCDEFG" for digit in range(10)) + " simxStart", True),
        ("simxStart simx_opmode_blocking remoteApiCommandServer", False),
        ("simx_opmode_blocking simxGetObjectHandle", False),
        ("PyInit_sim step reset", False),
        ("", False),
    ],
)  # fmt: skip
def test_a_compiled_binding_is_known_by_its_names(names: str, expected: bool) -> None:
    assert is_compiled_binding(NO_CODE + names.replace(" ", "\0").encode()) is expected
