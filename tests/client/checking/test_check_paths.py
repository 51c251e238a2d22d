"""``simx-check`` follows a program's imports: packages, paths that it adds, PYTHONPATH, installed wrappers."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from checked_programs import START, check, files_of, objects_of, texts_of, write

BINDING = "simx_opmode_oneshot = 0\ndef simxNoSuch(): pass\nsimxNoSuch()\n"
MODULE = f"import vrep\n{START}def find(name): return vrep.simxGetObjectHandle(c, name, B)\n"


def test_packages_and_relative_imports_are_followed_and_carried_bindings_are_not_read(tmp_path: Path) -> None:
    files = {
        "script.py": "import project.robots.arm\nproject.robots.arm.Arm('left').home()\n",
        "project/__init__.py": "",
        "project/robots/__init__.py": "",
        "project/robots/arm.py": "from ..link import find\nfrom . import names\nfrom .. import link as l\n"
        "class Arm:\n  def __init__(self, n): self.n = n\n"
        "  def home(self): find(self.n + '_' + names.TIP); l.find('base')\n",
        "project/robots/names.py": "TIP = 'tip'\n",
        "project/link.py": MODULE.replace("import vrep", "from .remote import vrep"),
        "project/remote/vrep.py": BINDING,
    }
    write(tmp_path, files)
    code, record = check(tmp_path / "script.py")
    assert (code, texts_of(record)) == (0, [])
    assert objects_of(record) == ["base", "left_tip"]
    assert files_of(record) == {"script.py", "__init__.py", "arm.py", "names.py", "link.py"}


@pytest.mark.parametrize(
    "line",
    [
        "sys.path.append('lib')",
        "sys.path.insert(0, './lib/')",
        "sys.path.append('lib\\\\')",
        "sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), 'lib'))",
        "sys.path.insert(1, os.path.dirname(__file__) + '/lib')",
        "HERE = os.path.dirname(__file__)\nLIB = os.path.join(HERE, 'lib')\nsys.path.append(LIB)",
        "sys.path += [f'{os.path.dirname(__file__)}/lib']",
        "sys.path = ['lib'] + sys.path",
        "sys.path[0:0] = ['lib']",
        "sys.path.extend(['nowhere', 'lib'])",
        "for folder in ('a', 'lib'): sys.path.append(folder)",
        "from pathlib import Path\nsys.path.append(str(Path(__file__).resolve().parent / 'lib'))",
        "from pathlib import Path\nsys.path.append(Path(__file__).parents[0].joinpath('lib').as_posix())",
        "import site\nsite.addsitedir(os.path.split(__file__)[0] + os.sep + 'lib')",
        "sys.path.append(os.environ.get('NO_SUCH_VARIABLE', 'lib'))",
        "sys.path.append(os.path.join(sys.path[0], 'lib'))",
    ],
)
def test_paths_that_a_program_adds_are_looked_into(tmp_path: Path, line: str) -> None:
    write(
        tmp_path, {"script.py": f"import os, sys\n{line}\nimport far\nfar.find('it')\n", "lib/far.py": MODULE}
    )
    code, record = check(tmp_path / "script.py")
    assert (code, objects_of(record), texts_of(record, "note")) == (0, ["it"], [])


def test_a_path_above_the_script_and_one_that_a_module_adds(tmp_path: Path) -> None:
    files = {
        "programs/script.py": "import setup_paths, far\nfar.find('it')\n",
        "programs/setup_paths.py": "import sys, os\nHERE = os.path.dirname(__file__)\n"
        "sys.path.append(os.path.join(HERE, os.pardir, 'lib'))\n",
        "lib/far.py": MODULE,
    }
    write(tmp_path, files)
    _, record = check(tmp_path / "programs/script.py")
    assert objects_of(record) == ["it"]


def test_modules_on_pythonpath_are_followed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(tmp_path, {"own/script.py": "import far\nfar.find('it')\n", "lib/far.py": MODULE})
    monkeypatch.setenv("PYTHONPATH", str(tmp_path / "lib"))
    _, record = check(tmp_path / "own/script.py")
    assert objects_of(record) == ["it"]


def test_installed_packages_are_followed_if_they_wrap_a_binding(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    files = {
        "own/script.py": "from vrep_api_h15 import Robot\nimport plain_h15, numpy\nRobot('it')\n",
        "site-packages/vrep_api_h15/__init__.py": "from .core.robot import Robot\n",
        "site-packages/vrep_api_h15/core/__init__.py": "",
        "site-packages/vrep_api_h15/core/robot.py": MODULE
        + "class Robot:\n  def __init__(self, n): find(n)\n",
        "site-packages/plain_h15.py": "x = 1\n",
    }
    write(tmp_path, files)
    monkeypatch.setattr(sys, "path", [*sys.path, str(tmp_path / "site-packages")])
    code, record = check(tmp_path / "own/script.py")
    assert (code, objects_of(record)) == (0, ["it"])
    assert files_of(record) == {"script.py", "__init__.py", "robot.py"}
    assert texts_of(record, "note") == []


def test_a_sim_py_that_is_no_binding_is_a_module_as_any_other(tmp_path: Path) -> None:
    write(tmp_path, {"script.py": "import sim\nsim.find('it')\nsim.simxGetPose()\n", "sim.py": MODULE})
    code, record = check(tmp_path / "script.py")
    assert (code, objects_of(record)) == (0, ["it"])


def test_a_folder_called_as_a_binding_keeps_its_own_modules(tmp_path: Path) -> None:
    text = "from sim import robot\nimport sim.more as more\nrobot.find('it')\nmore.find('that')\n"
    write(tmp_path, {"script.py": text, "sim/robot.py": MODULE, "sim/more.py": MODULE})
    code, record = check(tmp_path / "script.py")
    assert (code, objects_of(record)) == (0, ["it", "that"])


def test_python_2_finds_modules_of_its_own_package_without_a_dot(tmp_path: Path) -> None:
    files = {
        "script.py": "import pack.robot\nprint 'x'\npack.robot.go('it')\n",
        "pack/__init__.py": "",
        "pack/robot.py": "import link\ndef go(n):\n  link.find(n)\n  print n\n",
        "pack/link.py": MODULE,
    }
    write(tmp_path, files)
    code, record = check(tmp_path / "script.py")
    assert (code, objects_of(record), record["python"]) == (0, ["it"], 2)


def test_modules_that_import_each_other_are_read_once(tmp_path: Path) -> None:
    write(tmp_path, {"script.py": "import a\na.go('it')\n", "a.py": "import b, a\ndef go(n): b.go(n)\n",
                     "b.py": f"import a, script\n{MODULE}def go(n): find(n)\n"})  # fmt: skip
    code, record = check(tmp_path / "script.py")
    assert (code, objects_of(record), files_of(record)) == (0, ["it"], {"script.py", "a.py", "b.py"})


def test_a_module_that_is_not_installed_is_noted_where_it_is_imported(tmp_path: Path) -> None:
    write(tmp_path, {"script.py": "import helper\n", "helper.py": MODULE + "\nimport surely_not_installed\n"})
    _, record = check(tmp_path / "script.py")
    [note] = [each for each in record["findings"] if "not installed" in each["text"]]
    assert (Path(note["file"]).name, note["line"]) == ("helper.py", 6)
