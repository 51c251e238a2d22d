"""The simulator's own modules for paths and conveyors of CoppeliaSim 4."""

from __future__ import annotations

from pathlib import Path

import pytest
from handler_calls import World
from sim_api_calls import ScriptWorld

SCENE = """
<mujoco>
  <option timestep="0.005"/>
  <worldbody>
    <geom type="plane" size="9 9 0.1"/>
    <body name="host"><geom size="0.01" contype="0" conaffinity="0"/></body>
    <body name="belt" pos="0 0 0.5">
      <body name="pad"><geom type="box" size="2 0.2 0.05"/></body>
      <site name="first" pos="-1 0 0"/>
      <site name="second" pos="1 0 0"/>
    </body>
    <body name="box" pos="0 0 0.6"><freejoint/><geom type="box" size="0.05 0.05 0.05" mass="1"/></body>
  </worldbody>
  <custom>
    <text name="simx:script:belt" data="file=belt.lua type=customization"/>
  </custom>
</mujoco>
"""

PATH = """
path = require 'path_customization'
shaped = 0

function path.refreshTrigger(points, data, info) shaped = shaped + 1 end

function sysCall_init()
    local own = sim.getObject('.')
    if not sim.readCustomDataBlock(own, 'ABC_PATH_INFO') then
        local info = { bitCoded = %d, pointCnt = 5, smoothing = 0, autoOrientation = 1, upVector = { 0, 0, 1 } }
        sim.writeCustomDataBlock(own, 'ABC_PATH_INFO', sim.packTable(info))
        for i, name in ipairs { 'second', 'first' } do
            local data = sim.packTable { handle = sim.getObject('/' .. name), index = 3 - i }
            sim.writeCustomDataBlock(sim.getObject('/' .. name), 'ABC_PATHCTRLPT', data)
        end
    end
    path.init()
end
"""

CONVEYOR = """
conveyor = require 'conveyor_customization-2'
function sysCall_init() conveyor.init { targetVel = 0.2, accel = 10 } end
"""

POINTS = "sim.unpackDoubleTable(sim.readCustomDataBlock(sim.getObject('/belt'), 'PATH'))"


def world_with(folder: Path, script: str) -> ScriptWorld:
    (folder / "belt.lua").write_text(script, encoding="utf-8")
    return ScriptWorld(folder, SCENE, owner="host")


def x_of(world: World, name: str) -> float:
    return world.call("simxGetObjectPosition", world.handle(name), -1)[0]


def test_a_path_has_its_points_as_data_and_follows_its_control_points(tmp_path: Path) -> None:
    world = world_with(tmp_path, PATH % 0)
    assert world.value(POINTS)[::7] == pytest.approx([-1, -0.5, 0, 0.5, 1])
    world.lua("sim.setObjectPosition(sim.getObject('/second'), -1, {3, 0, 0.5})")
    world.passes(2)
    assert world.value(POINTS)[::7] == pytest.approx([-1, 0, 1, 2, 3])
    world.lua("sim.setObjectPosition(sim.getObject('/belt'), -1, {5, 0, 0.5})")
    world.passes(2)
    assert world.value(POINTS)[::7] == pytest.approx([-1, 0, 1, 2, 3]), "they move with the path"


def test_points_are_turned_along_the_way_where_the_path_says_so(tmp_path: Path) -> None:
    world = world_with(tmp_path, PATH % 16)
    world.lua("sim.setObjectPosition(sim.getObject('/second'), -1, {-1, 2, 0.5})")
    world.passes(2)
    # Mode 1: x along the path, which goes along y, and z upwards.
    assert world.value(POINTS)[3:7] == pytest.approx([0, 0, 0.5**0.5, 0.5**0.5])


def test_the_line_of_a_path_is_drawn_again_after_each_run(tmp_path: Path) -> None:
    world = world_with(tmp_path, PATH % 0)
    ((_, items),) = world.parts.drawings.shown()
    assert len(items) == 4
    assert items[0] == pytest.approx((-1, 0, 0.5, -0.5, 0, 0.5))
    world.call("simxStopSimulation")
    world.parts.idle()
    assert [len(items) for _, items in world.parts.drawings.shown()] == [4]


def test_a_script_is_told_when_points_were_computed(tmp_path: Path) -> None:
    world = world_with(tmp_path, PATH % 0)
    told = "return sim.callScriptFunction('told@/belt', sim.scripttype_customizationscript)"
    (tmp_path / "belt.lua").write_text(PATH % 0 + "\nfunction told() return shaped end", encoding="utf-8")
    world = ScriptWorld(tmp_path, SCENE, owner="host")
    assert world.lua(told) == [1]
    world.lua("sim.setObjectPosition(sim.getObject('/second'), -1, {3, 0, 0.5})")
    world.passes(2)
    assert world.lua(told) == [2]


def test_a_conveyor_moves_a_box_at_the_velocity_that_a_program_sets(tmp_path: Path) -> None:
    world = world_with(tmp_path, CONVEYOR)
    world.passes(40)
    assert x_of(world, "box") == pytest.approx(0.2 * 2, abs=0.03)
    state = "sim.unpackTable(sim.readCustomDataBlock(sim.getObject('/belt'), '__state__'))"
    assert world.value(state) == {"vel": 0.2, "pos": pytest.approx(0.4, abs=0.02)}
    world.lua("sim.writeCustomDataBlock(sim.getObject('/belt'), '__ctrl__', sim.packTable({vel = 0}))")
    world.passes(5)
    before = x_of(world, "box")
    world.passes(10)
    assert x_of(world, "box") == pytest.approx(before, abs=1e-3)
    world.lua("sim.writeCustomDataBlock(sim.getObject('/belt'), '__ctrl__', sim.packTable({pos = 0.5}))")
    world.passes(30)
    assert world.value(state + ".pos") == pytest.approx(0.5)
    after = x_of(world, "box")
    world.passes(5)
    assert x_of(world, "box") == pytest.approx(after, abs=2e-3)


@pytest.mark.parametrize(
    "name",
    [
        "models.path_customization-2",
        "conveyor_customization",
        "conveyorSystem_customization-2",
        "models.conveyor_customization-3",
        "models.efficientConveyor_customization-3",
    ],
)
def test_other_names_mean_the_same_modules(tmp_path: Path, name: str) -> None:
    world = world_with(tmp_path, "")
    same = "path_customization" if "path" in name else "conveyor_customization-2"
    assert world.lua(f"return require('{name}') == require('{same}')") == [True]
