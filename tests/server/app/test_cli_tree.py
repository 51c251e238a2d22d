"""``simx-server SCENE --tree``: what a script will find in a scene, without a server being started."""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any

import pytest

from simx_client.protocol.cli.terminal import Paint
from simx_server.app import cli
from simx_server.scripting.outline import functions_in, signals_in

SCENE = """
<mujoco>
  <worldbody>
    <body name="base">
      <geom size="0.1" mass="1"/>
      <body name="arm" pos="0 0 1">
        <joint name="hinge" axis="0 1 0"/>
        <geom size="0.1" mass="1"/>
        <camera name="eye" resolution="32 24"/>
        <body name="slider"><joint name="rail" type="slide"/><geom size="0.1" mass="1"/></body>
      </body>
    </body>
    <site name="mark"/>
    <site name="clock"/>
  </worldbody>
  <custom>
    <text name="simx:object:clock" data="type=script"/>
    <text name="simx:lua:clock" data="function sysCall_init() end"/>
    <text name="simx:lua:base" data="function openHand(a) end&#10;local function hidden() end"/>
    <text name="simx:collection:both" data="objects=base,arm"/>
  </custom>
</mujoco>
"""


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self) -> bool:
        return True


@pytest.fixture
def scene(tmp_path: Path) -> str:
    path = tmp_path / "small.xml"
    path.write_text(SCENE)
    return str(path)


def tree(capsys: pytest.CaptureFixture[str], scene: str) -> dict[str, Any]:
    assert cli.main([scene, "--tree", "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_people_see_handle_name_under_its_parent_type_and_script(
    scene: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main([scene, "--tree"]) == 0
    head, *lines = capsys.readouterr().out.splitlines()
    assert head.startswith("small: 8 objects (")
    assert lines == [
        "     1  mark            dummy",
        "     2  clock           script               child script clock.lua",
        "     3  base            shape                child script base.lua",
        "     4    hinge         joint revolute",
        "     5      arm         shape",
        "     6        eye       vision sensor 32x24",
        "     7        rail      joint prismatic",
        "     8          slider  shape",
        "collection: both",
    ]


def test_programs_get_types_parents_paths_and_what_scripts_offer(
    scene: str, capsys: pytest.CaptureFixture[str]
) -> None:
    record = tree(capsys, scene)
    objects = {each["name"]: each for each in record["objects"]}
    assert objects["eye"]["path"] == "/base/hinge/arm/eye"
    assert objects["eye"]["resolution"] == [32, 24]
    assert (objects["slider"]["parent_name"], objects["slider"]["parent"]) == ("rail", 7)
    assert (objects["mark"]["parent_name"], objects["mark"]["parent"]) == (None, -1)
    [script] = objects["base"]["scripts"]
    assert (script["type"], script["functions"]) == ("child", ["openHand"])
    assert record["registered"]["collection"] == ["both"]


def test_flags_that_add_objects_count(scene: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([scene, "--tree", "--json", "--command-server"]) == 0
    names = [each["name"] for each in json.loads(capsys.readouterr().out)["objects"]]
    assert "remoteApiCommandServer" in names


def test_wrong_scene_is_a_failure_that_lists_the_shipped_ones(
    capsys: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    assert cli.main(["no_such_scene", "--tree"]) == 1
    assert capsys.readouterr().out == ""
    assert "no scene 'no_such_scene'; looked in " in caplog.text
    assert " and among the shipped scenes: " in caplog.text


def test_only_one_page_at_a_time(capsys: pytest.CaptureFixture[str]) -> None:
    for flags in (["--tree", "--commands"], ["--tree", "--markdown"], ["--tree", "--json", "--markdown"]):
        with pytest.raises(SystemExit) as left:
            cli.main(flags)
        assert left.value.code == 2
        assert "valid: " in capsys.readouterr().err


def test_colours_are_for_terminals_that_want_them(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setenv("TERM", "xterm")
    assert Paint(Terminal())("bad", "red") == "\x1b[31mbad\x1b[0m"
    assert Paint(io.StringIO())("bad", "red") == "bad"
    monkeypatch.setenv("NO_COLOR", "1")
    assert Paint(Terminal())("bad", "red") == "bad"
    monkeypatch.delenv("NO_COLOR")
    monkeypatch.setenv("TERM", "dumb")
    assert Paint(Terminal())("bad", "red") == "bad"


def test_outline_of_a_script_finds_functions_and_signals() -> None:
    lua = """
    -- function commented() end
    function rg2Open(a, b) sim.setIntegerSignal('open', 1) end
    close = function() simGetFloatSignal("width" .. i) end
    local function hidden() end
    """
    assert functions_in(lua, "lua") == ["rg2Open", "close"]
    assert signals_in(lua, "lua") == ["open", "width*"]
    python = "def grip(a):\n    sim.setStringSignal('text', a)\n    def inner(): pass\n# def no(): pass\n"
    assert functions_in(python, "python") == ["grip"]
    assert signals_in(python, "python") == ["text"]
