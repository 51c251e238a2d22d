"""``python -m simx_client completion``: what shells complete, asked of the shells themselves where they are there."""

from __future__ import annotations

import io
import shutil
import subprocess
import tomllib
from collections.abc import Callable
from pathlib import Path

import pytest
from launching import python

from simx_client import __main__ as program
from simx_client.cli.command_parser import SCRIPT
from simx_client.cli.completion import PROGRAMS, programs
from simx_client.protocol.commands import BY_NAME
from simx_server.files.library import list_scenes
from simx_server.settings.settings import SETTINGS

ROOT = Path(__file__).parents[3]
SHELLS = ("bash", "zsh", "fish")
Complete = Callable[..., list[str]]

ASK_BASH = """
source "$1"; shift
COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1))
$(complete -p "$1" | sed 's/.*-F \\([^ ]*\\).*/\\1/')
printf '%s\\n' "${COMPREPLY[@]}"
"""


@pytest.fixture(scope="module")
def scripts(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """The scripts, in files."""
    folder = tmp_path_factory.mktemp("completion")
    made: dict[str, Path] = {}
    for shell in SHELLS:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr("sys.stdout", text := io.StringIO())
            assert program.main(["completion", shell]) == 0
        made[shell] = folder / f"script.{shell}"
        made[shell].write_text(text.getvalue())
    return made


@pytest.fixture(scope="module")
def complete(scripts: dict[str, Path]) -> Complete:
    """Completions of bash for the last of these words."""
    if shutil.which("bash") is None:
        pytest.skip("no bash on this machine")

    def ask(*words: str) -> list[str]:
        command = ["bash", "--norc", "-c", ASK_BASH, "bash", str(scripts["bash"]), *words]
        done = subprocess.run(command, capture_output=True, text=True, timeout=30, cwd=ROOT)
        assert (done.returncode, done.stderr) == (0, "")
        return done.stdout.split()

    return ask


def test_flags_and_their_values_are_offered(complete: Complete) -> None:
    assert complete("simx-server", "--wor") == ["--workspace"]
    assert complete("simx-server", "--log-level", "") == ["debug", "info", "warning", "error"]
    assert complete("simx-server", "--port", "") == []
    assert complete("simx-server", "ur5_rg2_kinect")[0] == "ur5_rg2_kinect"
    assert complete("simx-check", "--scene", "ur5_rg2_kinect")[0] == "ur5_rg2_kinect"


def test_files_and_folders_are_offered_where_they_belong(complete: Complete) -> None:
    assert complete("simx-run", "pyproj") == ["pyproject.toml"]
    assert complete("simx-server", "--workspace", "pyproj") == []
    assert complete("simx-server", "--workspace", "simx_cl") == ["simx_client"]


def test_commands_and_functions_are_offered(complete: Complete) -> None:
    assert complete(SCRIPT, "wa") == ["watch"]
    assert complete(SCRIPT, "call", "simxGetJointPos") == ["simxGetJointPosition"]
    assert complete(SCRIPT, "watch", "simxGetJointPos") == ["simxGetJointPosition"]
    assert complete(SCRIPT, "watch", "simxSet") == []
    assert complete(SCRIPT, "watch", "--ev") == ["--every"]


@pytest.mark.parametrize("shell", [shell for shell in SHELLS if shutil.which(shell)])
def test_the_shell_can_read_its_script(scripts: dict[str, Path], shell: str) -> None:
    done = subprocess.run([shell, "-n", str(scripts[shell])], capture_output=True, text=True, timeout=30)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("shell", SHELLS)
def test_every_flag_command_function_and_scene_is_in_it(scripts: dict[str, Path], shell: str) -> None:
    text = scripts[shell].read_text()
    flags = [setting.flag for setting in SETTINGS.values() if not setting.is_positional]
    if shell == "fish":
        assert all(f" -l {flag[2:]}" in text for flag in flags)
    else:
        assert all(flag in text for flag in flags)
    for word in (*program.COMMANDS, *list_scenes(), "simxGetObjectHandle", "simxSetJointTargetPosition"):
        assert word in text
    assert "simxPackInts" not in text  # asks no server for anything


def test_every_console_script_is_completed() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    scripts = set(project["project"]["scripts"])
    assert {each.name for each in programs()} == scripts == {"simx-server", *PROGRAMS, SCRIPT}


def test_functions_that_are_offered_exist() -> None:
    [client] = [each for each in programs() if each.name == SCRIPT]
    for name in ("call", "watch"):
        words = client.commands[name][1].value.words
        assert len(words) > 40
        assert set(words) <= set(BY_NAME)


def test_an_unknown_shell_is_wrong_use(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        program.main(["completion", "csh"])
    assert left.value.code == 2
    assert "csh" in capsys.readouterr().err


def test_the_parsers_need_no_simulator(tmp_path: Path) -> None:
    """Help and completion are for people who wait: MuJoCo alone takes longer than all parsers."""
    code = """
import sys
from simx_client.cli.completion import programs
programs()
print({"mujoco", "zenoh", "numpy", "cv2"} & set(sys.modules))
"""
    assert python(tmp_path, "-c", code).stdout.strip() == "set()"
