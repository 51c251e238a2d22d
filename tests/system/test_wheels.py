"""Both wheels are built, installed into clean environments without a network, and used there."""

from __future__ import annotations

import configparser
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tomllib
import venv
import zipfile
from email.message import Message
from email.parser import Parser
from pathlib import Path

import pytest
from audit import needed, required
from packaging.requirements import Requirement
from processes import ROOT, server

from simx_client.protocol.version import __version__

pytestmark = [pytest.mark.slow, pytest.mark.gl]

pytest.importorskip("hatchling")
pytest.importorskip("pip")

CLIENT = ROOT / "packages" / "client"
WHOLE = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
FOR_CLIENT = ["eclipse-zenoh", "msgpack"]
COMMANDS = {
    "simx-run": "simx_client.launch.run:main",
    "simx-check": "simx_client.checking.command:main",
    "simx": "simx_client.__main__:main",
}

SCENE = """
<mujoco>
  <worldbody>
    <light pos="0 0 3"/>
    <geom name="floor" type="plane" size="2 2 0.1" rgba="0.2 0.6 0.3 1"/>
    <camera name="eye" pos="0 0 2" resolution="8 4"/>
    <body name="arm" pos="0 0 1">
      <joint name="hinge" axis="0 1 0"/>
      <geom name="rod" type="capsule" fromto="0 0 0 0 0 -0.5" size="0.02"/>
    </body>
  </worldbody>
</mujoco>
"""

OLD_SCRIPT = """
import sys
import vrep

missing = []
for name in ("numpy", "mujoco", "cv2", "fissix", "simx_server"):
    try:
        __import__(name)
    except ModuleNotFoundError:
        missing.append(name)
wait = vrep.simx_opmode_blocking
client = vrep.simxStart("127.0.0.1", int(sys.argv[1]), True, True, 5000, 5)
code1, joint = vrep.simxGetObjectHandle(client, "hinge", wait)
code2, angle = vrep.simxGetJointPosition(client, joint, wait)
code3, camera = vrep.simxGetObjectHandle(client, "eye", wait)
code4, size, image = vrep.simxGetVisionSensorImage(client, camera, 0, wait)
vrep.simxFinish(client)
print(missing, (code1, code2, code3, code4), angle, size, len(image))
"""

PYTHON_2 = "import vrep\nprint 'half of three is', 3 / 2\n"


class Environment:
    """A virtual environment that sees a few packages of the one in which the tests run."""

    def __init__(self, folder: Path, packages: list[str]) -> None:
        venv.create(folder, with_pip=False, symlinks=sys.platform != "win32")
        self._programs = next(folder.glob("bin"), folder / "Scripts")
        self._python = str(self._programs / "python")
        asked = self.run(self._python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))")
        here = Path(asked.stdout.strip())
        for distribution in needed(packages):
            for top in {file.parts[0] for file in distribution.files or () if file.parts[0] != ".."}:
                if not (here / top).exists():
                    (here / top).symlink_to(str(distribution.locate_file(top)))

    def install(self, wheel: Path) -> None:
        """Install a wheel with pip, which refuses where a requirement is missing."""
        # Python compiles what is used; pip would compile all.
        options = ("--no-index", "--no-compile", "--quiet", "--disable-pip-version-check")
        pip = (sys.executable, "-m", "pip", "--python", self._python)
        done = self.run(*pip, "install", *options, wheel)
        assert done.returncode == 0, done.stderr
        check = self.run(*pip, "check", "--disable-pip-version-check")
        assert check.returncode == 0, check.stdout

    def program(self, name: str, *arguments: object) -> subprocess.CompletedProcess[str]:
        """Run an installed command."""
        return self.run(self._programs / name, *arguments)

    def python(self, *arguments: object) -> subprocess.CompletedProcess[str]:
        return self.run(self._python, *arguments)

    def run(self, *command: object) -> subprocess.CompletedProcess[str]:
        clean = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
        words = list(map(str, command))
        return subprocess.run(
            words, cwd=self._programs, env=clean, capture_output=True, text=True, timeout=60
        )


def build(project: Path, folder: Path, *targets: str) -> list[Path]:
    words = [word for target in targets for word in ("-t", target)]
    command = [sys.executable, "-m", "hatchling", "build", "-d", str(folder), *words]
    done = subprocess.run(command, cwd=project, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return sorted(folder.iterdir())


@pytest.fixture(scope="module")
def wheel_of_client(tmp_path_factory: pytest.TempPathFactory) -> Path:
    (wheel,) = build(CLIENT, tmp_path_factory.mktemp("client"), "wheel")
    return wheel


@pytest.fixture(scope="module")
def wheel_of_whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    (wheel,) = build(ROOT, tmp_path_factory.mktemp("whole"), "wheel")
    return wheel


@pytest.fixture(scope="module")
def client_alone(wheel_of_client: Path, tmp_path_factory: pytest.TempPathFactory) -> Environment:
    environment = Environment(tmp_path_factory.mktemp("client_alone"), FOR_CLIENT)
    environment.install(wheel_of_client)
    return environment


@pytest.fixture(scope="module")
def whole(wheel_of_whole: Path, tmp_path_factory: pytest.TempPathFactory) -> Environment:
    environment = Environment(tmp_path_factory.mktemp("whole_installed"), required())
    environment.install(wheel_of_whole)
    return environment


def can_compile() -> bool:
    """Whether there are a C compiler and Python's headers, as far as this test can see."""
    has_compiler = any(map(shutil.which, ("cc", "gcc", "clang")))
    return has_compiler and Path(sysconfig.get_path("include"), "Python.h").exists()


def read(wheel: Path) -> tuple[Message, dict[str, str], dict[str, bytes]]:
    """The metadata, the commands, and the files of the packages."""
    with zipfile.ZipFile(wheel) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    (about,) = (text for name, text in files.items() if name.endswith(".dist-info/METADATA"))
    (entries,) = (text for name, text in files.items() if name.endswith(".dist-info/entry_points.txt"))
    parser = configparser.ConfigParser()
    parser.read_string(entries.decode())
    packages = {name: text for name, text in files.items() if ".dist-info/" not in name}
    return Parser().parsestr(about.decode()), dict(parser["console_scripts"]), packages


def test_the_clients_wheel_says_what_the_whole_says(wheel_of_client: Path, wheel_of_whole: Path) -> None:
    """Version, requirements, licence and files are those of the whole, or a part of them."""
    (client, commands, files), (whole, all_commands, all_files) = read(wheel_of_client), read(wheel_of_whole)
    assert (client["Name"], whole["Name"]) == ("simx-vrep-client", "simx-vrep")
    assert client["Version"] == whole["Version"] == __version__
    for field in ("Requires-Python", "License-Expression", "Author", "Keywords", "Classifier"):
        assert client.get_all(field) == whole.get_all(field), field
    required_here = {Requirement(text) for text in client.get_all("Requires-Dist", ())}
    always = {each for each in required_here if each.marker is None}
    assert {each.name for each in always} == set(FOR_CLIENT)
    assert always <= {Requirement(text) for text in WHOLE["dependencies"]}
    extras: dict[str, list[str]] = {}
    for each in required_here - always:
        (extra,) = re.findall(r'^extra == "(\w+)"$', str(each.marker))
        each.marker = None
        extras.setdefault(extra, []).append(str(each))
    assert extras.keys() == {"python2", "gym", "learning", "ray"}
    (python2,) = extras.pop("python2")
    assert python2 in WHOLE["dependencies"]
    for extra, packages in extras.items():
        own = [str(Requirement(text)) for text in WHOLE["optional-dependencies"][extra]]
        assert sorted(packages) == sorted(own)
    assert commands == COMMANDS
    assert all_commands == {**COMMANDS, "simx-server": "simx_server.app.cli:main"}
    assert files == {name: text for name, text in all_files.items() if name.startswith("simx_client/")}
    assert (CLIENT / "LICENSE").read_bytes() == (ROOT / "LICENSE").read_bytes()


def test_a_source_archive_of_the_client_makes_the_same_wheel(wheel_of_client: Path, tmp_path: Path) -> None:
    (archive,) = build(CLIENT, tmp_path / "archive", "sdist")
    options = ("--no-index", "--no-build-isolation", "--no-deps", "--quiet", "--disable-pip-version-check")
    command = [sys.executable, "-m", "pip", "wheel", *options, "-w", tmp_path / "wheels", archive]
    done = subprocess.run(list(map(str, command)), cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    (wheel,) = (tmp_path / "wheels").iterdir()
    (about, commands, files), (first, *rest) = read(wheel), read(wheel_of_client)
    assert sorted(about.items()) == sorted(first.items())
    assert [commands, files] == rest


def test_the_client_alone_drives_a_server_elsewhere(client_alone: Environment, tmp_path: Path) -> None:
    scene, script = tmp_path / "scene.xml", tmp_path / "old.py"
    scene.write_text(SCENE, encoding="utf-8")
    script.write_text(OLD_SCRIPT, encoding="utf-8")
    with server(scene) as there:
        done = client_alone.program("simx-run", script, there.port)
        status = client_alone.program("simx", "status", f"127.0.0.1:{there.port}")
        there.process.terminate()
        assert there.process.wait(10) == 0
    missing = ["numpy", "mujoco", "cv2", "fissix", "simx_server"]
    assert done.stdout == f"{missing} (0, 0, 0, 0) 0.0 [8, 4] 96\n", done.stderr
    assert (done.returncode, status.returncode) == (0, 0), status.stderr


def test_the_client_alone_says_what_needs_more(client_alone: Environment, tmp_path: Path) -> None:
    script, python_2 = tmp_path / "old.py", tmp_path / "older.py"
    script.write_text(OLD_SCRIPT, encoding="utf-8")
    python_2.write_text(PYTHON_2, encoding="utf-8")
    (fissix,) = (text for text in WHOLE["dependencies"] if text.startswith("fissix"))
    for program in ("simx-run", "simx-check"):
        done = client_alone.program(program, python_2)
        assert (done.returncode, done.stderr.count("\n")) == (2, 1), done.stderr
        assert f"install '{fissix}'" in done.stderr
    for words in (("simx-run", "--server", "ur5", script), ("simx-check", script, "--scene", "ur5")):
        done = client_alone.program(*words)
        assert (done.returncode != 0, done.stderr.count("\n")) == (True, 1), done.stderr
        assert "install simx-vrep instead of simx-vrep-client" in done.stderr
    assert client_alone.program("simx-check", script).returncode == 0


def test_every_module_of_the_client_alone_can_be_imported(client_alone: Environment) -> None:
    """Exceptions: the windows for OpenCV's calls, which load once a script has imported OpenCV, environments, which
    need Gymnasium, PyRep's library, which needs cffi and a server, the package of API 2, which needs pyzmq, random
    values, which need NumPy, and the tools of agents, which need mcp."""
    modules = [
        ".".join(path.relative_to(ROOT).with_suffix("").parts)
        for path in sorted((ROOT / "simx_client").rglob("*.py"))
    ]
    need_more = (
        *(".windows.desk.", "simx_client.gym.", "simx_client.pyrep.", "simx_client.api2."),
        *("simx_client.randomization.", "protocol.random_values.", "simx_client.agents."),
    )
    lines = [f"import {module}" for module in modules if not any(part in f"{module}." for part in need_more)]
    assert len(lines) > 100
    done = client_alone.python("-W", "error", "-c", "\n".join(lines))
    assert done.returncode == 0, done.stderr


def test_the_whole_wheel_runs_a_script_on_a_shipped_scene(whole: Environment, tmp_path: Path) -> None:
    script = tmp_path / "older.py"
    script.write_text(PYTHON_2 + "vrep.simxFinish(-1)\n", encoding="utf-8")
    done = whole.program("simx-run", "--server", "inverted_pendulum", script)
    assert (done.returncode, done.stdout) == (0, "half of three is 1\n"), done.stderr
    where = whole.python("-c", "import simx_server; print(simx_server.__file__)")
    assert "site-packages" in where.stdout


def test_the_whole_wheel_has_every_module_in_c_compiled_for_the_installed_mujoco(
    whole: Environment, wheel_of_whole: Path
) -> None:
    if wheel_of_whole.name.endswith("-none-any.whl"):
        assert not can_compile(), "there is a compiler, and the wheel has no module"
        pytest.skip("no C compiler or no headers of Python: apt-get install gcc python3-dev")
    names = [
        ".".join(path.relative_to(ROOT).with_suffix("").parts)
        for path in sorted(ROOT.glob("simx_server/**/native/*.c"))
    ]
    text = (
        f"import importlib, mujoco; modules = list(map(importlib.import_module, {names})); "
        "print({len(each.SOURCE_HASH) for each in modules}, "
        "{each.HEADER for each in modules if hasattr(each, 'HEADER')} == {mujoco.mj_version()})"
    )
    done = whole.python("-c", text)
    assert (done.stdout, done.stderr) == ("{16} True\n", "")
