"""docs/api.md is what the table says now, and the example of each function runs."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest
from processes import ROOT
from real_world import RealWorld, handle_of, step

import simx_client as v
from simx_client.protocol.commands import BY_NAME, TABLE, Place

pytestmark = pytest.mark.slow

PAGE = (ROOT / "docs" / "api.md").read_text(encoding="utf-8")
EXAMPLES = dict(re.findall(r"^## (simx\w+)\n\n    (.*)$", PAGE, re.MULTILINE))
ELSEWHERE = {"simxStart", "simxFinish", "simxQuery"}
"""The first two are of a real connection, the third needs a script that answers: other tests have them."""

WHILE_STOPPED = {"simxLoadScene", "simxCloseScene", "simxSetFloatingParameter"}
NEEDS_A_FILE = {"simxTransferFile", "simxEraseFile"}
SCENE = """
<mujoco>
  <worldbody>
    <body name="box" pos="0.5 0 1"><freejoint/><geom type="box" size="0.1 0.1 0.1" mass="1"/></body>
    <body name="base">
      <geom type="box" size="0.1 0.1 0.1"/>
      <camera name="camera" pos="0 -2 1" xyaxes="1 0 0 0 0 1" resolution="32 24"/>
      <site name="proximity_sensor" pos="0 0 0.2"/>
      <body name="arm"><joint name="joint" axis="0 0 1"/><geom size="0.05" pos="0.3 0 0"/></body>
      <body name="swing" pos="0 1 1"><joint name="ball_joint" type="ball"/><geom size="0.05"/></body>
      <body pos="0 -1 1"><site name="force_sensor"/><geom size="0.05"/></body>
    </body>
  </worldbody>
  <actuator><velocity joint="joint" kv="10"/></actuator>
  <sensor>
    <rangefinder site="proximity_sensor"/><force site="force_sensor"/><torque site="force_sensor"/>
  </sensor>
  <custom>
    <text name="simx:collision:bump" data="entity1=box entity2=base"/>
    <text name="simx:distance:gap" data="entity1=box entity2=base"/>
    <text name="simx:collection:robot" data="tree=base"/>
    <text name="simx:model:base" data="base=yes"/>
    <text name="simx:ui:panel" data="file=panel.toml"/>
    <text name="simx:lua:base" data="function double(i, f, s, b) return {2 * i[1]}, f, s, b end"/>
  </custom>
</mujoco>
"""
PANEL = """
[[ui]]
name = "panel"
[[ui.element]]
id = 3
kind = "slider"
place = [0, 0, 4, 1]
"""
OBJECTS = ("box", "base", "camera", "proximity_sensor", "force_sensor", "joint", "ball_joint")


def test_the_page_is_fresh() -> None:
    made = subprocess.run(
        [sys.executable, ROOT / "docs" / "reference.py"], capture_output=True, text=True, check=True, cwd=ROOT
    )
    assert made.stdout == PAGE, "run: python docs/reference.py > docs/api.md"


def test_every_function_has_a_section_with_an_example_and_all_its_names() -> None:
    assert list(EXAMPLES) == [command.name for command in TABLE if command.place is not Place.CARRIED]
    assert set(re.findall(r"\bsimx[A-Z]\w+", PAGE)) >= set(BY_NAME) - {
        c.name for c in TABLE if c.place is Place.CARRIED
    }


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("api")
    (folder / "scene.xml").write_text(SCENE)
    (folder / "panel.toml").write_text(PANEL)
    (folder / "table.stl").write_bytes(b"any bytes")
    return folder


@pytest.fixture
def client(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[int]:
    monkeypatch.setenv("MUJOCO_GL", "disable")
    monkeypatch.chdir(folder)
    workspace = folder / "workspace"
    workspace.mkdir(exist_ok=True)
    world = RealWorld(folder / "scene.xml", workspace=workspace)
    yield world.client()
    world.close()


def prepare(client: int, name: str) -> dict[str, int]:
    """What an example of this function takes for granted: handles by their names, and a running simulation."""
    blocking = v.simx_opmode_blocking
    handles = {each: handle_of(client, each) for each in OBJECTS}
    handles["collision"] = v.simxGetCollisionHandle(client, "bump", blocking)[1]
    handles["distance"] = v.simxGetDistanceHandle(client, "gap", blocking)[1]
    handles["ui"] = v.simxGetUIHandle(client, "panel", blocking)[1]
    if name in NEEDS_A_FILE:
        assert v.simxTransferFile(client, "table.stl", "table.stl", 0, blocking) == 0
    if name in WHILE_STOPPED:
        return handles
    assert v.simxSynchronous(client, True) == 0
    assert v.simxStartSimulation(client, blocking) == 0
    step(client, 0.1)
    handles["console"] = v.simxAuxiliaryConsoleOpen(client, "log", 10, 0, None, None, None, None, blocking)[1]
    style = v.sim_dlgstyle_input
    handles["dialog"] = v.simxDisplayDialog(client, "", "Go on?", style, "", None, None, blocking)[1]
    assert v.simxSetFloatSignal(client, "speed", 1.0, blocking) == 0
    assert v.simxSetIntegerSignal(client, "speed", 1, blocking) == 0
    assert v.simxSetStringSignal(client, "speed", b"1", blocking) == 0
    return handles


@pytest.mark.parametrize("name", sorted(EXAMPLES.keys() - ELSEWHERE))
def test_an_example_succeeds(client: int, name: str) -> None:
    program = ModuleType("example")
    vars(program).update(prepare(client, name), vrep=v, client=client, buffer=v.simxCreateBuffer(16))
    exec(compile(EXAMPLES[name], f"docs/api.md {name}", "exec"), vars(program))
    # What is never blocking has no value yet.
    code = vars(program).get("code", vars(program).get("rc", 0))
    assert code == int(BY_NAME[name].never_blocking), v.simxGetLastErrors(client, v.simx_opmode_blocking)
