"""`simx:mount`: a gripper that a scene includes beside an arm hangs on the arm from the start."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from model_checks import load_model, position_of
from real_world import BLOCKING, RealWorld, handle_of, start_stepped, step

import simx_client as vrep
from simx_server.scene.formats.loader import SceneError, load_text

pytestmark = pytest.mark.slow

SCENE = """
<mujoco>
  <worldbody>
    <body name="arm" pos="0 0 1">
      <geom size="0.05"/>
      <body name="link">
        <joint name="elbow" axis="0 1 0"/>
        <geom type="capsule" size="0.02" fromto="0 0 0 0.3 0 0" mass="1"/>
        <site name="flange" pos="0.3 0 0" zaxis="1 0 0"/>
      </body>
    </body>
    <body name="tool" pos="0 2 0.1">
      <freejoint/>
      <geom type="box" size="0.01 0.01 0.05" mass="0.1"/>
      <body name="finger" pos="0 0 0.05"><joint name="grip" type="slide"/><geom size="0.01" mass="0.01"/></body>
    </body>
  </worldbody>
  <sensor><force site="flange"/><jointpos joint="grip"/></sensor>
  <actuator><velocity name="grip" joint="grip" kv="10"/></actuator>
  <custom>
    <text name="simx:model:arm" data="base=yes"/>
    <text name="simx:joint:elbow" data="mode=force motor=on control=position max_force=100"/>
    <text name="simx:mount:tool" data="on=flange ahead=0.05"/>
  </custom>
</mujoco>
"""


@pytest.fixture
def open_scene(tmp_path: Path) -> Iterator[Callable[[str], tuple[RealWorld, int]]]:
    opened: list[RealWorld] = []

    def open_file(text: str) -> tuple[RealWorld, int]:
        file = tmp_path / "mounted.xml"
        file.write_text(text, encoding="utf-8")
        opened.append(RealWorld(file))
        return opened[-1], opened[-1].client()

    yield open_file
    for each in opened:
        each.close()


def test_mounted_tool_stays_on_the_arm_until_it_gets_another_parent(
    open_scene: Callable[[str], tuple[RealWorld, int]],
) -> None:
    _, client = open_scene(SCENE)
    tool, link = handle_of(client, "tool"), handle_of(client, "link")
    assert vrep.simxGetObjectParent(client, tool, BLOCKING) == (vrep.simx_return_ok, link)
    assert position_of(client, tool) == pytest.approx([0.35, 0, 1], abs=1e-6)
    assert position_of(client, handle_of(client, "finger")) == pytest.approx([0.4, 0, 1], abs=1e-6)
    start_stepped(client)
    vrep.simxSetJointTargetPosition(client, handle_of(client, "elbow"), 0.5, BLOCKING)
    step(client, 1.0)
    assert position_of(client, tool, link) == pytest.approx([0.35, 0, 0], abs=1e-6)
    height = position_of(client, tool)[2]
    assert vrep.simxSetObjectParent(client, tool, -1, True, BLOCKING) == vrep.simx_return_ok
    step(client, 0.2)
    assert position_of(client, tool)[2] < height - 0.1


def test_model_of_an_arm_with_a_mounted_tool_loads_twice(
    open_scene: Callable[[str], tuple[RealWorld, int]], tmp_path: Path
) -> None:
    _, client = open_scene("<mujoco><worldbody/></mujoco>")
    model = tmp_path / "armed.xml"
    model.write_text(SCENE, encoding="utf-8")
    for at in (0.0, 1.0):
        load_model(client, str(model), (at, 0.0))
    for suffix, x in (("", 0.35), ("#0", 1.35)):
        tool = handle_of(client, f"tool{suffix}")
        assert position_of(client, tool) == pytest.approx([x, 0, 1], abs=1e-6)
        assert vrep.simxGetObjectParent(client, tool, BLOCKING)[1] == handle_of(client, f"link{suffix}")


@pytest.mark.parametrize(
    ("name", "data", "complaint"),
    [
        ("finger", "on=flange", "at the top of the scene"),
        ("tool", "ahead=0.1", "needs on="),
        ("tool", "on=flanch", "'flanch' is none"),
        ("arm", "on=flange", "hangs on 'arm' itself"),
    ],
)
def test_mount_that_cannot_be_is_told(name: str, data: str, complaint: str) -> None:
    text = SCENE.replace('simx:mount:tool" data="on=flange ahead=0.05"', f'simx:mount:{name}" data="{data}"')
    with pytest.raises(SceneError, match=complaint):
        load_text(text)
