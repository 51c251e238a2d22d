"""A V-REP file's arm of 7 joints among obstacles: its joints in force mode, its collection against everything else."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from sim_api_calls import ScriptWorld
from vrep_samples import sample

from simx_server.editing.models import load_model
from simx_server.scene.poses.frames import get_pose, get_position, set_pose, set_position
from simx_server.sensors.distance import meeting

SCENE = """
<mujoco><option gravity="0 0 0"/><worldbody>
  <body name="owner" pos="0 0 9"><geom size="0.1"/></body>
  <body name="wall" pos="0 5 0" mocap="true"><geom type="box" size="2 0.01 2"/></body>
  <geom name="floor" type="plane" size="9 9 0.1" pos="0 0 -0.5"/>
</worldbody></mujoco>
"""
ANGLES = (0.3, 0.5, 0.2, 1.0, 0.1, 0.8, 0.0)
JOINTS = tuple(f"redundantRob_joint{number}" for number in range(1, 8))
TIP, TARGET = "redundantRob_tip", "redundantRob_target"
BEGIN = """
local js, g, all = {}, sim.getIkGroupHandle('redundantRobot_damped'), sim.getCollectionHandle('arm')
for i = 1, 7 do js[i] = sim.getObjectHandle('redundantRob_joint' .. i) end
"""


@pytest.fixture
def world(tmp_path: Path) -> Iterator[ScriptWorld]:
    """The tip is to move by 10 cm along y."""
    file = sample("7 DoF manipulator.ttm")
    world = ScriptWorld(tmp_path, SCENE, owner="owner", kind="customization")
    shutil.copy(file, tmp_path / "arm.ttm")
    load_model(world.parts, tmp_path / "arm.ttm")
    world.lua(
        """
        local arm = sim.createCollection('arm', 0)
        sim.addObjectToCollection(arm, sim.getObjectHandle('redundantRobot'), sim.handle_tree)
        for i = 1, 7 do
            sim.setJointMode(sim.getObjectHandle('redundantRob_joint' .. i), sim.jointmode_force, 0)
        end
        """
    )
    put(world, ANGLES)
    (x, y, z), turn = get_pose(world.sim, world.handle(TIP))
    set_pose(world.sim, world.handle(TARGET), -1, ((x, y + 0.1, z), turn))
    yield world
    world.parts.scripts.close()


def put(world: ScriptWorld, values: Any) -> None:
    for name, value in zip(JOINTS, values, strict=True):
        world.sim.joints.set_position(world.handle(name), value)
    world.sim.refresh()


def reached(world: ScriptWorld, values: list[float]) -> list[float]:
    """Where the tip is in the target's frame, with the joints there."""
    put(world, values)
    return list(get_position(world.sim, world.handle(TIP), world.handle(TARGET)))


AT_TARGET = pytest.approx([0.0, 0.0, 0.0], abs=1e-3)


def test_a_line_is_followed_unless_something_stands_in_its_way(world: ScriptWorld) -> None:
    line = BEGIN + "return (sim.generateIkPath(g, js, 50, {all, sim.handle_all}))"
    (free,) = world.lua(line)
    assert len(free) == 7 * 50
    assert free[:7] == pytest.approx(ANGLES, abs=1e-3)
    x, y, z = get_position(world.sim, world.handle(TARGET))
    set_position(world.sim, world.handle("wall"), -1, (x, y + 0.05, z))
    assert world.lua(line) == [None]
    set_position(world.sim, world.handle("wall"), -1, (x, y + 5.0, z))
    assert world.lua(line) == [free]
    assert reached(world, free[-7:]) == AT_TARGET


def test_a_search_finds_only_configurations_that_touch_nothing(world: ScriptWorld) -> None:
    search = BEGIN + "return (sim.getConfigForTipPose(g, js, 0.65, 5000, nil, {all, sim.handle_all}))"
    (found,) = world.lua(search)
    assert reached(world, found) == AT_TARGET
    assert world.value("sim.checkCollision(sim.getCollectionHandle('arm'), sim.handle_all)") == 0
    set_position(world.sim, world.handle("wall"), -1, get_position(world.sim, world.handle(TARGET)))
    assert world.lua(search.replace("5000", "100")) == [None]


def test_boxes_leave_out_nearly_all_shapes_of_a_path(
    world: ScriptWorld, monkeypatch: pytest.MonkeyPatch
) -> None:
    measured: list[int] = []
    meet = meeting.geoms_meet

    def counted(instant: Any, first: int, second: int, margin: float = 0.0) -> bool:
        measured.append(first)
        return meet(instant, first, second, margin)

    monkeypatch.setattr(meeting, "geoms_meet", counted)
    assert world.lua(BEGIN + "return (sim.generateIkPath(g, js, 50, {all, sim.handle_all}))") != [None]
    assert len(measured) < 50
