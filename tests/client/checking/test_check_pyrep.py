"""``simx-check`` on programs of PyRep and RLBench: how to run them, what to install, what is missing."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from checked_programs import START, check, objects_of, page_of, texts_of, write

from simx_client.checking.pyrep import sentences
from simx_client.protocol.cli.installing import line, pyrep_line

PROGRAM = """
from os.path import abspath, dirname, join
from pyrep import PyRep
from pyrep.backend import sim
from pyrep.objects.shape import Shape
from pyrep.robots.arms.panda import Panda

SCENE = join(dirname(abspath(__file__)), "scene.ttt")

class Reach:
    def __init__(self):
        self.pr = PyRep()
        self.pr.launch(SCENE, headless=True)
        self.target = Shape("target")
        self.arm = Panda()

    def step(self):
        sim.simSetObjectPosition(self.target.get_handle(), -1, [0, 0, 1])
        self.arm.get_path(position=[0, 0, 1], euler=[0, 0, 0]).step()
        self.pr.step()

Reach().step()
"""

RLBENCH_PROGRAM = """
from rlbench.environment import Environment
env = Environment(None)
env.launch()
env.get_task(None).reset()
"""


@pytest.fixture(autouse=True)
def packages(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder on PYTHONPATH with checkouts of both."""
    folder = tmp_path / "checkouts"
    write(
        folder,
        {
            "pyrep/__init__.py": "raise SystemExit('not to be run')\n",
            "pyrep/backend/sim.py": "def simSetObjectPosition(): pass\n",
            "rlbench/__init__.py": "import surely_not_installed\n",
            "rlbench/task_design.ttt": "",
        },
    )
    monkeypatch.setenv("PYTHONPATH", str(folder))
    monkeypatch.setattr(sentences, "is_installed", lambda _: True)
    return folder


def test_a_pyrep_program_is_told_how_it_runs_and_what_it_uses(tmp_path: Path) -> None:
    write(tmp_path, {"reach.py": PROGRAM, "scene.ttt": ""})
    code, record = check(tmp_path / "reach.py")
    assert (code, texts_of(record)) == (0, [])
    assert texts_of(record, "note") == [
        f"it uses PyRep: run it with simx-run --pyrep {tmp_path / 'reach.py'}, or with the variable SIMX_PYREP=1 "
        "(docs/pyrep.md)"
    ]
    assert record["files"] == [str(tmp_path / "reach.py")]
    assert list(record["pyrep"]["calls"]) == [
        *("PyRep", "PyRep.launch", "Shape", "Panda", "Shape.get_handle"),
        *("Panda.get_path.step", "Panda.get_path", "PyRep.step"),
    ]
    assert list(record["pyrep"]["functions"]) == ["simSetObjectPosition"]
    assert objects_of(record) == ["target"]
    page = page_of(tmp_path / "reach.py")
    assert "no problem found; --scene scene.ttt compares the names with a scene's" in page


def test_a_name_that_the_scene_lacks_is_a_problem_unless_the_program_brings_objects(tmp_path: Path) -> None:
    write(
        tmp_path,
        {"reach.py": PROGRAM, "scene.ttt": "", "scene.xml": "<mujoco model='scene'><worldbody/></mujoco>"},
    )
    code, record = check(tmp_path / "reach.py", "--scene", "scene.xml")
    assert code == 1
    assert texts_of(record)[0].startswith("no object 'target' in scene")
    (tmp_path / "reach.py").write_text(PROGRAM + "\nPyRep().import_model(SCENE)\n")
    assert check(tmp_path / "reach.py", "--scene", "scene.xml")[0] == 0


@pytest.mark.parametrize(
    ("imports", "called"),
    [
        ("from pyrep.backend import sim", "sim"),
        ("import pyrep.backend.sim as s", "s"),
        ("from pyrep.backend import sim", "sim.lib"),
        ("from pyrep.backend.sim import lib", "lib"),
        ("from pyrep.backend._sim_cffi import ffi, lib", "lib"),
    ],
)
@pytest.mark.parametrize("has_checkouts", [True, False])
def test_functions_of_the_c_library_that_are_not_provided_are_problems(
    tmp_path: Path, packages: Path, imports: str, called: str, has_checkouts: bool
) -> None:
    if not has_checkouts:
        (packages / "pyrep" / "backend" / "sim.py").unlink()
    text = f"{imports}\n{called}.simGetObjectHandle(b'it')\n{called}.simNoSuchThing(b'it')\n"
    write(tmp_path, {"script.py": text})
    code, record = check(tmp_path / "script.py")
    assert (code, list(record["pyrep"]["functions"])) == (1, ["simGetObjectHandle", "simNoSuchThing"])
    assert texts_of(record) == [
        "the C library has no function simNoSuchThing here; docs/pyrep-functions.md lists what there is"
    ]
    assert objects_of(record) == ["it"]


def test_functions_are_compared_without_cffi_too(tmp_path: Path) -> None:
    write(
        tmp_path,
        {
            "script.py": "from pyrep.backend import sim\nsim.simGetObjectHandle('it')\nsim.simGetObjectHandel()\n"
        },
    )
    code = "import sys; sys.modules['_cffi_backend'] = None; from simx_client.checking.command import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path / "script.py")], capture_output=True, text=True, timeout=60
    )
    assert (
        "problem: the C library has no function simGetObjectHandel here; did you mean 'simGetObjectHandle'"
        in done.stdout
    ), done.stderr
    assert done.stdout.endswith("1 problem\n")


def test_scene_and_model_files_that_are_not_there_are_problems(tmp_path: Path) -> None:
    text = """
        from pathlib import Path
        from pyrep import PyRep
        pr = PyRep()
        pr.launch(scene_file=str(Path(__file__).parent / "kitchen.ttt"))
        for name in ("cup.ttm", "missing.ttm"):
            pr.import_model("models/" + name)
        pr.launch("")
        def open_it(path): pr.launch(path)
        open_it(input())
        """
    write(tmp_path, {"script.py": text, "kitchn.ttt": "", "models/cup.ttm": ""})
    code, record = check(tmp_path / "script.py")
    assert code == 1
    assert texts_of(record) == [
        f"there is no scene file {tmp_path / 'kitchen.ttt'}; did you mean 'kitchn.ttt'?"
    ]


def test_packages_that_are_missing_are_named_with_the_line_that_installs_them(
    tmp_path: Path, packages: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTHONPATH", "")
    monkeypatch.setattr(sentences, "is_installed", lambda name: name != "cffi")
    write(tmp_path, {"reach.py": PROGRAM, "scene.ttt": "", "task.py": RLBENCH_PROGRAM})
    code, record = check(tmp_path / "reach.py")
    assert (code, texts_of(record)) == (0, [])
    _, pyrep, cffi = texts_of(record, "note")
    assert pyrep.startswith(f"PyRep is not installed here: {pyrep_line('pyrep')}; or put a checkout")
    assert cffi.startswith("PyRep needs cffi, which is not installed here: ")
    assert "cffi>=" in cffi
    # RLBench brings PyRep.
    _, rlbench, _ = texts_of(check(tmp_path / "task.py")[1], "note")
    assert rlbench.startswith(f"RLBench is not installed here: {pyrep_line('rlbench')}; ")


def test_an_rlbench_program_needs_its_scene_and_the_packages_of_a_checkout(
    tmp_path: Path, packages: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write(tmp_path, {"task.py": RLBENCH_PROGRAM})
    code, record = check(tmp_path / "task.py")
    assert (code, texts_of(record)) == (0, [])
    assert texts_of(record, "note")[0].startswith("it uses RLBench: run it with simx-run --pyrep ")
    assert list(record["pyrep"]["calls"])[1:] == [
        *("Environment.launch", "Environment.get_task.reset", "Environment.get_task"),
    ]
    (packages / "rlbench" / "task_design.ttt").unlink()
    monkeypatch.setattr(sentences, "is_installed", lambda name: name != "natsort")
    code, record = check(tmp_path / "task.py")
    assert code == 1
    (scene,) = texts_of(record)
    assert scene.startswith(
        f"RLBench opens its scene task_design.ttt, and {packages / 'rlbench'} has none: copy it"
    )
    (needs,) = texts_of(record, "note")[1:]
    assert needs == f"RLBench needs packages that are not installed here: {line(['natsort'])}"


def test_a_wrapper_of_the_legacy_remote_api_that_is_called_pyrep_is_followed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTHONPATH", "")
    files = {
        "script.py": "from pyrep import VRep\nVRep('it')\n",
        "pyrep/__init__.py": "from .api import VRep\n",
        "pyrep/api.py": f"import vrep\n{START}class VRep:\n"
        "  def __init__(self, n): vrep.simxGetObjectHandle(c, n, B)\n",
    }
    write(tmp_path, files)
    code, record = check(tmp_path / "script.py")
    assert (code, record["pyrep"], objects_of(record)) == (0, None, ["it"])
