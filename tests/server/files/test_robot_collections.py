"""Robots by name, from collections on the disk: no test downloads."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from simx_client.protocol.cli.installing import extra_line
from simx_server.app.scene_sources import sources_of
from simx_server.errors import CommandError
from simx_server.files import robot_collections
from simx_server.files.library import find_scene
from simx_server.scene.formats.loader import load_scene
from simx_server.settings.settings import Settings

SCENE = "<mujoco><worldbody><body name='go2'><freejoint/><geom size='0.1'/></body></worldbody></mujoco>"

XACRO = """<robot name="ur" xmlns:xacro="http://www.ros.org/wiki/xacro">
<xacro:arg name="name" default="ur"/><link name="$(arg name)_$(arg ur_type)"/></robot>"""

UR = "https://github.com/UniversalRobots/Universal_Robots_ROS2_Description.git"


@pytest.fixture
def menagerie(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    pytest.importorskip("mujoco_menagerie", reason=extra_line("robots"))
    (tmp_path / "unitree_go2").mkdir()
    for name in ("scene.xml", "go2.xml"):
        (tmp_path / "unitree_go2" / name).write_text(SCENE)
    monkeypatch.setenv("MENAGERIE_ROOT", str(tmp_path))
    return tmp_path


def test_robot_of_the_menagerie_is_found_by_its_name(menagerie: Path) -> None:
    assert find_scene("menagerie:unitree_go2") == menagerie / "unitree_go2" / "scene.xml"
    assert find_scene("menagerie:unitree_go2/go2") == menagerie / "unitree_go2" / "go2.xml"
    scene, _ = load_scene(find_scene("menagerie:unitree_go2"))
    assert scene.by_name("go2") is not None


def test_names_that_the_menagerie_lacks_are_told(menagerie: Path) -> None:
    with pytest.raises(CommandError, match=r"no robot 'menagerie:unitree_goo2'; did you mean 'unitree_go2'"):
        find_scene("menagerie:unitree_goo2")
    with pytest.raises(CommandError, match=r"has no entry point 'none'; available: .*scene"):
        find_scene("menagerie:unitree_go2/none")
    with pytest.raises(CommandError, match=r"'menagerie:unitree_a1' cannot be downloaded: .*not found"):
        find_scene("menagerie:unitree_a1")


@pytest.fixture
def clone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A repository on the disk in the place of one on the network."""
    pytest.importorskip("robot_descriptions", reason=extra_line("robots"))
    pytest.importorskip("xacro", reason=extra_line("urdf"))
    (tmp_path / "there" / "urdf").mkdir(parents=True)
    (tmp_path / "there" / "urdf" / "ur.urdf.xacro").write_text(XACRO)
    identity = ("-c", "user.name=a", "-c", "user.email=a@example.org", "-c", "commit.gpgsign=false")
    for words in (("init", "-q"), ("add", "."), (*identity, "commit", "-qm", "a")):
        subprocess.run(["git", *words], cwd=tmp_path / "there", check=True)
    done = subprocess.run(
        ["git", "rev-parse", "HEAD"], cwd=tmp_path / "there", check=True, capture_output=True
    )
    for name, value in {
        "GIT_CONFIG_COUNT": "1",
        "GIT_CONFIG_KEY_0": f"url.{(tmp_path / 'there').as_uri()}.insteadOf",
        "GIT_CONFIG_VALUE_0": UR,
        "ROBOT_DESCRIPTION_COMMIT": done.stdout.decode().strip(),
        "ROBOT_DESCRIPTIONS_CACHE": str(tmp_path / "cache"),
    }.items():
        monkeypatch.setenv(name, value)
    monkeypatch.delitem(sys.modules, "robot_descriptions.ur5e_description", raising=False)
    return tmp_path


def test_description_is_cloned_and_gets_its_arguments(clone: Path, capfd: pytest.CaptureFixture[str]) -> None:
    found = find_scene("robot_descriptions:ur5e")
    assert found.is_relative_to(clone / "cache")
    assert capfd.readouterr().out == "", "the log goes to stderr"
    sources = sources_of(Settings(scene="robot_descriptions:ur5e", xacro=("name:=mine",)))
    assert sources.xacro_arguments == {"name": "mine", "ur_type": "ur5e"}
    scene, _ = load_scene(found, sources)
    assert scene.by_name("mine_ur5e") is not None


def test_description_that_cannot_be_cloned_is_told(clone: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROBOT_DESCRIPTION_COMMIT", "0" * 40)
    with pytest.raises(CommandError, match=r"'robot_descriptions:ur5e' cannot be downloaded"):
        find_scene("robot_descriptions:ur5e")
    with pytest.raises(CommandError, match=r"no robot 'robot_descriptions:ur5f_description'; did you mean"):
        find_scene("robot_descriptions:ur5f_description")


@pytest.mark.parametrize("name", ["menagerie:unitree_go2", "robot_descriptions:ur5e"])
def test_without_the_library_the_error_says_how_to_install_it(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(robot_collections.importlib.util, "find_spec", lambda _: None)
    with pytest.raises(CommandError, match=r"which is not installed: .*mujoco-menagerie.*robot-descriptions"):
        find_scene(name)
