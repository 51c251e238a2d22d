"""The examples in the help texts, and those of docs/command-line.md, work as they are written."""

from __future__ import annotations

import argparse
import re
import shlex
import subprocess
import sys
import time
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from types import ModuleType

import pytest
from processes import PENDULUM, ROOT, ServerProcess, server, wait_until

from simx_client import Client
from simx_client import __main__ as simx
from simx_client.checking import command as check
from simx_client.launch import run
from simx_client.transport.redirect import VARIABLE, format_redirects
from simx_server.app import cli
from simx_server.classroom import command as classroom
from simx_server.settings.settings import Settings
from simx_server.viewer.page import command as view

pytestmark = pytest.mark.slow

SCRIPT = """
import vrep, sys
client = vrep.simxStart("127.0.0.1", 19997, True, True, 5000, 5)
assert client != -1
vrep.simxFinish(client)
print("it ran", *sys.argv[1:])
"""

PYREP_PROGRAM = """
from pyrep.backend._sim_cffi import lib
assert lib.simExtCanInitSimThread() == 0
print("it ran")
"""

PROGRAM = re.compile(r"(?:source <\()?((?:simx-\w+|simx|python -m simx_\w+(?:\.\w+)?)(?= |$).*)")


def examples(text: str) -> list[str]:
    """Command lines of an indented list, without what is said beside them and where their output goes."""
    found = re.findall(
        rf"^ +{PROGRAM.pattern}", text.partition("examples:")[2] or text.partition("example:")[2], re.M
    )
    return [re.split(r"\)? {2,}|\)$| > |\)? +#", line)[0] for line in found]


def of_help(parser: argparse.ArgumentParser) -> list[str]:
    return examples(parser.format_help())


COMMANDS = [
    example
    for name, (_, module) in simx.COMMANDS.items()
    # A fleet needs a Ray cluster (tests/client/fleet/), a class serves until it is ended, two recordings
    # have a test of their own (tests/server/recording/test_diff.py), as other commands have.
    if name not in ("check", "classroom", "compare", "diff", "export", "fit", "fleet", "grade", "mcp", "run")
    for example in of_help(import_module(module).make_parser())
]
PAGE = examples("examples:\n" + (ROOT / "docs" / "command-line.md").read_text(encoding="utf-8"))
OF_PAGE = [line for line in PAGE if line.startswith("simx ") and not line.startswith("simx classroom ")]


def test_examples_are_found() -> None:
    assert len(COMMANDS) >= 20
    assert {words[3] for words in map(shlex.split, COMMANDS)} == {
        *("call", "watch", "past", "image", "completion", "status", "shims")
    }
    assert len(OF_PAGE) >= 9


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A folder with the files that examples name; servers of others on this machine are not listed."""
    folder = tmp_path_factory.mktemp("examples")
    for name in ("robotControl.py", "script.py"):
        (folder / name).write_text(SCRIPT)
    for name in ("scene.xml", "my_robot.xml"):
        (folder / name).write_text(PENDULUM)
    (folder / "reach.py").write_text(PYREP_PROGRAM)
    (folder / "pyrep" / "backend").mkdir(parents=True)
    (folder / "my_project" / "simulation").mkdir(parents=True)
    with pytest.MonkeyPatch.context() as environment:
        environment.setenv("XDG_RUNTIME_DIR", str(folder))
        environment.setenv("MUJOCO_GL", "disable")  # images are made everywhere, and at once
        yield folder


@pytest.fixture(scope="module")
def lab(place: Path) -> Iterator[ServerProcess]:
    """The tutorial's scene, under the name that examples use, with the steps of its run."""
    with server("ur5_rg2_kinect", "--realm", "lab-3", "--start", "--history", 600) as process:
        with Client(port=process.port) as client:
            assert wait_until(lambda: client.simulation.time > 0.15, 60)  # examples look back to step 2
        yield process


def in_words(example: str, port: int) -> list[str]:
    """The words after the program, with this server's port; what would go on for ever prints a line, soon."""
    words = shlex.split(
        re.sub(r"\b1999[79]\b", str(port), example).replace("router:7447", f"127.0.0.1:{port}")
    )
    words = words[1:] if words[0] == "simx" else words[3:]
    if "--every" in words:
        words[words.index("--every") + 1] = "0.01"
    if words[0] == "watch" and "--count" not in words:
        words += ["--count", "1"]
    if words[0] in ("call", "watch", "past", "image", "status"):
        words += ["--timeout", "60"]  # the machine may be busy
    return words


@pytest.mark.parametrize("example", [*COMMANDS, *OF_PAGE])
def test_example_of_a_command_works(
    example: str,
    place: Path,
    lab: ServerProcess,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(place)
    words = in_words(example, lab.port)
    if "--watch" in words:

        def interrupt(seconds: float) -> None:
            raise KeyboardInterrupt

        monkeypatch.setattr(time, "sleep", interrupt)
    code = simx.main(words)
    said = capfd.readouterr()
    assert code == (130 if "--watch" in words else 0), said.err
    assert said.out or words[1] in (
        "simxSetJointTargetPosition",
        "simxSetObjectPosition",
        "simxStartSimulation",
    )


@pytest.mark.parametrize("example", of_help(cli.make_parser()))
def test_example_of_the_server_starts_it(example: str, place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    served: list[Settings] = []

    def serve(settings: Settings, *_: object) -> int:
        served.append(settings)
        return 0

    for name in ("server", "fleet"):
        stand_in = ModuleType(f"simx_server.app.{name}")
        stand_in.serve = serve  # pyright: ignore[reportAttributeAccessIssue]
        monkeypatch.setitem(sys.modules, stand_in.__name__, stand_in)
    monkeypatch.chdir(place)
    words = shlex.split(example)
    assert words[0] == "simx-server"
    assert cli.main(words[1:]) == 0
    assert len(served) == 1


@pytest.mark.parametrize("example", of_help(run.make_parser()))
def test_example_of_simx_run_runs_the_script(
    example: str, place: Path, lab: ServerProcess, monkeypatch: pytest.MonkeyPatch
) -> None:
    words = shlex.split(example)
    assert words[0] == "simx-run"
    monkeypatch.setenv(VARIABLE, format_redirects({19997: ("127.0.0.1", lab.port)}))
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    command = [sys.executable, "-m", "simx_client.launch.run", *words[1:]]
    done = subprocess.run(command, cwd=place, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert "it ran" in done.stdout


@pytest.mark.parametrize("example", of_help(check.make_parser()))
def test_example_of_simx_check_checks(
    example: str, place: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(place)
    words = shlex.split(example)
    assert words[0] == "simx-check"
    assert check.main(words[1:]) == 0
    assert "simxStart" in capsys.readouterr().out


@pytest.mark.parametrize("example", of_help(classroom.make_parser()))
def test_example_of_a_class_is_understood(
    example: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "class_7b.txt").write_text("Ada\nBen\n")
    monkeypatch.chdir(tmp_path)
    words = shlex.split(example)
    assert words[:2] == ["simx", "classroom"]
    assert classroom.make_parser().parse_args(words[2:]).scene


@pytest.mark.parametrize("example", of_help(view.make_parser()))
def test_example_of_the_viewer_is_understood(example: str) -> None:
    words = shlex.split(example)
    assert words[:3] == ["python", "-m", "simx_server.viewer"]
    assert view.make_parser().parse_args(words[3:]).server
